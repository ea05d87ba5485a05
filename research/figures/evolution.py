"""Film the head while it is faired, uniform beside adaptive timesteps.

Run `python -m research.figures.evolution [-o FILE.gif]`. Between two steps positions are linear, as
they are between two shape keys of an evolution.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image

from adaptive_fairing.core import fair
from research.claims.measures import TIMESTEP_AREA, UNIFORM, Scheme, matched_tau
from research.claims.pairs import MeshPair, sample_pair
from research.figures.layout import FOLDER, Panel, Shot, sheet
from research.figures.render import View

SIDES = {"uniform timestep": UNIFORM, "adaptive timestep": TIMESTEP_AREA}
STEPS, FRAMES_PER_STEP = 8, 3
FIRST, EACH, LAST = 600, 100, 1100
"""Milliseconds for which the first frame, each one between and the last frame are shown."""

DIRECTION, SIZE, SAMPLES = (0.75, -1.0, 0.15), (270, 400), 8
GREYS = 48
"""Grey levels kept in the file: plenty for clay, and a third of the size."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Film the head."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "-o", "--output", type=Path, default=FOLDER / "evolution.gif", metavar="FILE.gif"
    )
    options = parser.parse_args(arguments)
    pair = sample_pair("head")
    # One box for all frames: the camera stands still while the mesh shrinks.
    view = View(DIRECTION, box=(pair.noisy.min(axis=0), pair.noisy.max(axis=0)), margin=-0.11)
    sides = {name: _evolution(pair, scheme) for name, scheme in SIDES.items()}
    frames = []
    for time in np.arange(STEPS * FRAMES_PER_STEP + 1) / FRAMES_PER_STEP:
        panels = [Panel(_between(states, time), name, "") for name, states in sides.items()]
        frames.append(sheet([panels], pair.triangles, [[Shot(view, SIZE)]], SAMPLES))
    _write_gif(options.output, frames)
    return 0


def _evolution(pair: MeshPair, scheme: Scheme) -> list[np.ndarray]:
    """Return the input and all steps, at the τ that leaves the coarse parts as rough as clean."""
    tau = matched_tau(scheme, pair.noisy, pair.clean, pair.classes, STEPS)
    run = fair(pair.noisy, pair.triangles, scheme.settings(tau, STEPS))
    return [pair.noisy, *(step.positions for step in run.steps)]


def _between(states: Sequence[np.ndarray], time: float) -> np.ndarray:
    """Return the positions at a time, 0 for the first state, 1 for the next one."""
    first = min(int(time), len(states) - 2)
    return states[first] + (time - first) * (states[first + 1] - states[first])


def _write_gif(path: Path, frames: Sequence[Image.Image]) -> None:
    # The same greys in all frames: nothing flickers.
    levels = [round(round(v / 255 * (GREYS - 1)) * 255 / (GREYS - 1)) for v in range(256)]
    grey = [frame.convert("L").point(levels) for frame in frames]
    times = [FIRST, *[EACH] * (len(grey) - 2), LAST]
    grey[0].save(path, save_all=True, append_images=grey[1:], duration=times, loop=0, optimize=True)


if __name__ == "__main__":
    sys.exit(main())
