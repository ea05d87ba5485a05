"""Sensitivity of the error and the angle of `denoise` to each of its parameters.

    python -m research.denoising.sensitivity                       three small tuning shapes
    python -m research.denoising.sensitivity --factor 1.5 --shapes gear foot
    python -m research.denoising.sensitivity --noise impulsive:0.3 --parameters normal_ratio

Prints a table in Markdown with one row a parameter: the change in percent of the error (distance to
the clean surface) and of the angle of the normals, geometric means over the meshes, with the
parameter divided and multiplied by the factor.  Only shapes that may be used for tuning are taken.
Parameters that tell clean meshes, spikes or smooth noise need other noise than the main one.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import fields, replace

from tqdm import tqdm

from adaptive_fairing.core.denoising.parameters import PARAMETERS, DenoiseParameters, using
from benchmarks.measuring import table

from .measures import Reference
from .ours import denoised
from .pairs import MAIN_NOISE, Pair, made, noise_name
from .verdict import geometric_mean

NAMES = tuple(field.name for field in fields(DenoiseParameters))
SMALL_SHAPES = ("poles_32", "molecule", "steps")
MEASURES = ("mean", "angle")

Value = float | tuple[float, ...]


def moved(value: Value, factor: float) -> Value:
    """Multiply a parameter by a factor, number by number.

    Counts are rounded, to another count.  What is below 1 stays at most 1, because it may be a
    fraction.
    """
    if isinstance(value, tuple):
        return tuple(_moved_number(each, factor) for each in value)
    return _moved_number(value, factor)


def changes(pairs: Sequence[Pair], names: Sequence[str], factor: float) -> Iterator[list[float]]:
    """Measure what each parameter changes.

    Parameters
    ----------
    pairs
        Meshes with noise.
    names
        Fields of `DenoiseParameters`.
    factor
        Above 1.

    Yields
    ------
    list of float
        Relative changes: of error and angle with the parameter divided by the factor, and of the
        same two with it multiplied.
    """
    references = [Reference(pair.clean, pair.faces) for pair in pairs]
    usual = _scores(pairs, references)
    for name in names:
        row = []
        for each in (1 / factor, factor):
            other = replace(PARAMETERS, **{name: moved(getattr(PARAMETERS, name), each)})
            with using(other):
                scores = _scores(pairs, references)
            for now, before in zip(
                zip(*scores, strict=True), zip(*usual, strict=True), strict=True
            ):
                ratios = [a / b for a, b in zip(now, before, strict=True)]
                row.append(geometric_mean(ratios) - 1)
        yield row


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table for the shapes and parameters that the command line names."""
    options = _parser().parse_args(arguments)
    pairs = list(made(options.shapes, options.noise))
    found = changes(pairs, options.parameters, options.factor)
    rows = [
        [name, _text(getattr(PARAMETERS, name)), *(f"{100 * change:+.2f} %" for change in row)]
        for name, row in zip(
            options.parameters, tqdm(found, total=len(options.parameters)), strict=True
        )
    ]
    ways = f"/ {options.factor:g}", f"× {options.factor:g}"
    changed = [f"{what}, {way}" for way in ways for what in ("error", "angle")]
    header = ("parameter", "value", *changed)
    print(", ".join(pair.label for pair in pairs), table(header, rows), sep="\n\n")


def _moved_number(value: float, factor: float) -> float:
    if isinstance(value, int):
        if factor > 1:
            return max(round(value * factor), value + 1)
        return max(min(round(value * factor), value - 1), 1)
    return min(value * factor, 1.0) if value < 1 else value * factor


def _scores(pairs: Sequence[Pair], references: Sequence[Reference]) -> list[tuple[float, ...]]:
    scores = [
        reference.score(denoised(pair.noisy, pair.faces))
        for pair, reference in zip(pairs, references, strict=True)
    ]
    return [tuple(score[measure] for measure in MEASURES) for score in scores]


def _text(value: Value) -> str:
    return ", ".join(f"{each:g}" for each in (value if isinstance(value, tuple) else (value,)))


def _factor(text: str) -> float:
    factor = float(text)
    if not factor > 1:
        raise argparse.ArgumentTypeError("must be above 1")
    return factor


def _parser() -> argparse.ArgumentParser:
    from .shapes import TUNING  # takes seconds: Blender and pymeshlab

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--shapes",
        nargs="+",
        choices=TUNING,
        default=SMALL_SHAPES,
        metavar="NAME",
        help=f"{', '.join(TUNING)} (default {' '.join(SMALL_SHAPES)})",
    )
    parser.add_argument(
        "--noise",
        nargs="+",
        type=noise_name,
        default=[MAIN_NOISE],
        metavar="KIND:AMPLITUDE",
        help="in edges (default %(default)s)",
    )
    parser.add_argument(
        "--parameters", nargs="+", choices=NAMES, default=NAMES, metavar="NAME", help="default: all"
    )
    parser.add_argument("--factor", type=_factor, default=1.25, help="default %(default)s")
    return parser


if __name__ == "__main__":
    main()
