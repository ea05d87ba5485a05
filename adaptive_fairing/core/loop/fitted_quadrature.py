"""A quadrature rule for irregular patches whose weights depend on the valences of the corners.

Near an extraordinary vertex basis functions and sqrt(det g) are no polynomials, and a rule for
polynomials is off by several thousandths.  Shifting its weights a little towards or away from the
corner, by a fixed amount for each valence, mends most of that without a single point more.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ..runtime.arrays import FloatArray
from .patch_class import PatchClass

# All constants were fitted by tools/fit_quadrature.py, which says how.  An orbit of three points
# (the small coordinate), an orbit of six (two coordinates) and the centre; weights of each.
_THREE, _SIX = 0.077627814, (0.072171386, 0.326693212)
_WEIGHTS = (0.035547465, 0.049410684, 0.096891400)

# By valence of a corner, in millionths: shifts of the weights of points, in the order of their
# barycentric coordinate at that corner (six kinds of points).
_SHIFTS = {
    4: (318, 82, -274, -1216, 1027, -1091),
    5: (156, 68, -282, -408, 489, -454),
    6: (0, 0, 0, 0, 0, 0),
    7: (-70, -150, 429, -18, -410, 419),
    8: (-125, -310, 871, -62, -825, 838),
    9: (-115, -498, 1318, -278, -1153, 1175),
    10: (-30, -668, 1623, -642, -1293, 1376),
}


def _barycentric() -> FloatArray:
    a, b = _SIX
    c, large = 1 - a - b, 1 - 2 * _THREE
    points = [(large, _THREE, _THREE), (_THREE, large, _THREE), (_THREE, _THREE, large)]
    points += [(a, b, c), (b, c, a), (c, a, b), (b, a, c), (a, c, b), (c, b, a), (1 / 3,) * 3]
    array = np.array(points)
    array.setflags(write=False)
    return array


BARYCENTRIC = _barycentric()
POINTS = BARYCENTRIC[:, 1:]

# Which of the six kinds a point is, as seen from each corner: (3, n_points).
_KIND = np.unique(BARYCENTRIC.T.round(6), return_inverse=True)[1].reshape(3, -1)


@lru_cache(maxsize=4096)
def is_fitted(patch_class: PatchClass) -> bool:
    """Whether there is a fitted rule for a patch: inside the surface, of moderate valences."""
    valences = sorted(corner.ring_size for corner in patch_class)
    if any(corner.is_boundary for corner in patch_class) or not _SHIFTS.keys() >= set(valences):
        return False
    # Measured: beyond 1e-3 in octahedra, in the thin triangles around a pole, and where vertices
    # of high and low valence meet.
    if valences.count(4) > 1 or valences == [5, 5, 6]:
        return False
    return valences[-1] < 9 or sum(abs(valence - 6) for valence in valences) <= 5


@lru_cache(maxsize=4096)
def fitted_weights(valences: tuple[int, int, int]) -> FloatArray:
    """Weights of `POINTS` on a patch with these valences of its corners: positive, sum 1/2."""
    weights = np.repeat(_WEIGHTS, (3, 6, 1))
    for kind, valence in zip(_KIND, valences, strict=True):
        weights += 1e-6 * np.array(_SHIFTS[valence])[kind]
    weights *= 0.5 / weights.sum()
    weights.setflags(write=False)
    return weights
