"""Runs of the commands, from checked arguments to the line that sums up.

numpy, scipy and Blender take a second to import. --help and the message on a typo do not wait for
that, so the functions here import them.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ..batch.summary import outcome_of
from . import batch
from .arguments import settings_of
from .interrupts import raise_at_interrupt
from .messages import PROGRAM, fail, say
from .options import FAIR, REFINE
from .status import DONE, WRONG_ARGUMENTS

if TYPE_CHECKING:
    from ..core import DenoiseSettings, FairingSettings

Report = dict[str, Any]


def run(arguments: argparse.Namespace, worker_command: Sequence[str]) -> int:
    """Do what the arguments ask for, report the outcome, and return the exit status.

    Parameters
    ----------
    arguments
        As `parse` returns them.
    worker_command
        Command that starts a worker process of a batch.
    """
    from ..core import FairingError, SettingsError

    try:
        if arguments.plan:
            return _run_batch(arguments, worker_command)
        report, summary = _run_single(arguments)
    except SettingsError as error:
        page = f"{PROGRAM} {arguments.algorithm} --help"
        return fail(f"{error} (see {page})", WRONG_ARGUMENTS)
    except (FairingError, OSError) as error:
        return fail(str(error))
    if not arguments.quiet:
        for note in report["notes"]:
            say(f"note: {note}")
        say(f"{report['written']['vertices']} vertices, {summary}; wrote {report['output']}")
    return DONE


def serve() -> int:
    """Work as a process of a batch until the batch ends."""
    from ..silence import silent_output

    with silent_output():
        from ..blender.jobs.batch_worker import serve

    raise_at_interrupt()
    serve()
    return DONE


def _run_single(arguments: argparse.Namespace) -> tuple[Report, str]:
    if arguments.algorithm == REFINE:
        return _refine(arguments)
    settings = settings_of(arguments)
    if arguments.algorithm == FAIR and arguments.attribute is not None:
        return _fair_attribute(arguments, settings)
    return _smooth(arguments, settings)


def _smooth(
    arguments: argparse.Namespace, settings: DenoiseSettings | FairingSettings
) -> tuple[Report, str]:
    from ..silence import silent_output
    from .progress import part_progress, step_progress

    with silent_output():  # Blender logs from its very first moment
        from ..blender.jobs.file_job import FairingJob, run_job

    raise_at_interrupt()
    is_fair = arguments.algorithm == FAIR
    job = FairingJob(
        arguments.input,
        arguments.output,
        settings,
        arguments.object,
        arguments.report,
        refine=batch.refinement(arguments),
        denoised_beside=is_fair and not arguments.no_denoised,
    )
    show = not arguments.quiet and sys.stderr.isatty()
    with (
        step_progress(getattr(settings, "steps", 0), enabled=show and is_fair) as on_step,
        part_progress(enabled=show) as on_fraction_done,
    ):
        report = run_job(job, on_step, on_fraction_done=on_fraction_done)
    return report, _outcome(report)


def _refine(arguments: argparse.Namespace) -> tuple[Report, str]:
    from ..silence import silent_output

    with silent_output():
        from ..blender.jobs.mesh_change import Files, refine_file

    raise_at_interrupt()
    levels = 0 if arguments.limit else arguments.levels
    files = Files(arguments.input, arguments.output, arguments.object, arguments.report)
    report = refine_file(files, levels)
    return report, f"refined {levels} times" if levels else "on the limit surface"


def _fair_attribute(
    arguments: argparse.Namespace, settings: DenoiseSettings | FairingSettings
) -> tuple[Report, str]:
    from ..core import FairingSettings
    from ..silence import silent_output

    with silent_output():
        from ..blender.jobs.mesh_change import Files, fair_attribute_of_file

    raise_at_interrupt()
    assert isinstance(settings, FairingSettings)
    files = Files(arguments.input, arguments.output, arguments.object, arguments.report)
    report = fair_attribute_of_file(files, arguments.attribute, settings)
    return report, f"{arguments.attribute} faired, {settings.steps} steps"


def _run_batch(arguments: argparse.Namespace, worker_command: Sequence[str]) -> int:
    settings = settings_of(arguments)
    raise_at_interrupt()
    account, problem = batch.run_plan(arguments, settings, worker_command)
    if not arguments.quiet:
        say(batch.describe(account))
    if problem is None:
        return DONE
    if arguments.allow_failures:
        say(f"note: {problem}")
        return DONE
    return fail(problem)


_ENDS = {
    "steps": "all done",
    "curvature": "ended by --stop-curvature",
    "rate": "ended by --stop-rate",
}


def _outcome(report: Report) -> str:
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
        f"{how}, curvature energy {outcome['curvature_ratio']:.3g} times the input's, "
        f"largest displacement {outcome['largest_displacement']:.3g}"
    )
