"""The program: ``adaptive-fairing``, ``python -m`` and ``blender -c adaptive_fairing``.

Exit status: 0 done; 1 could not (file, mesh or solver); 2 wrong arguments. Errors are one line on
standard error that says what to do; standard output stays empty.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import Any

from ..batch.conflicts import identity
from ..batch.memory_use import address_space_bytes, in_gigabytes
from ..batch.summary import outcome_of
from . import batch
from .apart import (
    CHILD,
    CrashError,
    follow_parent,
    keep_to_own_messages,
    run_apart,
)
from .arguments import parse, settings_of
from .interrupts import INTERRUPTED, ignore_interrupts, raise_at_interrupt
from .messages import PROGRAM, say
from .options import FAIR, REFINE
from .parser import WRONG_ARGUMENTS

DONE, COULD_NOT = 0, 1
WORKER = "--worker"
"""The only argument of a worker process."""

PYTHONS_WITH_BPY = (3, 11), (3, 13)
"""Versions of Python that Blender exists for as a module, as in pyproject.toml."""

ADDRESS_SPACE = 1_000_000_000
"""Blender takes 1.4 GB as a module on Linux (measured); with far less, libraries that it loads wait
for memory without end."""


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
        Arguments without the program's name; None takes those of the process.
    worker_command
        Starts the program, to which `WORKER` or `CHILD` is added, as a process that does the work;
        None for the Python that is running.
    is_apart
        Whether a single mesh, too, is faired in a process of its own, so that a crash of Blender
        is told in one line.

    Returns
    -------
    int
        Exit status.
    """
    given = list(sys.argv[1:] if argv is None else argv)
    if given == [WORKER]:
        return _serve()
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
        return _fail(
            f"the address space is limited to {in_gigabytes(space)} (ulimit -v), Blender takes "
            f"{in_gigabytes(ADDRESS_SPACE)} when it starts"
        )
    if not arguments.plan and not arguments.input.exists():  # told before Blender takes its time
        return _fail(f"cannot read {arguments.input}: there is no such file")
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
    if status == INTERRUPTED and not is_child:  # of a child its parent tells
        is_written = before is not None and identity(arguments.output) != before
        _fail(f"interrupted: {_what_is_kept(arguments, is_written)}")
    return status


def _what_is_kept(arguments: argparse.Namespace, is_written: bool) -> str:
    if arguments.plan:
        return "what is finished stays, run again to go on"
    return f"{arguments.output} was written before" if is_written else "no output was written"


def _run_here(arguments: argparse.Namespace, worker_command: Sequence[str], is_apart: bool) -> int:
    try:
        if arguments.plan:
            return _run_batch(arguments, worker_command)
        is_change = arguments.algorithm == REFINE or _has_attribute(arguments)
        return _change(arguments) if is_change else _run(arguments)
    except ModuleNotFoundError as error:
        if error.name not in ("bpy", *_MISSING):
            raise
        return _fail(_MISSING.get(error.name) or _without_blender())
    except MemoryError:
        return _fail("not enough memory for this mesh: reduce it, or use a larger machine")
    except Exception as error:
        if not is_apart or sys.flags.dev_mode:
            raise
        return _fail(f"unexpected {type(error).__name__}: {error} (python -X dev shows where)")


def _run_apart(arguments: argparse.Namespace, command: Sequence[str]) -> int:
    from ..files.atomic_files import remove_drafts

    try:
        status = run_apart(command, (DONE, COULD_NOT, WRONG_ARGUMENTS, INTERRUPTED))
        if status == INTERRUPTED:  # perhaps killed
            remove_drafts(arguments.output)
        return status
    except CrashError as error:
        remove_drafts(arguments.output)
        return _fail(
            f"Blender or the solver died of {arguments.input}, ended {error}: the file is damaged, "
            "or there is too little memory"
        )


def _without_blender() -> str:
    """Say how to get Blender, which exists for two versions of Python."""
    version = sys.version_info[:2]
    if version in PYTHONS_WITH_BPY:
        return 'Blender is missing: pip install bpy, or the extra "blender" of this package'
    known = " and ".join(f"{major}.{minor}" for major, minor in PYTHONS_WITH_BPY)
    return (
        f"Blender is missing: its module bpy exists for Python {known}, this is {version[0]}."
        f"{version[1]}; install into one of those"
    )


_MISSING = {
    "numpy": "numpy is missing: pip install numpy",
    "scipy": "scipy is missing: pip install scipy, or install the extension with its wheels",
}


