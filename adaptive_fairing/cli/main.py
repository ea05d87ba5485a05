"""The program: ``adaptive-fairing``, ``python -m`` and ``blender -c adaptive_fairing``.

Exit status: 0 done; 1 could not (file, mesh or solver); 2 wrong arguments. Errors are one line on
standard error that says what to do; standard output stays empty.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from ..batch.conflicts import identity
from ..batch.memory_use import address_space_bytes, in_gigabytes
from .apart import (
    CHILD,
    CrashError,
    follow_parent,
    keep_to_own_messages,
    run_apart,
)
from .arguments import parse
from .interrupts import ignore_interrupts
from .messages import fail
from .runs import run, serve
from .status import COULD_NOT, DONE, INTERRUPTED, WRONG_ARGUMENTS

WORKER = "--worker"
"""The only argument of a worker process."""

PYTHONS_WITH_BPY = (3, 11), (3, 13)
"""Versions of Python that Blender exists for as a module, as in pyproject.toml."""

ADDRESS_SPACE = 1_000_000_000
"""Blender as a module takes 1.4 GB on Linux (measured). With far less, libraries that it loads wait
for memory endlessly."""


def main(
    argv: Sequence[str] | None = None,
    *,
    worker_command: Sequence[str] | None = None,
    is_apart: bool = False,
) -> int:
    """Run the program.

    Parameters
    ----------
    argv
        Arguments without the program's name; None takes those of this process.
    worker_command
        Command that starts the program. `WORKER` or `CHILD` is added to it, to start a process
        that does the work. None takes the Python that is running.
    is_apart
        Whether a single mesh, too, is processed in a separate process, so that a crash of Blender
        is reported in one line.

    Returns
    -------
    int
        Exit status.
    """
    given = list(sys.argv[1:] if argv is None else argv)
    if given == [WORKER]:
        return serve()
    is_child = given[:1] == [CHILD]
    if is_child:
        follow_parent()
        keep_to_own_messages()
        del given[0]
    try:
        arguments = parse(given)
    except SystemExit as request:  # argparse ends the process after --help and after an error
        return int(request.code or DONE)
    space = address_space_bytes()
    if space is not None and space < ADDRESS_SPACE:
        return fail(
            f"the address space is limited to {in_gigabytes(space)} (ulimit -v), and Blender takes "
            f"{in_gigabytes(ADDRESS_SPACE)} when it starts"
        )
    if not arguments.plan and not arguments.input.exists():  # told before Blender takes its time
        return fail(f"cannot read {arguments.input}: there is no such file")
    command = list(worker_command or (sys.executable, "-m", "adaptive_fairing"))
    before = None if arguments.plan else identity(arguments.output)
    try:
        if is_apart and not is_child and not arguments.plan:
            status = _run_apart(arguments, [*command, CHILD, *given])
        else:
            status = _run_here(arguments, [*command, WORKER], is_apart)
        ignore_interrupts()
    except KeyboardInterrupt:
        status = INTERRUPTED
    if status == INTERRUPTED and not is_child:  # for a child, its parent reports it
        is_written = before is not None and identity(arguments.output) != before
        fail(f"interrupted: {_what_is_kept(arguments, is_written)}")
    return status


def _what_is_kept(arguments: argparse.Namespace, is_written: bool) -> str:
    if arguments.plan:
        return "finished outputs stay, run again to continue"
    return f"{arguments.output} was already written" if is_written else "no output was written"


def _run_here(arguments: argparse.Namespace, worker_command: Sequence[str], is_apart: bool) -> int:
    try:
        return run(arguments, worker_command)
    except ModuleNotFoundError as error:
        if error.name not in ("bpy", *_MISSING):
            raise
        return fail(_MISSING.get(error.name) or _without_blender())
    except MemoryError:
        return fail("not enough memory for this mesh: decimate it, or use a larger machine")
    except Exception as error:
        if not is_apart or sys.flags.dev_mode:
            raise
        return fail(f"unexpected {type(error).__name__}: {error} (python -X dev shows where)")


def _run_apart(arguments: argparse.Namespace, command: Sequence[str]) -> int:
    from ..files.atomic_files import remove_drafts

    try:
        status = run_apart(command, (DONE, COULD_NOT, WRONG_ARGUMENTS, INTERRUPTED))
        if status == INTERRUPTED:  # perhaps killed
            remove_drafts(arguments.output)
        return status
    except CrashError as error:
        remove_drafts(arguments.output)
        return fail(
            f"Blender or the solver crashed on {arguments.input}, its process ended {error}: the "
            "file is damaged, or there is too little memory"
        )


def _without_blender() -> str:
    """Message that says how to get Blender, which exists for two versions of Python."""
    version = sys.version_info[:2]
    if version in PYTHONS_WITH_BPY:
        return 'Blender is missing: pip install bpy, or the extra "blender" of this package'
    known = " and ".join(f"{major}.{minor}" for major, minor in PYTHONS_WITH_BPY)
    return (
        f"Blender is missing: its module bpy exists for Python {known}, and this is {version[0]}."
        f"{version[1]}; install into one of those"
    )


_MISSING = {
    "numpy": "numpy is missing: pip install numpy",
    "scipy": "scipy is missing: pip install scipy, or install the extension with its wheels",
}
