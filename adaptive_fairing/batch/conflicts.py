"""Conflicts of paths: an output that would replace an input or another output."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

from .inputs import ArgumentsError


class Pair(NamedTuple):
    """A file to read, and the file that is made from it."""

    input: Path
    output: Path


def require_no_conflict(
    pairs: Sequence[Pair],
    *,
    reports: Iterable[Path] = (),
    records: Iterable[Path] = (),
    may_overwrite: bool = False,
) -> None:
    """Check that no output replaces an input or another output.

    A link counts as the file that it leads to.

    Parameters
    ----------
    pairs
        Inputs and outputs.
    reports
        Other files to write; they never replace an input or an output.
    records
        Files that only the program itself may write.
    may_overwrite
        Whether an output may replace its own input.

    Raises
    ------
    ArgumentsError
        One does; the message names it.
    """
    inputs = {identity(pair.input): pair.input for pair in pairs}
    outputs: dict[object, Pair] = {}
    for pair in pairs:
        place = identity(pair.output)
        if place in inputs and not (may_overwrite and place == identity(pair.input)):
            own = place == identity(pair.input)
            raise ArgumentsError(
                f"{pair.output} is {'the' if own else 'another'} input"
                + (": choose another output, or add --overwrite-inputs" if own else "")
            )
        other = outputs.setdefault(place, pair)
        if other.input != pair.input and other.output != pair.output:
            raise ArgumentsError(f"{other.output} and {pair.output} are one file")
    taken = {**inputs, **{place: pair.output for place, pair in outputs.items()}}
    taken |= {identity(path): path for path in records}
    for path in reports:
        if identity(path) in taken:
            raise ArgumentsError(f"{path} is an input or another result: choose another name")


def identity(path: Path) -> object:
    """Key that is equal for two names of one file, whether or not the file exists."""
    try:
        status = os.stat(path)
    except (OSError, ValueError):
        return os.path.normcase(os.path.realpath(path))
    return status.st_dev, status.st_ino
