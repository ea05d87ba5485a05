"""Keep Blender's own chatter out of the program's standard output."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout


@contextmanager
def silent_stdout() -> Iterator[None]:
    """Send whatever is written to standard output to nowhere, by C code as well as by Python.

    Some notes of importers and exporters go through ``sys.stdout``; others, such as "OBJ import
    took 3 ms", are printed by C, so the file descriptor itself is turned round for a while. Errors
    are not lost: Blender's operators raise them, and standard error stays as it is.
    """
    _flush()
    kept = os.dup(1)
    try:
        with open(os.devnull, "w") as nowhere, redirect_stdout(nowhere):
            os.dup2(nowhere.fileno(), 1)
            try:
                yield
            finally:
                _flush()
                os.dup2(kept, 1)
    finally:
        os.close(kept)


def _flush() -> None:
    """Write out what Python and the C library hold back, to where it still belongs."""
    if sys.stdout is not None:
        sys.stdout.flush()
    library = ctypes.CDLL("ucrtbase" if sys.platform == "win32" else None)
    library.fflush(None)
