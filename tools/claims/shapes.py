"""Meshes whose exact answers are known: the sphere, and flat hexagons, even or graded."""

from __future__ import annotations

import numpy as np

from samples.triangles import Faces, FloatArray, edges_of


def icosphere(levels: int) -> tuple[FloatArray, Faces]:
    """Return the unit icosahedron split 1:4 `levels` times, every vertex on the sphere."""
    golden = (1 + 5**0.5) / 2
    corner = [(0, s, t * golden) for s in (-1, 1) for t in (-1, 1)]
    vertices = np.array([np.roll(c, k) for k in range(3) for c in corner])
    vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    triangles = _convex_triangles(vertices)
    for _ in range(levels):
        edges = edges_of(triangles)
        key = edges[:, 0] * len(vertices) + edges[:, 1]
        a, b, c = triangles.T
        ab, bc, ca = (
            len(vertices)
            + np.searchsorted(key, np.minimum(u, v) * len(vertices) + np.maximum(u, v))
            for u, v in ((a, b), (b, c), (c, a))
        )
        middle = vertices[edges].sum(axis=1)
        middle /= np.linalg.norm(middle, axis=1, keepdims=True)
        vertices = np.concatenate([vertices, middle])
        split = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        triangles = np.concatenate([np.stack(t, axis=1) for t in split]).astype(np.int32)
    return vertices, triangles


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

    The radius r becomes r (a + (1 - a) r²): at the centre lengths shrink by a, at the rim radial
    ones grow by 3 - 2 a.
    """
    vertices, triangles = flat_hexagon(n_rings)
    vertices /= n_rings
    squared = np.sum(vertices**2, axis=1, keepdims=True)
    least = 3 / (ratio + 2)
    return vertices * (least + (1 - least) * squared), triangles


def _convex_triangles(vertices: FloatArray) -> Faces:
    """Return the triangles of the icosahedron: all triples at the least mutual distance."""
    distance = np.linalg.norm(vertices[:, None] - vertices[None], axis=2)
    near = distance < 1.01 * np.min(distance[distance > 0])
    np.fill_diagonal(near, False)
    a, b, c = np.nonzero(near[:, :, None] & near[None] & near[:, None, :])
    triangles = np.stack([a, b, c], axis=1)[(a < b) & (b < c)]
    inward = np.linalg.det(vertices[triangles]) < 0
    triangles[inward] = triangles[inward][:, ::-1]
    return triangles.astype(np.int32)
