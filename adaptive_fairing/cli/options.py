"""The commands of the program and their options.

Words and numbers of the core are repeated here as text, because `--help` must not need numpy.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..files.formats import SUFFIXES
from ..files.output_words import DENOISED, FAIRED, REFINED
from ..version import program_version
from .messages import PROGRAM
from .parser import Parser, did_you_mean, one_of

DENOISE, FAIR, REFINE = "denoise", "fair", "refine"

SUMMARIES = {
    DENOISE: "measure the noise of the mesh and remove it; needs no parameter",
    FAIR: "run the paper's method: geometric diffusion that follows the mesh density, step by step",
    REFINE: "subdivide the mesh onto the smooth limit surface, without fairing",
}

SCHEMES = ("timestep", "tensor", "uniform")
DENSITIES = ("edge", "area")

_HELP = f"""\
Remove noise from triangle meshes.

commands:
  denoise   {SUMMARIES[DENOISE]}
  fair      {SUMMARIES[FAIR]}
  refine    {SUMMARIES[REFINE]}

examples:
  {PROGRAM} denoise scan.ply                 writes scan_denoised.blend
  {PROGRAM} denoise scan.ply -o clean.ply --strength 1.5
  {PROGRAM} fair scan.ply -o steps.blend     every step a shape key, animated
  {PROGRAM} refine part.obj -o fine.obj --levels 2
  {PROGRAM} denoise "scans/*.ply" --out-dir clean --jobs 4

files: {" ".join(SUFFIXES)}

