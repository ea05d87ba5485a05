"""A quadrature rule for irregular patches whose weights depend on the valences of the corners.

Near an extraordinary vertex basis functions and sqrt(det g) are no polynomials, and a rule for
polynomials is off by several thousandths.  A weight here is a sum of one number for each corner: it
depends on the valence of the corner and on where the point lies as seen from it.  M and L have
weights of their own, because their integrands behave differently near such a vertex.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ..runtime.arrays import FloatArray
from .patch_class import PatchClass

# All constants were fitted by tools/fit_quadrature.py, which says how.  The points are an orbit of
# three (the small coordinate), an orbit of six (two coordinates) and the centre.
_THREE, _SIX = 0.0625, (0.0762, 0.3087)

# By valence of a corner, in millionths: what it adds to the weights of points, in the order of
# their barycentric coordinate at that corner (six kinds of points).
_FOR_MASS = {
    4: (7376, 18393, 17407, 31657, 18587, 11484),
    5: (7222, 18787, 18279, 27768, 19685, 10953),
    6: (7292, 18365, 18199, 30529, 17736, 12954),
    7: (7279, 18277, 18332, 30047, 18361, 12119),
    8: (7216, 18060, 18677, 30361, 18037, 12326),
    9: (7350, 17567, 18330, 32208, 17787, 12390),
    10: (7495, 17119, 18098, 33756, 17469, 12550),
}
_FOR_STIFFNESS = {
    4: (7379, 18773, 17720, 28490, 19773, 10887),
    5: (7128, 18692, 18393, 28282, 19120, 11719),
    6: (7382, 18600, 17651, 29914, 18885, 11717),
    7: (6998, 18424, 18694, 29218, 18551, 12115),
    8: (6374, 18805, 19817, 26823, 18884, 12084),
    9: (5481, 19810, 20204, 25391, 19124, 12039),
    10: (6674, 18476, 19305, 28513, 18782, 11679),
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
    if any(corner.is_boundary for corner in patch_class) or not _FOR_MASS.keys() >= set(valences):
        return False
    # Measured: beyond 1e-3 in octahedra, in the thin triangles around a pole, and where vertices
    # of high and low valence meet.
    if valences.count(4) > 1 or valences == [5, 5, 6]:
        return False
    return valences[-1] < 9 or sum(abs(valence - 6) for valence in valences) <= 5


@lru_cache(maxsize=4096)
def fitted_weights(valences: tuple[int, int, int]) -> FloatArray:
    """Weights of `POINTS` on a patch with these valences of its corners: positive, sum 1/2.

    Returns
    -------
    (2, n_points)
        For M and the measures, and for L.
    """
    weights = np.zeros((2, len(POINTS)))
    for own, numbers in zip(weights, (_FOR_MASS, _FOR_STIFFNESS), strict=True):
        for kind, valence in zip(_KIND, valences, strict=True):
            own += np.array(numbers[valence])[kind]
    weights *= 0.5 / weights.sum(axis=1, keepdims=True)
    weights.setflags(write=False)
    return weights
