"""Exactly repeated triangles: what modelling makes, and measuring never does.

Modelled meshes are full of repetition: rings, mirrored halves, arrays, subdivided flat faces.
Their triangles have twins with the same three lengths, to the last digit of single precision.
With noise two triangles agree by chance alone.  How often is estimated with a tolerance that is
wider by a factor: chance then finds more pairs, by at least the square of the factor.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...mesh.normals import triangle_normals, unit_vectors
from ...runtime.arrays import FloatArray, IndexArray, IntArray
from ..parameters import parameters

# Lengths agree if they differ by at most this times the mesh's half size: eight units of single
# precision.  Chance is measured with a tolerance that is wider by the second number.
TOLERANCE = 8 * 2.0**-23
WIDER = 64

# Directions and edges are of one kind if they differ by at most this, relative to the longest edge.
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
    tuned = parameters()
    if len(triangles) == 0:
        return Repetition()
    corners = positions[triangles]
    lengths = np.sort(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2), axis=1)
    tolerance = TOLERANCE * float(np.abs(corners).max())
    pairs = _others_alike(lengths, tolerance)
    part = float(np.mean(pairs > 0))
    if part < tuned.least_repeated:
        return Repetition()
    by_chance = np.mean(_others_alike(lengths, WIDER * tolerance)) / WIDER**2
    if np.mean(pairs) <= tuned.least_over_chance * by_chance:
        return Repetition()
    return Repetition(part, _is_contour(triangles, positions))


def _others_alike(values: FloatArray, tolerance: float) -> IndexArray:
    """How many other rows of (m, k) are the same, rounded to the tolerance, (m,)."""
    rounded = np.round(values / tolerance).astype(np.int64)
    _, kind, counts = np.unique(rounded, axis=0, return_inverse=True, return_counts=True)
    return counts[kind.ravel()] - 1


def _is_contour(triangles: IntArray, positions: FloatArray) -> bool:
    """Tell if a mesh is the contour of a volume of whole voxels."""
    tuned = parameters()
    corners = positions[triangles]
    edges = (corners - np.roll(corners, 1, axis=1)).reshape(-1, 3)
    longest = float(np.linalg.norm(edges, axis=1).max())
    n_edges = _n_kinds(edges / longest) if longest > 0 else 0
    if not 0 < n_edges <= tuned.most_kinds_of_edges:
        return False
    if _n_kinds(unit_vectors(triangle_normals(positions, triangles))) < tuned.least_directions:
        return False
    # Every triangle adds its two edges at a corner.
    opened = 2 * corners - np.roll(corners, 1, axis=1) - np.roll(corners, -1, axis=1)
    stands_out = np.zeros_like(positions)
    np.add.at(stands_out, triangles, opened / longest)
    used = np.unique(triangles)
    return _n_kinds(stands_out[used]) >= tuned.least_kinds_of_vertices * n_edges


def _n_kinds(vectors: FloatArray) -> int:
    """Count the different rows of (m, 3), whatever their sign."""
    rounded = np.round(vectors / COARSE).astype(np.int64)
    leading = np.argmax(rounded != 0, axis=1)
    sign = np.sign(rounded[np.arange(len(rounded)), leading])
    return len(np.unique(rounded * sign[:, None], axis=0))
