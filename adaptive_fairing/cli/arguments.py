"""Meaning of the arguments of a run: checks, paths, settings."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ..batch.conflicts import Pair, require_no_conflict
from ..batch.inputs import ArgumentsError
from ..files.formats import BLEND, SUFFIXES, is_supported
from . import batch
from .options import DENOISE, ENDINGS, FAIR, REFINE, build_parsers, refuse_unknown, require_command

if TYPE_CHECKING:
    from ..core import DenoiseSettings, FairingSettings

MOST_STEPS = 100_000
"""More would not end in a lifetime; a .blend file stores a shape for each."""

OF_DENOISE = ("strength", "features", "clean", "width", "boundary", "max_deviation")
OF_FAIR = (
    "scheme",
    "radius",
    "tau",
    "steps",
    "density",
    "density_passes",
    "boundary",
    "stop_curvature",
    "stop_rate",
    "keep_volume",
    "max_deviation",
)
"""Arguments that are settings of the algorithm, under their names in the report."""

OF_SHAPES = ("keep_volume", "max_deviation", "stop_curvature", "stop_rate", "refine", "limit")


def parse(argv: Sequence[str] | None = None) -> argparse.Namespace:
    """Parse and check the arguments; an error ends the process with status 2, as argparse does.

    Besides the options the result has `algorithm`, which is the command, and `plan`, which is the
    batch or None.
    """
    words = list(sys.argv[1:] if argv is None else argv)
    program, parsers = build_parsers()
    require_command(program, words)
    arguments, unknown = program.parse_known_args(words)
    refuse_unknown(parsers, arguments.algorithm, unknown)
    try:
        _check(arguments)
    except ArgumentsError as error:
        parsers[arguments.algorithm].error(str(error))
    return arguments


def _check(arguments: argparse.Namespace) -> None:
    arguments.plan = None
    if arguments.algorithm == FAIR:
        _check_fair(arguments)
    if arguments.algorithm != REFINE:
        arguments.plan = batch.plan_of(arguments)
    for name in ("steps", "density_passes"):
        number = getattr(arguments, name, None)
        if number is not None and number > MOST_STEPS:
            raise ArgumentsError(f"--{name.replace('_', '-')} {number}: give at most {MOST_STEPS}")
    if arguments.plan is not None:
        if getattr(arguments, "attribute", None) is not None:
            raise ArgumentsError("--attribute is for a single mesh")
        return
    if len(arguments.input) > 1:  # only for refine, which has no batches
        raise ArgumentsError(f"refine takes one INPUT: did you mean -o {arguments.input[1]}?")
    arguments.input = Path(arguments.input[0])
    if arguments.output is None:
        arguments.output = default_output(arguments.input, arguments.algorithm)
    if arguments.input.is_dir():  # only for refine, again
        raise ArgumentsError(f"{arguments.input} is a folder: refine takes a file")
    for path in (arguments.input, arguments.output):
        if not is_supported(path):
            if path == arguments.input and not path.exists():
                raise ArgumentsError(f"{path}: there is no such file or folder")
            raise ArgumentsError(f"{path}: unknown kind of file; use one of {' '.join(SUFFIXES)}")
    require_no_conflict(
        [Pair(arguments.input, arguments.output)],
        reports=[arguments.report] if arguments.report is not None else [],
        may_overwrite=arguments.overwrite_inputs,
    )


def _check_fair(arguments: argparse.Namespace) -> None:
    if None not in (arguments.radius, arguments.tau):
        raise ArgumentsError("--tau and --radius both say how far to smooth: give one of them")
    if arguments.attribute is None:
        return
    for name in OF_SHAPES:
        if getattr(arguments, name) not in (None, False):
            option = f"--{name.replace('_', '-')}"
            raise ArgumentsError(f"{option} is for the shape, which --attribute does not change")


def default_output(source: Path, algorithm: str) -> Path:
    """Path of the result if none was given: a .blend file beside the input."""
    return source.with_name(f"{source.stem}{ENDINGS[algorithm]}{BLEND}")


def settings_of(arguments: argparse.Namespace) -> DenoiseSettings | FairingSettings:
    """Translate the arguments of `denoise` or `fair` into settings.

    Raises
    ------
    SettingsError
        A value is invalid.
    """
    from ..files.report import settings_of_record

    names = OF_DENOISE if arguments.algorithm == DENOISE else OF_FAIR
    values = {name: getattr(arguments, name) for name in names}
    given = {name: value for name, value in values.items() if value is not None}
    return settings_of_record({"algorithm": arguments.algorithm, "settings": given})
