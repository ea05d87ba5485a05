"""Exactly repeated triangles: what modelling makes, and measuring never does.

Modelled meshes are full of repetition: rings, mirrored halves, arrays, subdivided flat faces.
Their triangles have twins with the same three lengths, to the last digit of single precision.
With noise two triangles agree by chance alone, and how often can be told: at a tolerance a few
times as wide, chance finds more pairs by at least the square of that.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...mesh.normals import triangle_normals, unit_vectors
from ...runtime.arrays import FloatArray, IndexArray, IntArray

# Lengths agree within so many units of single precision of the mesh's half size, and compared with
# pairs that agree so many times less well.
TOLERANCE = 8 * 2.0**-23
WIDER = 64

# A modelled mesh has a twin for such a part of its triangles; at least so many times more pairs
# than chance explains.  Meshes with noise of 0.05 of an edge and more have 0.000 to 0.001.
LEAST_PART, LEAST_OVER_CHANCE = 0.1, 20.0

# Contoured voxels repeat as well. They are made of few kinds of edges (27 of marching cubes), put
# together to many more kinds of vertices, while models have fewer kinds of vertices than of edges;
# and unlike boxes they face in many directions.
MOST_KINDS_OF_EDGES = 100
LEAST_KINDS_OF_VERTICES = 3  # for each kind of edges
LEAST_DIRECTIONS = 9
COARSE = 1e-3


class Repetition(NamedTuple):
    """What the triangles of a mesh have in common.

    Attributes
    ----------
    part : float
        Part of the triangles that have an exact twin, more than chance makes; 0 to 1.
    is_contour : bool
        Whether they are the contour of whole voxels, which repeats as well.
    """

    part: float = 0.0
    is_contour: bool = False


def repetition(triangles: IntArray, positions: FloatArray) -> Repetition:
    """Find exact twins among triangles.

    Parameters
    ----------
    triangles : (m, 3) int
    positions : (n, 3)
        Centred: the tolerance follows the size of the numbers.
    """
    if len(triangles) == 0:
        return Repetition()
    corners = positions[triangles]
    lengths = np.sort(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2), axis=1)
    tolerance = TOLERANCE * float(np.abs(corners).max())
    pairs = _others_alike(lengths, tolerance)
    part = float(np.mean(pairs > 0))
    if part < LEAST_PART:
        return Repetition()
    by_chance = np.mean(_others_alike(lengths, WIDER * tolerance)) / WIDER**2
    if np.mean(pairs) <= LEAST_OVER_CHANCE * by_chance:
        return Repetition()
    return Repetition(part, _is_contour(triangles, positions))


def _others_alike(values: FloatArray, tolerance: float) -> IndexArray:
    """How many other rows of (m, k) are the same, rounded to the tolerance, (m,)."""
    rounded = np.round(values / tolerance).astype(np.int64)
    _, kind, counts = np.unique(rounded, axis=0, return_inverse=True, return_counts=True)
    return counts[kind.ravel()] - 1


def _is_contour(triangles: IntArray, positions: FloatArray) -> bool:
    """Tell if a mesh is the contour of a volume of whole voxels."""
    corners = positions[triangles]
    edges = (corners - np.roll(corners, 1, axis=1)).reshape(-1, 3)
    longest = float(np.linalg.norm(edges, axis=1).max())
    n_edges = _n_kinds(edges / longest) if longest > 0 else 0
    if not 0 < n_edges <= MOST_KINDS_OF_EDGES:
        return False
    if _n_kinds(unit_vectors(triangle_normals(positions, triangles))) < LEAST_DIRECTIONS:
        return False
    # Every triangle adds its two edges at a corner.
    opened = 2 * corners - np.roll(corners, 1, axis=1) - np.roll(corners, -1, axis=1)
    stands_out = np.zeros_like(positions)
    np.add.at(stands_out, triangles, opened / longest)
    used = np.unique(triangles)
    return _n_kinds(stands_out[used]) >= LEAST_KINDS_OF_VERTICES * n_edges


def _n_kinds(vectors: FloatArray) -> int:
    """Count the different rows of (m, 3), whatever their sign."""
    rounded = np.round(vectors / COARSE).astype(np.int64)
    leading = np.argmax(rounded != 0, axis=1)
    sign = np.sign(rounded[np.arange(len(rounded)), leading])
    return len(np.unique(rounded * sign[:, None], axis=0))
