"""Options of the command line, their checks, and the settings that they mean."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from ..batch.conflicts import Pair, require_no_conflict
from ..batch.inputs import ArgumentsError
from ..files.formats import BLEND, SUFFIXES, is_supported
from ..version import program_version
from . import batch
from .messages import PROGRAM, say

if TYPE_CHECKING:
    from ..core import DenoiseSettings, FairingSettings

WRONG_ARGUMENTS = 2
"""Exit status."""

AUTO = "auto"
PAPER_METHODS = {
    "timestep": "adaptive_timestep",
    "tensor": "adaptive_tensor",
    "uniform": "uniform",
}
MOST_STEPS = 100_000
"""More would not end in a lifetime; each is a shape of its own in a .blend file."""

DENSITIES = {"edge": "edge_length", "area": "area"}

OF_AUTO = ("strength", "features", "clean")
OF_THE_PAPER = ("tau", "steps", "density", "density_passes", "stop_curvature", "stop_rate")
"""Arguments that belong to `--method auto`, or to the other methods."""


def parse(argv: Sequence[str] | None = None) -> argparse.Namespace:
    """Parse and check the arguments; an error ends the process with status 2, as argparse does."""
    parser = build_parser()
    arguments = parser.parse_args(argv)
    try:
        arguments.plan = batch.plan_of(arguments)
    except ArgumentsError as error:
        parser.error(str(error))
    for name in ("steps", "density_passes"):
        number = getattr(arguments, name)
        if number is not None and number > MOST_STEPS:
            parser.error(f"--{name.replace('_', '-')} {number}: give at most {MOST_STEPS}")
    misplaced = _misplaced(arguments)
    if misplaced is not None:
        parser.error(misplaced)
    if arguments.plan is not None:
        return arguments
    arguments.input = Path(arguments.input[0])
    if arguments.output is None:
        arguments.output = default_output(arguments.input)
    for path in (arguments.input, arguments.output):
        if not is_supported(path):
            parser.error(f"{path}: unknown kind of file; use one of {' '.join(SUFFIXES)}")
    try:
        require_no_conflict(
            [Pair(arguments.input, arguments.output)],
            reports=[arguments.report] if arguments.report is not None else [],
            may_overwrite=arguments.overwrite_inputs,
        )
    except ArgumentsError as error:
        parser.error(str(error))
    return arguments


def default_output(source: Path) -> Path:
    """Where the result goes if nobody says: a .blend file beside the input."""
    return source.with_name(f"{source.stem}_faired{BLEND}")


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are one line."""

    def error(self, message: str) -> NoReturn:
        say(f"error: {message} (see {PROGRAM} --help)")
        raise SystemExit(WRONG_ARGUMENTS)


