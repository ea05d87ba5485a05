"""Contours of whole voxels: staircases, whose flat steps are noise and not shape.

Like those of a model, their triangles lie in few planes and have few kinds of edges.  But they face
in more directions than boxes, and their vertices deviate in many more ways than there are edges.
"""

from __future__ import annotations

import numpy as np

from ...mesh.normals import triangle_normals, unit_vectors
from ...runtime.arrays import FloatArray, IntArray
from ..parameters import parameters

# Directions and edges are of one kind if they differ by at most this, relative to the longest edge.
COARSE = 1e-3

# Any other mesh has too many kinds of edges in so few triangles: to count them all takes long.
FIRST_TRIANGLES = 512


def is_voxel_contour(triangles: IntArray, positions: FloatArray) -> bool:
    """Whether triangles (m, 3) are the contour of a volume of whole voxels."""
    tuned = parameters()
    most = tuned.most_kinds_of_edges
    corners = positions[triangles]
    edges = (corners - np.roll(corners, 1, axis=1)).reshape(-1, 3)
    longest = float(np.linalg.norm(edges, axis=1).max(initial=0))
    if not longest > 0 or _n_kinds(edges[: 3 * FIRST_TRIANGLES] / longest) > most:
        return False
    n_edges = _n_kinds(edges / longest)
    if n_edges > most:
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
    """Count the distinct rows of (m, 3) up to their sign."""
    rounded = np.round(vectors / COARSE).astype(np.int64)
    leading = np.argmax(rounded != 0, axis=1)
    sign = np.sign(rounded[np.arange(len(rounded)), leading])
    return len(np.unique(rounded * sign[:, None], axis=0))
