"""Exact repetitions of triangles, which modelling makes and measuring does not.

Modelled meshes are full of repetition: rings, mirrored halves, arrays, subdivided flat faces.
Their triangles have twins with the same three lengths, to the last digit of single precision.
With noise two triangles agree only by chance.  The number of chance pairs is estimated with a
tolerance wider by a factor, which raises it by at least the square of the factor.
"""

from __future__ import annotations

import numpy as np

from ...runtime.arrays import FloatArray, IndexArray, IntArray
from ..parameters import parameters

# Lengths agree if they differ by at most this times the mesh's half size: eight units of single
# precision.  Chance is measured with a tolerance that is wider by the second number.
TOLERANCE = 8 * 2.0**-23
WIDER = 64


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


def _others_alike(values: FloatArray, tolerance: float) -> IndexArray:
    """Count the other rows of (m, k) that are equal after rounding to the tolerance, (m,)."""
    rounded = np.round(values / tolerance).astype(np.int64)
    _, kind, counts = np.unique(rounded, axis=0, return_inverse=True, return_counts=True)
    return counts[kind.ravel()] - 1
