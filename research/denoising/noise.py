"""Seeded noise of several kinds that moves vertices, its strength in edge lengths.

`add_noise(vertices, faces, "normal", 0.2, seed)`. Kinds that make a mesh of their own are in
`scans`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np
from scipy.sparse import csr_array

from tools.geometry.triangles import Faces, FloatArray, edges_of, local_edge_lengths, vertex_normals

SPIKES = 0.2
"""Fraction of the vertices that impulsive noise moves."""

OUTLIERS, OUTLIER_SCALE = 0.1, 3.0
"""Heavy-tailed noise is Tukey's contaminated normal distribution: one vertex in ten has three times
the standard deviation of the others."""

CORRELATION_LENGTHS = (2, 4, 6)
"""Edges after which the correlation of two heights has fallen to 1 / e."""

Heights = Callable[[np.random.Generator, Faces, int], FloatArray]
"""Heights (n,) along the normals of root mean square 1."""


def gaussian(generator: np.random.Generator, faces: Faces, n: int) -> FloatArray:
    """Independent heights, normally distributed."""
    return generator.normal(size=n)


def impulsive(generator: np.random.Generator, faces: Faces, n: int) -> FloatArray:
    """Move a fraction `SPIKES` of the vertices and leave the others where they are."""
    return np.where(generator.random(n) < SPIKES, generator.normal(size=n), 0.0) / SPIKES**0.5


def heavy_tailed(generator: np.random.Generator, faces: Faces, n: int) -> FloatArray:
    """Independent heights, a fraction `OUTLIERS` of them `OUTLIER_SCALE` times as large."""
    scale = np.where(generator.random(n) < OUTLIERS, OUTLIER_SCALE, 1.0)
    variance = 1 + OUTLIERS * (OUTLIER_SCALE**2 - 1)
    return scale * generator.normal(size=n) / variance**0.5


def correlated(generator: np.random.Generator, faces: Faces, n: int, length: float) -> FloatArray:
    """Heights that neighbours share: white noise averaged over the neighbours several times.

    An average over the six neighbours and the vertex itself moves by 6/7 of a squared edge in the
    mean, so the correlation after k of them falls with distance r as exp(-7 r² / (12 k)).
    """
    ends = edges_of(faces).T
    rows, columns = np.concatenate([ends, ends[::-1]], axis=1)
    neighbours = csr_array((np.ones(len(rows)), (rows, columns)), shape=(n, n))
    valence = neighbours.sum(axis=1)
    heights = generator.normal(size=n)
    for _ in range(round(7 * length**2 / 12)):
        heights = (heights + neighbours @ heights) / (1 + valence)
    return heights / heights.std()


IN_LOCAL_EDGES: Mapping[str, Heights] = {
    "normal": gaussian,
    "impulsive": impulsive,
    "heavy-tailed": heavy_tailed,
    **{f"correlated-{k}": partial(correlated, length=k) for k in CORRELATION_LENGTHS},
}
"""Along the normals, in proportion to the local edge length."""

KINDS = ("uniform", "isotropic", "growing", *IN_LOCAL_EDGES)
"""All that move vertices."""


def add_noise(
    vertices: FloatArray, faces: Faces, kind: str, amplitude: float, seed: int
) -> FloatArray:
    """Return the vertices (n, 3) with noise of one of `KINDS`; the same on every run.

    Parameters
    ----------
    vertices, faces
        The clean mesh, (n, 3) and (m, 3).
    kind
        "uniform": along the normals with one amplitude everywhere, as most of the literature has
        it. "isotropic": in all directions, in proportion to the local edges. "growing": from none
        at one end of the first axis to √3 times the amplitude at the other. Others along the
        normals and in proportion to the local edges, see `IN_LOCAL_EDGES`.
    amplitude
        Root mean square height over the local edge length, for "uniform" over its mean;
        for "isotropic" along each axis.
    seed
        Of the random numbers.
    """
    generator = np.random.default_rng(seed)
    edges = local_edge_lengths(vertices, faces)
    if kind == "isotropic":
        return vertices + amplitude * edges[:, None] * generator.normal(size=vertices.shape)
    if kind == "growing":
        place = np.argsort(np.argsort(vertices[:, 0], kind="stable")) / len(vertices)
        heights = np.sqrt(3) * place * edges * gaussian(generator, faces, len(vertices))
    elif kind == "uniform":
        heights = edges.mean() * gaussian(generator, faces, len(vertices))
    else:
        heights = edges * IN_LOCAL_EDGES[kind](generator, faces, len(vertices))
    return vertices + amplitude * heights[:, None] * vertex_normals(vertices, faces)