{PROGRAM} COMMAND --help shows the options of a command, --version the version.
Exit status: 0 done, 1 could not (file, mesh or solver), 2 wrong arguments.
"""


def build_parsers() -> tuple[Parser, dict[str, Parser]]:
    """Make the parser of the program, and the parser of each command by its name."""
    program = Parser(
        prog=PROGRAM,
        allow_abbrev=False,  # an abbreviation would break when an option is added
        usage=f"{PROGRAM} {{{','.join(SUMMARIES)}}} INPUT... [-o OUTPUT] [options]",
        description=_HELP,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        add_help=False,
    )
    program.add_argument("-h", "--help", action="help", help=argparse.SUPPRESS)
    version = f"%(prog)s {program_version()}"
    program.add_argument("--version", action="version", version=version, help=argparse.SUPPRESS)
    commands = program.add_subparsers(
        dest="algorithm", metavar="COMMAND", prog=PROGRAM, help=argparse.SUPPRESS
    )
    parsers: dict[str, Parser] = {}
    for name, summary in SUMMARIES.items():
        parsers[name] = parser = commands.add_parser(
            name,
            allow_abbrev=False,
            add_help=False,
            usage=f"%(prog)s INPUT{'' if name == REFINE else '...'} [-o OUTPUT] [options]",
            description=f"{summary[0].upper()}{summary[1:]}.",
        )
        parser.add_argument(
            "input",
            nargs="+",
            metavar="INPUT",
            help=f"file with a mesh: {' '.join(SUFFIXES)}"
            + ("" if name == REFINE else "; or several files, folders and patterns, see below"),
        )
        common = parser.add_argument_group("common options")
        _add_output(common, name)
        _OWN_OPTIONS[name](parser, common)
        _add_file_options(parser, name)
        if name != REFINE:
            _add_batch(parser, name)
            _add_sequence(parser)
    return program, parsers


def require_command(program: Parser, words: list[str]) -> None:
    """End with an error that names the commands, unless the first word is one or asks for help."""
    first = words[0] if words else None
    if first in SUMMARIES or first in ("-h", "--help", "--version"):
        return
    names = f"{DENOISE}, {FAIR} or {REFINE}"
    if first is None:
        program.error(f"say what to do: {names}, as in {PROGRAM} {DENOISE} scan.ply")
    is_word = Path(first).suffix == "" and not first.startswith("-")
    if is_word and not Path(first).exists():
        hint = did_you_mean(first, SUMMARIES) or f": say {names}"
        program.error(f"there is no command {first}{hint}")
    program.error(f"{first}: say first what to do: {names}, as in {PROGRAM} {DENOISE} scan.ply")


def refuse_unknown(parsers: dict[str, Parser], algorithm: str, words: Sequence[str]) -> None:
    """End with an error if there are words that the command does not take.

    argparse itself would not suggest what was meant.
    """
    parser = parsers[algorithm]
    option = next((word.partition("=")[0] for word in words if word.startswith("-")), None)
    if option is not None:
        owner = next((name for name in parsers if option in parsers[name].option_names), None)
        if owner is not None:
            parser.error(f"{option} belongs to {owner}, not to {algorithm}")
        parser.error(f"there is no {option}{did_you_mean(option, parser.option_names)}")
    if words:
        parser.error(f"{words[0]} stands apart: name all INPUTs one after the other")


def _add_output(group: Any, algorithm: str) -> None:
    contents = {
        DENOISE: ".blend (all strengths, as shape keys) or a mesh format (the chosen one)",
        FAIR: ".blend (every step as a shape key, animated) or a mesh format (the last step)",
        REFINE: ".blend or a mesh format",
    }[algorithm]
    group.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="OUTPUT",
        help=f"result: {contents}; default: INPUT's name with {ENDINGS[algorithm]}.blend",
    )


ENDINGS = {DENOISE: f"_{DENOISED}", FAIR: f"_{FAIRED}", REFINE: f"_{REFINED}"}
"""Endings that the default output adds to the name of the input."""


def _add_denoise(parser: Parser, common: Any) -> None:
    common.add_argument(
        "--strength",
        type=float,
        metavar="X",
        help="noise to remove, as a factor of the estimated noise (default: 1.0)",
    )
    _add_choice(
        common,
        "--features",
        ("auto", "sharp", "smooth"),
        help="whether the mesh has creases to keep (default: auto, decided for every part)",
    )
    _add_choice(
        common,
        "--clean",
        ("keep", "detail", "denoise"),
        help="keep: leave a mesh without noise alone; detail: also keep detail that looks like "
        "the smooth noise of a scanner; denoise: treat all roughness as noise (default: keep)",
    )
    common.add_argument(
        "--noise-width",
        dest="width",
        type=_auto_or_number,
        metavar="auto|EDGES",
        help="width of the noise, 1 to 16 edges: about half the size of its bumps, rather too "
        "large than too small; a number removes noise of that width even from a mesh that looks "
        "clean (default: auto)",
    )
    _add_max_deviation(common)
    _add_boundary(common)


def _auto_or_number(text: str) -> str | float:
    """Read the word auto, or a number."""
    try:
        return text if text == "auto" else float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is neither auto nor a number") from None


def _add_fair(parser: Parser, common: Any) -> None:
    _add_choice(
        common,
        "--scheme",
        SCHEMES,
        help="how the smoothing follows the mesh density: by the timestep, by the diffusion "
        "tensor, or not at all (default: timestep)",
    )
    common.add_argument(
        "--radius",
        type=float,
        metavar="EDGES",
        help="smoothing radius after all steps, in local edge lengths (default: 0.5)",
    )
    common.add_argument("--steps", type=int, metavar="N", help="number of steps (default: 4)")
    _add_choice(
        common,
        "--density",
        DENSITIES,
        help="measure of the mesh density at a vertex: mean edge length or area of the triangles "
        "around it (default: edge)",
    )
    common.add_argument(
        "--keep-volume",
        action="store_true",
        default=None,
        help="keep the volume of every closed part, step by step",
    )
    _add_max_deviation(common)
    common.add_argument(
        "--no-denoised",
        action="store_true",
        help="leave out the result of denoise, which a .blend otherwise holds beside the steps",
    )
    more = parser.add_argument_group("further options of the method")
    more.add_argument(
        "--tau",
        type=float,
        metavar="T",
        help="timestep, instead of --radius; for the mesh scaled to fit [-3, 3]^3",
    )
    more.add_argument(
        "--density-passes",
        type=int,
        metavar="N",
        help="smoothing passes over the density (default: 3)",
    )
    _add_boundary(more)
    more.add_argument(
        "--attribute",
        metavar="NAME",
        help="fair this color, vertex group or other attribute instead of the shape",
    )
    more.add_argument(
        "--stop-curvature",
        type=float,
        metavar="X",
        help="stop once the curvature energy is at most X times that of the input",
    )
    more.add_argument(
        "--stop-rate",
        type=float,
        metavar="X",
        help="stop once the curvature energy, relative to that of the input, changes by at most X "
        "per unit of time",
    )


def _add_refine(parser: Parser, common: Any) -> None:
    amount = common.add_mutually_exclusive_group()
    amount.add_argument(
        "--levels",
        type=int,
        choices=(1, 2, 3),
        default=1,
        metavar="1|2|3",
        help="steps of Loop subdivision; each cuts every triangle into four (default: 1)",
    )
    amount.add_argument(
        "--limit",
        action="store_true",
        help="move the vertices onto the smooth limit surface, without subdividing",
    )


_OWN_OPTIONS = {DENOISE: _add_denoise, FAIR: _add_fair, REFINE: _add_refine}


def _add_max_deviation(group: Any) -> None:
    group.add_argument(
        "--max-deviation",
        type=float,
        metavar="LENGTH",
        help="move no vertex further than this, in units of the mesh",
    )


def _add_boundary(group: Any) -> None:
    _add_choice(
        group,
        "--boundary",
        ("fixed", "free"),
        help="whether the boundary of an open mesh stays in place or moves with the surface "
        "(default: fixed)",
    )


def _add_file_options(parser: Parser, algorithm: str) -> None:
    group = parser.add_argument_group("input and output")
    group.add_argument(
        "--object", metavar="NAME", help="mesh object to process, if INPUT holds several"
    )
    if algorithm != REFINE:
        group.add_argument(
            "--refine",
            type=int,
            choices=(1, 2, 3),
            metavar="1|2|3",
            help="refine the result by this many steps of Loop subdivision, onto the smooth limit "
            "surface; edges marked sharp stay sharp",
        )
        group.add_argument(
            "--limit",
            action="store_true",
            help="move the vertices of the result onto the smooth limit surface, without "
            "subdividing",
        )
    group.add_argument(
        "--report", type=Path, metavar="FILE.json", help="write settings and measures as JSON"
    )
    group.add_argument(
        "--overwrite-inputs", action="store_true", help="let a result replace its own input"
    )
    group.add_argument("--quiet", action="store_true", help="show errors only")
    group.add_argument("-h", "--help", action="help", help="show this page")


def _add_batch(parser: Parser, algorithm: str) -> None:
    group = parser.add_argument_group(
        "many meshes",
        "Several INPUTs, a folder (all mesh files in it) or a pattern in quotes make a batch. "
        "Finished outputs are skipped; a mesh that fails does not stop the others. --report "
        "writes the summary.",
    )
    group.add_argument(
        "--out-dir",
        type=Path,
        metavar="DIR",
        help="folder for the outputs, made if missing (default for a folder: its name with "
        f"{ENDINGS[algorithm]})",
    )
    group.add_argument(
        "--format", metavar="KIND", help="kind of the outputs, such as ply (default: the input's)"
    )
    group.add_argument("--jobs", type=int, metavar="N", help="worker processes (default: 1)")
    group.add_argument(
        "--memory",
        metavar="SIZE",
        help="memory that all workers together may use, such as 8G (default: what is free)",
    )
    group.add_argument(
        "--shard", metavar="I/N", help="process only part I of N, on one of N machines"
    )
    group.add_argument(
        "--merge",
        action="store_true",
        help="compute nothing; sum up what earlier runs, such as shards, have done",
    )
    group.add_argument(
        "--allow-failures",
        action="store_true",
        help="exit with 0 even if meshes failed; the summary and the messages name them",
    )
    group.add_argument(
        "--flamenco",
        action="store_true",
        help="write a line to standard output for every mesh, which Flamenco counts as progress",
    )


def _add_sequence(parser: Parser) -> None:
    group = parser.add_argument_group(
        "frames of one surface",
        "With -o FILE.blend the frames also become one object, keyframed.",
    )
    group.add_argument(
        "--sequence", action="store_true", help="the INPUTs are numbered frames of one surface"
    )
    group.add_argument(
        "--frames",
        metavar="LIST",
        help="frames of an animated INPUT to process, such as 1-50 or 1,5,10-20",
    )
    group.add_argument(
        "--same-strength",
        action="store_true",
        help="smooth every frame as strongly as the first, so that nothing flickers",
    )


def _add_choice(group: Any, option: str, names: tuple[str, ...], help: str) -> None:
    group.add_argument(option, type=one_of(*names), metavar="|".join(names), help=help)
