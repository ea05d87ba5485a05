"""Shared test set-up: which ``adaptive_fairing`` the tests import. Must not import bpy.

The repository root is itself an importable package (its ``__init__.py`` is the entry point that
Blender asks for). A clone in a folder that happens to be called ``adaptive_fairing`` would thus
hide the real package behind that entry point; the root goes first on the search path and the
package is imported here, before pytest imports any test module, to settle the name.
"""

import atexit
import os
import sys
from pathlib import Path

import pytest

TESTS = Path(__file__).resolve().parent

for folder in (TESTS, TESTS.parent):  # the last one inserted is searched first
    sys.path.insert(0, str(folder))

import adaptive_fairing  # noqa: E402, F401  the search path has to be set before

exit_status: int | None = None


def leave() -> None:
    """End the process before the bpy module's C++ part is taken down.

    There the modules of Blender 4.5 and later sometimes wait for ever for a thread of their own,
    and that of 4.2 can crash: all after the tests, but the process would say nothing of them.
    """
    if exit_status is not None and "bpy" in sys.modules:
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        os._exit(exit_status)


atexit.register(leave)  # before bpy registers its own cleaning up, so it is called after that

# Tests start many processes. Where no bytecode is to be written beside the sources, each would
# compile the package anew, for a quarter of its time; so they share a folder of pytest's cache.
if os.environ.pop("PYTHONDONTWRITEBYTECODE", ""):
    os.environ.setdefault("PYTHONPYCACHEPREFIX", str(TESTS.parent / ".pytest_cache" / "bytecode"))
    sys.dont_write_bytecode, sys.pycache_prefix = False, os.environ["PYTHONPYCACHEPREFIX"]


def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """One process for paths that somebody names, some for all tests: each takes 1 GB with bpy."""
    if config.args_source is pytest.Config.ArgsSource.ARGS:
        return 0
    return min(os.cpu_count() or 1, 4)


def pytest_sessionfinish(session, exitstatus):
    global exit_status
    exit_status = int(exitstatus)
