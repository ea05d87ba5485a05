"""Folds that noise or spikes have left in a denoised surface, and their smoothing.

A triangle is folded if it faces against those across its edges, taken together by their areas.
Noise turns a triangle over where it is strong, or where denoising has moved a vertex far.  There
the triangle's vertices go half of their way to the middle of their neighbours, in a few rounds.
Other folds belong to the mesh, as bad cuts of solids leave them: they stay.  But a mesh has few of
its own: of many, as noise along the surface makes them where triangles are thin, all are smoothed.
"""

from __future__ import annotations

import numpy as np

from ..mesh.normals import dots, triangle_normals
from ..mesh.topology import TriangleTopology
from ..runtime.arrays import BoolArray, FloatArray
from .parameters import parameters
from .triangle_surface import TriangleSurface


def unfolded(
    positions: FloatArray, before: TriangleSurface, may_move: BoolArray, noise: FloatArray
) -> FloatArray:
    """Smooth the folds of positions (n, 3) that noise has made.

    Parameters
    ----------
    positions : (n, 3)
    before : TriangleSurface
        Before denoising.
    may_move : (n,) bool
        Vertices that may move.
    noise : (n,)
        Standard deviation in local edge lengths.
    """
    tuned, topology, result = parameters(), before.topology, positions
    triangles = topology.triangles
    folded = are_folded(topology, positions)
    if folded.any():
        move = np.linalg.norm(positions - before.positions, axis=1)
        are_many = are_folded(topology, before.positions).mean() > tuned.most_own_folds
        turns = ((noise > tuned.most_noise_in_normals) | are_many) & (move > 0)
        turns |= move > tuned.least_move_of_folds * before.spacing
        of_noise = turns[triangles].any(axis=1)
        result = positions.copy()
        for _ in range(tuned.unfolding_rounds):
            vertices = np.unique(triangles[of_noise & folded])
            vertices = vertices[may_move[vertices]]
            if not len(vertices):
                break
            result[vertices] = (result[vertices] + before.mean[vertices] @ result) / 2
            folded = are_folded(topology, result)
    return result


def are_folded(topology: TriangleTopology, positions: FloatArray) -> BoolArray:
    """Which triangles face against the sum of those across their edges, (m,)."""
    normals = triangle_normals(positions, topology.triangles)
    # Without a triangle across, twin is -1: the last row, which is zero.
    beyond = np.append(normals, np.zeros((1, 3)), axis=0)
    across = np.where(topology.twin >= 0, topology.twin // 3, -1).reshape(-1, 3)
    around = beyond[across[:, 0]] + beyond[across[:, 1]] + beyond[across[:, 2]]
    folded: BoolArray = dots(normals, around) < 0
    return folded