def build_parser() -> argparse.ArgumentParser:
    """Make the parser."""
    parser = _Parser(
        prog=PROGRAM,
        allow_abbrev=False,  # an abbreviation would break when an option is added
        description="Remove noise from a surface mesh by geometric diffusion that follows the "
        "mesh density.",
        epilog="Exit status: 0 done, 1 could not (file, mesh or solver), 2 wrong arguments. "
        "If a later step fails, the steps before it are written and the status is 1.",
    )
    parser.add_argument(
        "input",
        nargs="+",
        metavar="INPUT",
        help=f"file with a mesh: {' '.join(SUFFIXES)}; or several files, folders and patterns, "
        "see below",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="OUTPUT",
        help="result: .blend (every step as a shape key, animated) or a mesh format (the last "
        "step); default: INPUT's name with _faired.blend, beside it",
    )
    parser.add_argument(
        "--object", metavar="NAME", help="mesh object to fair, if INPUT holds several"
    )
    parser.add_argument(
        "--method",
        choices=(AUTO, *PAPER_METHODS),
        default=AUTO,
        help="auto estimates the noise and removes it; the others are geometric diffusion, which "
        "follows the mesh density by the timestep, by the diffusion tensor, or not at all "
        "(default: %(default)s)",
    )
    parser.add_argument(
        "--strength",
        type=float,
        metavar="X",
        help="of auto: factor of the noise that it estimates (default: 1.0)",
    )
    parser.add_argument(
        "--features",
        choices=("auto", "sharp", "smooth"),
        help="of auto: whether there are creases to keep (default: auto, per place)",
    )
    parser.add_argument(
        "--clean",
        choices=("keep", "detail", "denoise"),
        help="of auto: leave a mesh alone that looks like a model without noise; also keep detail "
        "that looks like the smooth noise of a scanner; or take all that is rough for noise "
        "(default: keep)",
    )
    parser.add_argument(
        "--tau",
        type=float,
        metavar="T",
        help="of the others: time of a step, in the frame where the mesh fits [-3, 3]^3 "
        "(default: 0.016)",
    )
    parser.add_argument(
        "--steps", type=int, metavar="N", help="of the others: number of steps (default: 4)"
    )
    parser.add_argument(
        "--density",
        choices=tuple(DENSITIES),
        help="of the others: measure of the density: mean edge length or area around a vertex "
        "(default: edge)",
    )
    parser.add_argument(
        "--density-passes",
        type=int,
        metavar="N",
        help="of the others: smoothing passes over the density (default: 3)",
    )
    parser.add_argument(
        "--boundary",
        choices=("fixed", "free"),
        default="fixed",
        help="whether the rims of an open mesh stay or move along (default: %(default)s)",
    )
    parser.add_argument(
        "--stop-curvature",
        type=float,
        metavar="X",
        help="of the others: stop once the curvature energy is at most X times that of the input",
    )
    parser.add_argument(
        "--stop-rate",
        type=float,
        metavar="X",
        help="of the others: stop once the curvature energy, relative to that of the input, "
        "changes by at most X per unit of time",
    )
    parser.add_argument(
        "--refine",
        type=int,
        choices=(1, 2, 3),
        metavar="N",
        help="refine the result by N steps of Loop subdivision, 1 to 3, onto the smooth limit "
        "surface; edges marked sharp stay sharp",
    )
    parser.add_argument(
        "--limit",
        action="store_true",
        help="put the vertices of the result on the smooth limit surface, without new ones",
    )
    parser.add_argument(
        "--report", type=Path, metavar="FILE.json", help="write settings and measures as JSON"
    )
    parser.add_argument(
        "--overwrite-inputs", action="store_true", help="let a result replace its own input"
    )
    parser.add_argument("--quiet", action="store_true", help="show errors only")
    batch.add_options(parser)
    parser.add_argument("--version", action="version", version=f"%(prog)s {program_version()}")
    return parser


def _misplaced(arguments: argparse.Namespace) -> str | None:
    """Say which argument belongs to another method than the one that was chosen."""
    names: tuple[str, ...]
    if arguments.method == AUTO:
        names, owner = OF_THE_PAPER, f"--method {', '.join(PAPER_METHODS)}"
    else:
        names, owner = OF_AUTO, f"--method {AUTO}"
    for name in names:
        if getattr(arguments, name) is not None:
            option = name.replace("_", "-")
            return f"--{option} belongs to {owner}, not to --method {arguments.method}"
    return None


def settings_of(arguments: argparse.Namespace) -> DenoiseSettings | FairingSettings:
    """Translate the arguments into settings of the algorithm that they choose.

    Raises
    ------
    SettingsError
        A value makes no sense.
    """
    from ..core import DenoiseSettings, FairingSettings

    is_auto = arguments.method == AUTO
    values = {name: getattr(arguments, name) for name in (OF_AUTO if is_auto else OF_THE_PAPER)}
    given = {name: value for name, value in values.items() if value is not None}
    given["boundary"] = arguments.boundary
    if is_auto:
        return DenoiseSettings(**given)
    if "density" in given:
        given["density"] = DENSITIES[given["density"]]
    return FairingSettings(method=PAPER_METHODS[arguments.method], **given)