def _run(arguments: argparse.Namespace) -> int:
    # Imported late: numpy, scipy and Blender take a second, which --help and typos need not wait.
    from ..core import DenoiseSettings, FairingError, SettingsError

    try:
        settings = settings_of(arguments)
    except SettingsError as error:
        return _wrong_settings(arguments, error)

    from ..silence import silent_output
    from .progress import part_progress, step_progress

    with silent_output():  # Blender logs from its very first moment
        from ..blender.jobs.file_job import FairingJob, run_job

    raise_at_interrupt()
    job = FairingJob(
        arguments.input,
        arguments.output,
        settings,
        arguments.object,
        arguments.report,
        refine=batch.refinement(arguments),
        denoised_beside=arguments.algorithm == FAIR and not arguments.no_denoised,
    )
    show = not arguments.quiet and sys.stderr.isatty()
    try:
        if isinstance(settings, DenoiseSettings):
            with part_progress(enabled=show) as on_progress:
                report = run_job(job, on_progress=on_progress)
        else:
            with step_progress(settings.steps, enabled=show) as on_step:
                report = run_job(job, on_step)
    except (FairingError, OSError) as error:
        return _fail(str(error))
    _tell(arguments, report, _summary(report))
    return DONE


def _change(arguments: argparse.Namespace) -> int:
    """Refine a mesh, or fair an attribute of it."""
    from ..core import FairingError, FairingSettings, SettingsError
    from ..silence import silent_output

    settings = None
    if arguments.algorithm == FAIR:
        try:
            settings = settings_of(arguments)
        except SettingsError as error:
            return _wrong_settings(arguments, error)
    with silent_output():
        from ..blender.jobs.mesh_change import Files, fair_attribute_of_file, refine_file

    raise_at_interrupt()
    files = Files(arguments.input, arguments.output, arguments.object, arguments.report)
    try:
        if isinstance(settings, FairingSettings):
            report = fair_attribute_of_file(files, arguments.attribute, settings)
            what = f"{arguments.attribute} faired, {settings.steps} steps"
        else:
            levels = 0 if arguments.limit else arguments.levels
            report = refine_file(files, levels)
            what = f"refined {levels} times" if levels else "on the limit surface"
    except (FairingError, OSError) as error:
        return _fail(str(error))
    _tell(arguments, report, f"{_size(report)}, {what}; wrote {report['output']}")
    return DONE


def _has_attribute(arguments: argparse.Namespace) -> bool:
    return arguments.algorithm == FAIR and arguments.attribute is not None


def _tell(arguments: argparse.Namespace, report: dict[str, Any], summary: str) -> None:
    if not arguments.quiet:
        for note in report["notes"]:
            say(f"note: {note}")
        say(summary)


def _run_batch(arguments: argparse.Namespace, worker_command: Sequence[str]) -> int:
    from ..core import FairingError, SettingsError

    try:
        settings = settings_of(arguments)
    except SettingsError as error:
        return _wrong_settings(arguments, error)
    raise_at_interrupt()
    try:
        account, problem = batch.run_plan(arguments, settings, worker_command)
    except (FairingError, OSError) as error:
        return _fail(str(error))
    if not arguments.quiet:
        say(batch.describe(account))
    if problem is None:
        return DONE
    if arguments.allow_failures:
        say(f"note: {problem}")
        return DONE
    return _fail(problem)


def _serve() -> int:
    from ..silence import silent_output

    with silent_output():
        from ..blender.jobs.batch_worker import serve

    raise_at_interrupt()
    serve()
    return DONE


_ENDS = {
    "steps": "all done",
    "curvature": "ended by --stop-curvature",
    "rate": "ended by --stop-rate",
}


def _summary(report: dict[str, Any]) -> str:
    outcome = outcome_of(report)
    if report["denoise"] is not None:
        how = (
            f"noise {outcome['noise']:.3g}, smoothing radius {outcome['radius']:.3g} local edge "
            "lengths"
        )
    else:
        end = _ENDS[report["stop_reason"]]
        how = f"{outcome['step']} steps ({end}), tau {outcome['tau']:.3g}"
    return (
        f"{_size(report)}, {how}, curvature energy "
        f"{outcome['curvature_ratio']:.3g} times the input's, largest displacement "
        f"{outcome['largest_displacement']:.3g}; wrote {report['output']}"
    )


def _size(report: dict[str, Any]) -> str:
    """Count the mesh that was written."""
    return f"{report['written']['vertices']} vertices"


def _wrong_settings(arguments: argparse.Namespace, error: Exception) -> int:
    return _fail(f"{error} (see {PROGRAM} {arguments.algorithm} --help)", WRONG_ARGUMENTS)


def _fail(message: str, status: int = COULD_NOT) -> int:
    say(f"error: {message}")
    return status
