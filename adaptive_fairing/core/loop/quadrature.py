"""Quadrature on the unit triangle {ξ1, ξ2 ≥ 0, ξ1 + ξ2 ≤ 1}, and the rule for a tolerance.

All rules are symmetric under the six symmetries of the triangle, so that an integral does not
depend on the corner at which a face happens to start.  Weights sum to 1/2, the triangle's area.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..errors import SettingsError
from ..runtime.arrays import FloatArray

# With so few triangles the surface bends strongly within each of them, and a finer rule takes
# little time.
COARSE_TRIANGLES = 512

# Up to this part of regular patches a mesh is irregular: its few regular triangles are of all
# shapes as well, while those of regular meshes are nearly equilateral.
IRREGULAR = 0.5

# The first row whose tolerance is small enough, and whose bounds hold for the mesh, is taken.
# Tolerances are the measured errors of the entries of M and L against the subdivided reference, in
# units of the largest entry, on random meshes of valences 3 to 10 (tests/core repeats this).
_CHOICES: tuple[tuple[float, float, float, int, int, int, bool], ...] = (
    # tolerance; most triangles; largest part of regular patches; degree in regular patches; degree
    # in each part of an irregular patch that is subdivided so often; whether a fitted rule serves
    # instead, where there is one
    (1e-2, math.inf, 1, 4, 2, 1, True),
    (1e-3, COARSE_TRIANGLES, 1, 6, 4, 1, False),
    (1e-3, math.inf, IRREGULAR, 6, 4, 1, True),
    (1e-3, math.inf, 1, 4, 4, 1, True),
    (1e-4, math.inf, 1, 6, 8, 3, False),
    (1e-5, math.inf, 1, 8, 8, 5, False),
    (1e-6, math.inf, 1, 12, 12, 7, False),
)


@dataclass(frozen=True, eq=False)
class QuadratureRule:
    """Points and weights on the unit triangle.

    Attributes
    ----------
    points : (n_points, 2)
        Parametric coordinates (ξ1, ξ2).
    weights : (n_points,)
        Positive, with sum 1/2.
    degree : int
        Polynomials of this total degree are integrated exactly.
    """

    points: FloatArray
    weights: FloatArray
    degree: int


@dataclass(frozen=True, eq=False)
class QuadratureChoice:
    """Quadrature rules for regular and irregular patches.

    Attributes
    ----------
    regular : QuadratureRule
        For patches without extraordinary corners: smooth integrands.
    irregular : QuadratureRule
        For each part of a patch that is subdivided towards its extraordinary corners, where
        sqrt(det g) behaves like a power of the distance.
    depth : int
        How often it is subdivided.
    prefers_fitted : bool
        Whether irregular patches that have a fitted rule use it instead.
    """

    regular: QuadratureRule
    irregular: QuadratureRule
    depth: int
    prefers_fitted: bool


def quadrature_choice(
    tolerance: float, n_triangles: float = math.inf, regular_part: float = 1.0
) -> QuadratureChoice:
    """Pick the cheapest rules that keep M and L within `tolerance` of the exact integrals.

    Parameters
    ----------
    tolerance : float
        In units of the largest entry of each matrix.
    n_triangles, regular_part : float
        Size of the mesh, and how large a part of its patches is regular; by default a large
        regular mesh.

    Raises
    ------
    SettingsError
        If `tolerance` is not a number between 1e-6 and 1.
    """
    finest = _CHOICES[-1][0]
    if not finest <= tolerance <= 1:
        raise SettingsError(f"quadrature_tolerance must lie in [{finest:g}, 1], not {tolerance!r}")
    row = next(
        row
        for row in _CHOICES
        if row[0] <= tolerance and n_triangles <= row[1] and regular_part <= row[2]
    )
    return _choice(*row[3:])


@lru_cache(maxsize=16)
def _choice(regular: int, irregular: int, depth: int, fitted: bool) -> QuadratureChoice:
    return QuadratureChoice(triangle_rule(regular), triangle_rule(irregular), depth, fitted)


@lru_cache(maxsize=16)
def triangle_rule(degree: int) -> QuadratureRule:
    """Return a symmetric rule that is exact for polynomials of total degree `degree`."""
    if degree <= 2:
        return _from_orbits([(1 / 3, 2 / 3)], [], degree=2)
    if degree <= 4:
        return _from_orbits(_strang_fix_degree_4(), [], degree=4)
    if degree <= 6:
        return _from_orbits(*_DUNAVANT_6, degree=6)
    if degree <= 8:
        return _from_orbits(*_DUNAVANT_8, degree=8)
    if degree <= 12:
        return _from_orbits(*_DUNAVANT_12, degree=12)
    return _symmetrised_product_rule(degree)


# Orbits of D. A. Dunavant, High degree efficient symmetrical Gaussian quadrature rules for the
# triangle, IJNME 21 (1985): three-point orbits (weight, large barycentric coordinate) and
# six-point orbits (weight, two barycentric coordinates); weights relative to the triangle's area.
_DUNAVANT_6 = (
    [
        (0.116786275726379, 0.501426509658179),
        (0.050844906370207, 0.873821971016996),
    ],
    [(0.082851075618374, 0.053145049844817, 0.310352451033784)],
)
_DUNAVANT_8 = (
    [
        (0.144315607677787, 1 / 3),
        (0.095091634267285, 0.081414823414554),
        (0.103217370534718, 0.658861384496480),
        (0.032458497623198, 0.898905543365938),
    ],
    [(0.027230314174435, 0.008394777409958, 0.263112829634638)],
)
_DUNAVANT_12 = (
    [
        (0.025731066440455, 0.023565220452390),
        (0.043692544538038, 0.120551215411079),
        (0.062858224217885, 0.457579229975768),
        (0.034796112930709, 0.744847708916828),
        (0.006166261051559, 0.957365299093579),
    ],
    [
        (0.040371557766381, 0.115343494534698, 0.275713269685514),
        (0.022356773202303, 0.022838332222257, 0.281325580989940),
        (0.017316231108659, 0.025734050548330, 0.116251915907597),
    ],
)


def _strang_fix_degree_4() -> list[tuple[float, float]]:
    """Two three-point orbits of degree 4 (G. R. Cowper 1973), in closed form."""
    root = np.sqrt(38 - 44 * np.sqrt(2 / 5))
    weight_root = np.sqrt(213125 - 53320 * np.sqrt(10))
    small = [(8 - np.sqrt(10) + sign * root) / 18 for sign in (1, -1)]
    weights = [(620 + sign * weight_root) / 3720 for sign in (1, -1)]
    return [(weight, 1 - 2 * bary) for weight, bary in zip(weights, small, strict=True)]


def _from_orbits(
    three: list[tuple[float, float]], six: list[tuple[float, float, float]], degree: int
) -> QuadratureRule:
    points, weights = [], []
    for weight, large in three:
        small = (1 - large) / 2
        orbit = [(small, small), (large, small), (small, large)]
        if np.isclose(large, small):
            orbit = orbit[:1]
        points += orbit
        weights += [weight] * len(orbit)
    for weight, a, b in six:
        c = 1 - a - b
        orbit = [(a, b), (b, a), (b, c), (c, b), (c, a), (a, c)]
        points += orbit
        weights += [weight] * 6
    return _frozen_rule(np.array(points), np.array(weights), degree)


def _symmetrised_product_rule(degree: int) -> QuadratureRule:
    """Collapse a square Gauss rule onto the triangle and average it over the six symmetries."""
    n_1d = degree // 2 + 1
    nodes, weights = np.polynomial.legendre.leggauss(n_1d)
    # The collapse (s, t) -> (s (1 - t), t) has Jacobian 1 - t: one degree more along t.
    nodes_t, weights_t = np.polynomial.legendre.leggauss(n_1d + 1)
    s, t = (nodes + 1) / 2, (nodes_t + 1) / 2
    xi1 = (s[:, None] * (1 - t)).ravel()
    xi2 = np.broadcast_to(t, (n_1d, n_1d + 1)).ravel()
    weight = (weights[:, None] / 2 * weights_t / 2 * (1 - t)).ravel()
    bary = np.stack([1 - xi1 - xi2, xi1, xi2], axis=1)
    orders = [(1, 2), (2, 1), (0, 1), (1, 0), (2, 0), (0, 2)]
    points = np.concatenate([bary[:, order] for order in orders])
    return _frozen_rule(points, np.tile(weight, 6), degree)


def _frozen_rule(points: FloatArray, weights: FloatArray, degree: int) -> QuadratureRule:
    weights = weights * (0.5 / weights.sum())
    points.setflags(write=False)
    weights.setflags(write=False)
    return QuadratureRule(points, weights, degree)
