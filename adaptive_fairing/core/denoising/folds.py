"""Folds that noise has left in a denoised surface, and their smoothing.

A triangle is folded if it faces against the sum of those across its edges, weighted by area.  Where
a spike was put back, or noise wider than the triangles was removed, the vertices of a fold move
half-way to the mean of their neighbours, in a few rounds.  Other folds belong to the mesh, from bad
cuts or decimation: they stay.
"""

from __future__ import annotations

import numpy as np

from ..mesh.normals import dots, triangle_normals
from ..mesh.topology import TriangleTopology
from ..runtime.arrays import BoolArray, FloatArray
from .parameters import parameters
from .triangle_surface import TriangleSurface


def unfolded(
    positions: FloatArray, before: TriangleSurface, is_at: BoolArray, may_move: BoolArray
) -> FloatArray:
    """Smooth the folds of positions (n, 3) at some vertices.

    Parameters
    ----------
    positions : (n, 3)
    before : TriangleSurface
        Surface before denoising.
    is_at, may_move : (n,) bool
        Vertices at which folds are smoothed, and vertices that may move.
    """
    topology, result = before.topology, positions.copy()
    triangles = topology.triangles
    of_noise = is_at[triangles].any(axis=1)
    for _ in range(parameters().rounds if of_noise.any() else 0):
        vertices = np.unique(triangles[of_noise & are_folded(topology, result)])
        vertices = vertices[may_move[vertices]]
        if not len(vertices):
            break
        result[vertices] = (result[vertices] + before.mean[vertices] @ result) / 2
    return result


def are_folded(topology: TriangleTopology, positions: FloatArray) -> BoolArray:
    """Whether each triangle faces against the sum of those across its edges, (m,)."""
    normals = triangle_normals(positions, topology.triangles)
    # Without a triangle across, twin is -1: the last row, which is zero.
    beyond = np.append(normals, np.zeros((1, 3)), axis=0)
    across = np.where(topology.twin >= 0, topology.twin // 3, -1).reshape(-1, 3)
    around = beyond[across[:, 0]] + beyond[across[:, 1]] + beyond[across[:, 2]]
    folded: BoolArray = dots(normals, around) < 0
    return folded
