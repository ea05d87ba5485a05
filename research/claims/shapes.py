"""Meshes whose exact answers are known: flat hexagons, even or graded."""

from __future__ import annotations

import numpy as np

from tools.geometry.triangles import Faces, FloatArray


def flat_hexagon(n_rings: int) -> tuple[FloatArray, Faces]:
    """Return a hexagon of equilateral triangles with edges of length 1; vertex 0 is its centre."""
    size = 2 * n_rings + 1
    x, y = np.divmod(np.arange(size * size), size)
    x, y = x - n_rings, y - n_rings
    lower = np.flatnonzero((x < n_rings) & (y < n_rings))
    right, up, across = lower + size, lower + 1, lower + size + 1
    # The long diagonal of a lattice cell joins its right and upper corners.
    triangles = np.concatenate(
        [np.stack([lower, right, up], axis=1), np.stack([right, across, up], axis=1)]
    )
    inside = np.abs(x + y) <= n_rings
    triangles = triangles[inside[triangles].all(axis=1)]
    distance = x * x + x * y + y * y
    order = np.argsort(np.where(inside, distance, distance.max() + 1), kind="stable")
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    positions = np.stack([x + 0.5 * y, 0.75**0.5 * y, np.zeros(len(x))], axis=1)
    kept = order[: inside.sum()]
    return positions[kept], rank[triangles].astype(np.int32)


def graded_hexagon(n_rings: int, ratio: float) -> tuple[FloatArray, Faces]:
    """Return the flat hexagon of radius 1 with edges `ratio` times longer at its corners.

    The radius r becomes r (a + (1 - a) r²): lengths at the centre shrink by a, radial lengths at
    the boundary grow by 3 - 2 a.
    """
    vertices, triangles = flat_hexagon(n_rings)
    vertices /= n_rings
    squared = np.sum(vertices**2, axis=1, keepdims=True)
    least = 3 / (ratio + 2)
    return vertices * (least + (1 - least) * squared), triangles
