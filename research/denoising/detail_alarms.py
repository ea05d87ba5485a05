"""Rate at which `denoise` takes fine detail for the smooth noise of a scanner.

    python -m research.denoising.detail_alarms                 shapes that were not tuned on
    python -m research.denoising.detail_alarms --tuned

Every kind of detail in `DETAIL` covers the whole of every shape, which is the worst case: detail in
some places alone is not as even as noise.  Then the shapes without detail get smooth noise, to see
how often it is told.  Prints a table in Markdown, with confidence intervals of 95 % after Clopper
and Pearson.
"""

from __future__ import annotations

import argparse
import zlib
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from scipy.spatial import cKDTree
from tqdm import tqdm

from adaptive_fairing.core import denoise
from benchmarks.measuring import table
from tools.geometry.triangles import Faces, FloatArray, local_edge_lengths, vertex_normals

from .false_alarms import rate_row
from .pairs import CLEAN, made

TUNED = ("head", "pawn", "lens", "hills", "coral")
CHECKED = ("foot", "socket", "cushion", "gyroid", "pipes", "bracket_even")
NOISES = ("camera:2", "correlated-2:0.2", "correlated-4:0.3", "correlated-6:0.4")

WAVES = 400
"""Plane waves that a random function is the sum of."""


class Texture:
    """Random functions of the places (n, 3), in local edge lengths."""

    def __init__(self, places: FloatArray, generator: np.random.Generator) -> None:
        self.places, self.generator = places, generator

    def waves(self, length: float) -> FloatArray:
        """Gaussian random function of about one wavelength and unit variance, (n,)."""
        direction = self.generator.normal(size=(WAVES, 3))
        direction /= np.linalg.norm(direction, axis=1)[:, None]
        lengths = length * np.exp(0.15 * self.generator.normal(size=WAVES))
        phase = self.generator.uniform(0, 2 * np.pi, WAVES)
        turns = self.places @ (direction / lengths[:, None]).T
        return np.sqrt(2 / WAVES) * np.cos(2 * np.pi * turns + phase).sum(axis=1)

    def nearest(self, part: int) -> FloatArray:
        """Distances to the two nearest of random vertices, one in `part` of all, (n, 2)."""
        chosen = self.generator.choice(len(self.places), len(self.places) // part)
        return cKDTree(self.places[chosen]).query(self.places, k=2)[0]


def _octaves(texture: Texture, height: float, power: float) -> FloatArray:
    return sum(height * each**power * texture.waves(each) for each in (4, 6, 9, 13, 20, 30))


def _scales(texture: Texture) -> FloatArray:
    x, y, _ = texture.places.T
    shift = (np.floor(y / 6) % 2) / 4
    return 0.3 * np.abs(np.sin(2 * np.pi * (x / 9 + shift)) * np.sin(np.pi * y / 6))


def _knurl(texture: Texture) -> FloatArray:
    x, y, z = texture.places.T
    return 0.3 * np.sin(np.pi * (x + y) / 4) * np.sin(np.pi * (x - z) / 4)


def _hair(texture: Texture) -> FloatArray:
    x, _, z = texture.places.T
    return 0.3 * np.sin(np.pi * (0.3 * x + z) / 3 + 2 * texture.waves(40))


def _fur(texture: Texture) -> FloatArray:
    along = Texture(texture.places * [1, 1, 0.25], texture.generator)
    return 0.3 * np.abs(along.waves(5))


def _wrinkles(texture: Texture) -> FloatArray:
    return sum(0.02 * each * (1 - 2 * np.abs(texture.waves(each))) for each in (8, 14, 24))


def _cracks(texture: Texture) -> FloatArray:
    first, second = texture.nearest(60).T
    return -0.5 * np.exp(-(((second - first) / 1.5) ** 2))


DETAIL: Mapping[str, Callable[[Texture], FloatArray]] = {
    "rock": lambda texture: _octaves(texture, 0.02, 1.0),
    "coarse rock": lambda texture: _octaves(texture, 0.06, 0.5),
    "waves of 6 edges": lambda texture: 0.2 * texture.waves(6),
    "waves of 10 edges": lambda texture: 0.4 * texture.waves(10),
    "scales": _scales,
    "knurl": _knurl,
    "cracks": _cracks,
    "hammered": lambda texture: 0.04 * texture.nearest(60)[:, 0] ** 2,
    "warts": lambda texture: 0.8 * np.exp(-((texture.nearest(60)[:, 0] / 1.8) ** 2)),
    "pores": lambda texture: -0.5 * np.exp(-((texture.nearest(25)[:, 0] / 1.3) ** 2)),
    "hair": _hair,
    "wrinkles": _wrinkles,
    "patches": lambda texture: 0.3 * np.clip(texture.waves(60) + 0.5, 0, 1) * texture.waves(6),
    "fur": _fur,
}
"""Heights (n,) along the normals in local edge lengths."""


def with_detail(name: str, kind: str) -> tuple[FloatArray, Faces]:
    """Return a shape by name with one kind of `DETAIL`; the same on every run."""
    (shape,) = made([name], [CLEAN])
    vertices, faces = shape.clean, shape.faces
    edges = local_edge_lengths(vertices, faces)
    generator = np.random.default_rng(zlib.crc32(f"{name} {kind}".encode()))
    heights = edges * DETAIL[kind](Texture(vertices / np.median(edges), generator))
    return vertices + heights[:, None] * vertex_normals(vertices, faces), faces


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tuned", action="store_true", help="the shapes that were tuned on")
    names = list(TUNED if parser.parse_args(arguments).tuned else CHECKED)
    taken = [
        f"{name}, {kind}"
        for name in tqdm(names, unit="shape")
        for kind in DETAIL
        if _takes_for_noise(*with_detail(name, kind))
    ]
    rows = [rate_row("detail taken for smooth noise", taken, len(names) * len(DETAIL))]
    for noise in NOISES:
        pairs = list(made(names, [noise]))
        told = [pair.name for pair in pairs if _takes_for_noise(pair.noisy, pair.faces)]
        rows.append(rate_row(f"{noise}, told", told, len(pairs)))
    print(table(("", "meshes", "95 % interval of the rate", "which"), rows))


def _takes_for_noise(vertices: FloatArray, faces: Faces) -> bool:
    """Whether smooth noise is found; white noise, which some detail counts as, is not asked for."""
    return any("it was removed" in note for note in denoise(vertices, faces).notes)


if __name__ == "__main__":
    main()
