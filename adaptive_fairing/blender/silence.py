"""Keep Blender's own chatter out of the program's standard output."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def silent_stdout() -> Iterator[None]:
    """Send whatever is written to standard output to nowhere, by C code as well as by Python.

    Importers and exporters print notes such as "OBJ import took 3 ms" through C, past
    ``sys.stdout``; so the file descriptor itself is turned round for a while. Errors are not lost:
    Blender's operators raise them, and standard error stays as it is.
    """
    _flush()
    kept = os.dup(1)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 1)
        yield
    finally:
        _flush()
        os.dup2(kept, 1)
        os.close(nowhere)
        os.close(kept)


def _flush() -> None:
    """Write out what Python and the C library hold back, to where it still belongs."""
    if sys.stdout is not None:
        sys.stdout.flush()
    library = ctypes.CDLL("ucrtbase" if sys.platform == "win32" else None)
    library.fflush(None)
