"""Quartic box splines: the Loop basis on a regular patch, inside the surface and on its boundary.

Source: J. Stam, Evaluation of Loop subdivision surfaces, 1998.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from ..runtime.arrays import FloatArray, LongArray
from .patch_class import ControlPoints, PatchClass

# Exponents of the monomials of the splines, degree 4, and of their first and second derivatives.
_EXPONENTS = [powers for powers in product(range(5), repeat=3) if 2 <= sum(powers) <= 4]


def _box_spline_coefficients() -> LongArray:
    """Integer coefficients of the splines by monomial, (12, 31), common factor 1/12.

    In barycentric coordinates (u, v, w) of the triangle the twelve quartic box splines are three
    polynomials up to symmetry: that of a corner, of the vertex across an edge, and of a tip.
    Source: J. Stam 1998, appendix A.
    """
    at_u = {
        (4, 0, 0): 6, (3, 1, 0): 24, (3, 0, 1): 24, (2, 2, 0): 24, (2, 1, 1): 60, (2, 0, 2): 24,
        (1, 3, 0): 8, (1, 2, 1): 36, (1, 1, 2): 36, (1, 0, 3): 8,
        (0, 4, 0): 1, (0, 3, 1): 6, (0, 2, 2): 12, (0, 1, 3): 6, (0, 0, 4): 1,
    }  # fmt: skip
    across_uw = {
        (4, 0, 0): 1, (3, 0, 1): 6, (2, 0, 2): 12, (1, 0, 3): 6, (0, 0, 4): 1,
        (3, 1, 0): 2, (2, 1, 1): 6, (1, 1, 2): 6, (0, 1, 3): 2,
    }  # fmt: skip
    tip_w = {(4, 0, 0): 1, (3, 0, 1): 2}
    tip_v = {(4, 0, 0): 1, (3, 1, 0): 2}

    coefficients = np.zeros((12, len(_EXPONENTS)), dtype=np.int64)
    for corner in range(3):
        # Ring entries 2, 3, 4 of a corner: across the edge to the previous corner, then the tips.
        for slot, polynomial in zip(
            (corner, 3 + 3 * corner, 4 + 3 * corner, 5 + 3 * corner),
            (at_u, across_uw, tip_w, tip_v),
            strict=True,
        ):
            for exponent, value in polynomial.items():
                rotated = (
                    exponent[-corner % 3],
                    exponent[(1 - corner) % 3],
                    exponent[(2 - corner) % 3],
                )
                coefficients[slot, _EXPONENTS.index(rotated)] = value
    return coefficients


def _along(parameter: int, coefficients: LongArray) -> LongArray:
    """Differentiate by ξ1 or ξ2: ∂1 = ∂v - ∂u and ∂2 = ∂w - ∂u, because u = 1 - ξ1 - ξ2."""
    derivative = np.zeros_like(coefficients)
    for exponent, own in zip(_EXPONENTS, coefficients.T, strict=True):
        for axis, sign in ((parameter, 1), (0, -1)):
            lowered = tuple(power - (k == axis) for k, power in enumerate(exponent))
            if own.any() and exponent[axis]:
                derivative[:, _EXPONENTS.index(lowered)] += sign * exponent[axis] * own
    return derivative


def _with_derivatives(coefficients: LongArray) -> FloatArray:
    """Stack coefficients (12, 31) of the value, ∂1, ∂2, ∂11, ∂12, ∂22 as (6, 31, 12)."""
    first, second = _along(1, coefficients), _along(2, coefficients)
    seconds = [_along(1, first), _along(2, first), _along(2, second)]
    return np.stack([coefficients, first, second, *seconds]).transpose(0, 2, 1) / 12


_COEFFICIENTS = _with_derivatives(_box_spline_coefficients())


def box_splines(points: FloatArray) -> FloatArray:
    """Evaluate the twelve box splines of a regular patch and their derivatives.

    Parameters
    ----------
    points : (n_points, 2)

    Returns
    -------
    (6, n_points, 12)
        Value, ∂1, ∂2, ∂11, ∂12, ∂22.
    """
    points = np.asarray(points, dtype=np.float64)
    bary = np.stack([1 - points.sum(axis=1), points[:, 0], points[:, 1]], axis=1)
    powers = bary[:, :, None] ** np.arange(5)
    u, v, w = np.transpose(_EXPONENTS)
    monomials = powers[:, 0, u] * powers[:, 1, v] * powers[:, 2, w]
    values: FloatArray = monomials @ _COEFFICIENTS
    return values


def ghost_matrix(patch_class: PatchClass) -> FloatArray:
    """Express the 12 control points of a regular patch by those that exist, (12, n).

    Beyond a boundary edge (a, b) with third vertex c stands the ghost a + b - c; with it the box
    spline's own rules reproduce Loop's boundary rules exactly.
    """
    control = ControlPoints(patch_class)
    matrix = np.zeros((12, control.count))
    matrix[:3, :3] = np.eye(3)
    for i, corner in enumerate(patch_class):
        for k, entry in enumerate((2, 3, 4)):
            row = matrix[3 + 3 * i + k]
            if not corner.is_boundary:
                row[control.slot(i, entry)] += 1
                continue
            ring = control.ring(i)
            place = (corner.fan_position + entry) % 6
            if place < 4:
                row[ring[place]] += 1
            else:
                end, inner = (ring[3], ring[2]) if place == 4 else (ring[0], ring[1])
                np.add.at(row, [i, end], 1)
                row[inner] -= 1
    return matrix
