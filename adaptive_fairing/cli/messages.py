"""Messages to the user: one line each, on standard error."""

from __future__ import annotations

import contextlib
import sys
from typing import TextIO

from .status import COULD_NOT

PROGRAM = "adaptive-fairing"


def say(text: str) -> None:
    """Write a message to standard error, even if nobody reads it."""
    write_line(f"{PROGRAM}: {text}", sys.stderr)


def fail(message: str, status: int = COULD_NOT) -> int:
    """Report why something could not be done, and return the exit status."""
    say(f"error: {message}")
    return status


def write_line(text: str, stream: TextIO) -> None:
    """Write a text as one line, with any line ends and characters in it."""
    encoding = stream.encoding or "utf-8"
    line = " ".join(text.split()).encode(encoding, "backslashreplace").decode(encoding)
    with contextlib.suppress(OSError):  # nobody listens any more
        print(line, file=stream, flush=True)
