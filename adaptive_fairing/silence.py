"""Silence for Blender's own output, so that the program's messages stand alone."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout

_STREAMS = (1, 2)


@contextmanager
def silent_output() -> Iterator[None]:
    """Send whatever is written to standard output and standard error to nowhere.

    Some notes of importers and exporters go through ``sys.stdout``; others, such as "OBJ import
    took 3 ms", are printed by C, so the file descriptors themselves are turned round for a while.
    Errors are not lost: Blender's operators raise them.
    """
    _flush()
    kept = [os.dup(each) for each in _STREAMS]
    try:
        with (
            open(os.devnull, "w") as nowhere,
            redirect_stdout(nowhere),
            redirect_stderr(nowhere),
        ):
            for each in _STREAMS:
                os.dup2(nowhere.fileno(), each)
            try:
                yield
            finally:
                _flush()
                for each, copy in zip(_STREAMS, kept, strict=True):
                    os.dup2(copy, each)
    finally:
        for copy in kept:
            os.close(copy)


def _flush() -> None:
    """Write out what Python and the C library hold back, to where it still belongs."""
    for stream in (sys.stdout, sys.stderr):
        if stream is not None:
            stream.flush()
    library = ctypes.CDLL("ucrtbase" if sys.platform == "win32" else None)
    library.fflush(None)
