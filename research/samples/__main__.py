"""Make the project's sample meshes: clean and noisy, feature-adaptive, closed manifolds.

Run `python -m research.samples [NAME ...] [-o FOLDER]` with the `bpy` wheel installed. The
result is the same on every run.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tools.geometry.noise import add_noise
from tools.geometry.ply import write_ply
from tools.geometry.triangles import corner_angles, density_ratio

from . import crocodile, foot, head
from .adaptive import decimate, improve
from .implicit import Array, Primitive
from .meshing import Faces, dense_mesh

ASSETS = Path(__file__).resolve().parents[2] / "assets"


@dataclass(frozen=True)
class Sample:
    """Recipe of one sample.

    Attributes
    ----------
    solid, detail
        The shape, and how densely it is to be meshed at given points (0 to 1).
    cell
        Lattice spacing of the dense mesh, in the shape's units.
    n_triangles
        Size of the result.
    contrast
        How much the detailed parts are kept against the smooth ones.
    rounds
        How often the triangles are improved.
    flat
        Edges with a sharper bend (smaller cosine) than this are not flipped.
    noise
        Standard deviation over the local mean edge length.
    seed
        Seed of the noise.
    """

    solid: Callable[[], Primitive]
    detail: Callable[[Array], Array]
    cell: float
    n_triangles: int
    contrast: float
    rounds: int
    flat: float
    noise: float
    seed: int


SAMPLES = {
    "head": Sample(head.solid, head.detail, 0.12, 24_000, 16.0, 4, 0.5, 0.17, 11),
    "foot": Sample(foot.solid, foot.detail, 0.12, 20_000, 8.0, 4, 0.5, 0.17, 41),
    "crocodile": Sample(crocodile.solid, crocodile.detail, 0.15, 44_000, 14.0, 8, 0.2, 0.15, 42),
}
"""Every sample by name; each gives NAME.ply and NAME_noisy.ply."""


def make(sample: Sample) -> tuple[Array, Array, Faces]:
    """Return clean positions, noisy positions (both (n, 3)) and triangles (m, 3)."""
    solid = sample.solid()
    dense, faces = dense_mesh(solid, sample.cell)
    coarse, faces = decimate(
        dense, faces, sample.detail(dense), sample.n_triangles, sample.contrast
    )
    clean, triangles = improve(solid, coarse, faces, rounds=sample.rounds, flat=sample.flat)
    return clean, add_noise(clean, triangles, sample.noise, sample.seed), triangles


def main(arguments: Sequence[str] | None = None) -> int:
    """Make the samples named on the command line, or all of them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(SAMPLES))
    parser.add_argument("-o", "--output", type=Path, default=ASSETS, metavar="FOLDER")
    options = parser.parse_args(arguments)
    unknown = sorted(set(options.names) - set(SAMPLES))
    if unknown:
        parser.error(f"unknown sample {', '.join(unknown)}; there are {', '.join(SAMPLES)}")
    options.output.mkdir(parents=True, exist_ok=True)
    for name in options.names or SAMPLES:
        clean, noisy, triangles = make(SAMPLES[name])
        comment = "adaptive_fairing sample, CC0-1.0, made by research/samples"
        write_ply(options.output / f"{name}.ply", clean, triangles, comment)
        write_ply(options.output / f"{name}_noisy.ply", noisy, triangles, comment)
        sys.stdout.write(
            f"{name}: {len(clean)} vertices, {len(triangles)} triangles, "
            f"density ratio {density_ratio(clean, triangles):.1f}, "
            f"smallest angle {np.min(corner_angles(clean, triangles)):.1f} degrees\n"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
