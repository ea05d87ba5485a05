"""Seeded noise of several kinds, its strength given in local edge lengths.

`add_noise(vertices, faces, "normal", 0.2, seed)`; the kind "staircase" makes a mesh of its own and
is in `staircase`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from scipy.sparse import csr_array

from .geometry import Faces, FloatArray, edges_of, local_edge_lengths, vertex_normals

CORRELATION_PASSES = 4
"""Averagings over the neighbours: noise that is alike over two to three edges."""

Maker = Callable[[FloatArray, Faces, float, np.random.Generator], FloatArray]


def along_normals(
    vertices: FloatArray, faces: Faces, amplitude: float, generator: np.random.Generator
) -> FloatArray:
    """Independent normal-distributed heights, `amplitude` times the local edge length."""
    heights = generator.normal(size=len(vertices)) * local_edge_lengths(vertices, faces)
    return amplitude * heights[:, None] * vertex_normals(vertices, faces)


def uniform_amplitude(
    vertices: FloatArray, faces: Faces, amplitude: float, generator: np.random.Generator
) -> FloatArray:
    """Heights along the normals, as strong everywhere: `amplitude` times the mean local edge."""
    scale = amplitude * local_edge_lengths(vertices, faces).mean()
    return scale * generator.normal(size=(len(vertices), 1)) * vertex_normals(vertices, faces)


def isotropic(
    vertices: FloatArray, faces: Faces, amplitude: float, generator: np.random.Generator
) -> FloatArray:
    """Displace in all directions, `amplitude` times the local edge length along each axis."""
    scale = amplitude * local_edge_lengths(vertices, faces)
    return scale[:, None] * generator.normal(size=vertices.shape)


def correlated(
    vertices: FloatArray, faces: Faces, amplitude: float, generator: np.random.Generator
) -> FloatArray:
    """Heights that neighbours share, as those of scans: averaged, then of full strength again."""
    ends = edges_of(faces).T
    rows, columns = np.concatenate([ends, ends[::-1]], axis=1)
    neighbours = csr_array((np.ones(len(rows)), (rows, columns)), shape=(len(vertices),) * 2)
    valence = np.maximum(neighbours.sum(axis=1), 1)
    heights = generator.normal(size=len(vertices))
    for _ in range(CORRELATION_PASSES):
        heights = (heights + neighbours @ heights) / (1 + valence)
    heights *= local_edge_lengths(vertices, faces) / heights.std()
    return amplitude * heights[:, None] * vertex_normals(vertices, faces)


KINDS: Mapping[str, Maker] = {
    "normal": along_normals,
    "uniform": uniform_amplitude,
    "isotropic": isotropic,
    "correlated": correlated,
}


def add_noise(
    vertices: FloatArray, faces: Faces, kind: str, amplitude: float, seed: int
) -> FloatArray:
    """Return the vertices (n, 3) with noise of one of `KINDS`; the same on every run."""
    generator = np.random.default_rng(seed)
    return vertices + KINDS[kind](vertices, faces, amplitude, generator)
