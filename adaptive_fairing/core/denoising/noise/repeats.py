"""Exact repetitions of triangles, which modelling makes and measuring does not.

Modelled meshes are full of repetition: rings, mirrored halves, arrays, subdivided flat faces.
Their triangles have twins with the same three lengths, to the last digit of single precision.
With noise two triangles agree only by chance.  The number of chance pairs is estimated with a
tolerance wider by a factor, which raises it by at least the square of the factor.

Contours of whole voxels repeat themselves too, but their flat steps are noise and not shape.  Like
those of a model, their triangles lie in few planes and have few kinds of edges.  But they face in
more directions than boxes, and their vertices deviate in many more ways than there are edges.
"""

from __future__ import annotations

import numpy as np

from ...mesh.normals import triangle_normals, unit_vectors
from ...runtime.arrays import FloatArray, IndexArray, IntArray, LongArray
from ..parameters import parameters

# Lengths agree if they differ by at most this times the mesh's half size: eight units of single
# precision.  Chance is measured with a tolerance that is wider by the second number.
TOLERANCE = 8 * 2.0**-23
WIDER = 64

# Directions and edges are of one kind if they differ by at most this, relative to the longest edge.
COARSE = 1e-3

# Odd numbers without any relation to each other.
LABEL_FACTORS = np.random.default_rng(0).integers(1 << 61, 1 << 62, 3) | 1

# Any other mesh has too many kinds of edges in so few triangles: to count them all takes long.
FIRST_TRIANGLES = 512


def repeated_part(triangles: IntArray, positions: FloatArray) -> float:
    """Fraction of the triangles (m, 3) with exact twins, 0 to 1; 0 if chance explains them.

    The positions (n, 3) are centred: the tolerance follows the size of the numbers.
    """
    tuned = parameters()
    if len(triangles) == 0:
        return 0.0
    corners = positions[triangles]
    lengths = np.sort(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2), axis=1)
    tolerance = TOLERANCE * float(np.abs(corners).max())
    pairs = _others_alike(lengths, tolerance)
    part = float(np.mean(pairs > 0))
    if part < tuned.least_repeated:
        return 0.0
    by_chance = np.mean(_others_alike(lengths, WIDER * tolerance)) / WIDER**2
    return part if np.mean(pairs) > tuned.least_over_chance * by_chance else 0.0


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


def _others_alike(values: FloatArray, tolerance: float) -> IndexArray:
    """Count the other rows of (m, k) that are equal after rounding to the tolerance, (m,)."""
    labels = _labels(np.round(values / tolerance).astype(np.int64))
    _, kind, counts = np.unique(labels, return_inverse=True, return_counts=True)
    return counts[kind] - 1


def _n_kinds(vectors: FloatArray) -> int:
    """Count the distinct rows of (m, 3) up to their sign."""
    rounded = np.round(vectors / COARSE).astype(np.int64)
    leading = np.argmax(rounded != 0, axis=1)
    sign = np.sign(rounded[np.arange(len(rounded)), leading])
    return len(np.unique(_labels(rounded * sign[:, None])))


def _labels(rows: LongArray) -> LongArray:
    """Give equal rows of (m, 3) one number and others different ones: one number sorts faster.

    That two of a million rows get the same one by chance has a probability of 1e-7.
    """
    labels: LongArray = (rows * LABEL_FACTORS).sum(axis=1)  # modulo 2⁶⁴
    return labels
