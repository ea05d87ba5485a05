"""Parser of arguments with one-line errors that suggest the option meant."""

from __future__ import annotations

import argparse
import difflib
from collections.abc import Callable, Iterable
from typing import NoReturn

from .messages import fail
from .status import WRONG_ARGUMENTS


class Parser(argparse.ArgumentParser):
    """Options of one command."""

    def error(self, message: str) -> NoReturn:
        """End the process with one line that says what is wrong."""
        raise SystemExit(fail(f"{message} (see {self.prog} --help)", WRONG_ARGUMENTS))

    @property
    def option_names(self) -> list[str]:
        """All options as they are typed, such as ``--steps``."""
        return [name for action in self._actions for name in action.option_strings]


def one_of(*names: str) -> Callable[[str], str]:
    """Type of an argument that must be one of several words."""

    def check(text: str) -> str:
        if text in names:
            return text
        hint = did_you_mean(text, names) or f", choose from {', '.join(names)}"
        raise argparse.ArgumentTypeError(f"there is no {text!r}{hint}")

    return check


def did_you_mean(text: str, names: Iterable[str]) -> str:
    """End of a message that names the word probably meant; empty if none is similar."""
    bare = {name.lstrip("-"): name for name in names}
    found = difflib.get_close_matches(text.lstrip("-").lower(), bare, n=1)
    return f", did you mean {bare[found[0]]}?" if found else ""
