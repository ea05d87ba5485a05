"""Folds of a denoised surface, which noise or spikes have left, smoothed out.

A triangle is folded if it faces against those across its edges, taken together by their areas: no
surface does.  Its vertices go half of their way to the middle of their neighbours, in a few rounds.
"""

from __future__ import annotations

import numpy as np

from ..mesh.normals import triangle_normals
from ..mesh.topology import TriangleTopology
from ..runtime.arrays import BoolArray, FloatArray
from .parameters import parameters
from .triangle_surface import TriangleSurface


def unfolded(positions: FloatArray, before: TriangleSurface, may_move: BoolArray) -> FloatArray:
    """Smooth the folds of positions (n, 3).

    Parameters
    ----------
    positions : (n, 3)
    before : TriangleSurface
        Before denoising.  Triangles that have not moved since then stay as they are.
    may_move : (n,) bool
        Vertices that may move.
    """
    topology = before.topology
    triangles = topology.triangles
    has_moved = (positions != before.positions).any(axis=1)[triangles].any(axis=1)
    if not has_moved.any():
        return positions
    result = positions.copy()
    for _ in range(parameters().unfolding_rounds):
        vertices = np.unique(triangles[has_moved & are_folded(topology, result)])
        vertices = vertices[may_move[vertices]]
        if not len(vertices):
            break
        result[vertices] = (result[vertices] + before.mean[vertices] @ result) / 2
    return result


def are_folded(topology: TriangleTopology, positions: FloatArray) -> BoolArray:
    """Which triangles face against the sum of those across their edges, (m,)."""
    normals = triangle_normals(positions, topology.triangles)
    # Without a triangle across, twin is -1: the last row, which is zero.
    beyond = np.append(normals, np.zeros((1, 3)), axis=0)
    across = np.where(topology.twin >= 0, topology.twin // 3, -1).reshape(-1, 3)
    around = beyond[across[:, 0]] + beyond[across[:, 1]] + beyond[across[:, 2]]
    folded: BoolArray = np.einsum("fd,fd->f", normals, around) < 0
    return folded
