"""Messages to the user: one line each, on standard error."""

from __future__ import annotations

import contextlib
import sys

PROGRAM = "adaptive-fairing"


def say(text: str) -> None:
    """Write a message, whatever line ends it holds, and whether or not somebody listens."""
    with contextlib.suppress(OSError):
        print(f"{PROGRAM}: {one_line(text)}", file=sys.stderr, flush=True)


def one_line(text: str) -> str:
    """Put a text, such as a message of a library or the name of a file, into one line."""
    return " ".join(text.split())
