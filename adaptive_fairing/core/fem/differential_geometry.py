"""Differential geometry at quadrature points: metric, area element, mean curvature, measures.

All arrays run over points in their last axis, so that the same lines serve one point or a million.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..runtime.arrays import RealArray

# Least area element over the squared lengths of the tangents.  Slivers and collapsed triangles are
# computed as if they had this ratio, so that nothing is divided by zero.
THINNEST_ASPECT = 1e-5
_TINY = 1e-100


@dataclass(frozen=True)
class SurfaceMeasures:
    """Integrals over the limit surface.

    Attributes
    ----------
    curvature_energy : float
        H(t) = ∫ |H|² with |H| = 1/r and energy 4π on a sphere of radius r; has no unit.
    area : float
        In squared units of the positions.
    volume : float
        Enclosed volume, positive if the triangles are counter-clockwise as seen from outside;
        nan for an open surface.

    Source: section 3.4 of the paper; the mean curvature vector is Δx = 2 H n.
    """

    curvature_energy: float
    area: float
    volume: float

    def scaled(self, length: float) -> SurfaceMeasures:
        """Return the measures of the same surface, enlarged by the factor `length`."""
        return SurfaceMeasures(
            self.curvature_energy, self.area * length**2, self.volume * length**3
        )


class Metric(NamedTuple):
    """First fundamental form at points.

    Attributes
    ----------
    g11, g12, g22 : (n_points,)
        Scalar products of the tangents, bounded from below like the area element.
    normal : (3, n_points)
        Cross product of the tangents, not normalised.
    area_element : (n_points,)
        sqrt(det g), bounded from below relative to the trace (see `THINNEST_ASPECT`).
    """

    g11: RealArray
    g12: RealArray
    g22: RealArray
    normal: RealArray
    area_element: RealArray


def metric_at(tangents: RealArray) -> Metric:
    """Compute the metric from the tangents ∂1 x, ∂2 x, given as (2, 3, n_points)."""
    u, v = tangents
    g11, g12, g22 = _product(u, u), _product(u, v), _product(v, v)
    normal = np.empty((3, len(g11)), g11.dtype)
    # Two components at once: (u1, u2) with (v2, v0), and (u2, u0) with (v1, v2).
    np.multiply(u[1:], v[2::-2], out=normal[:2])
    normal[:2] -= u[2::-2] * v[1:]
    np.multiply(u[0], v[1], out=normal[2])
    normal[2] -= u[1] * v[0]
    area_element = _product(normal, normal)
    np.sqrt(area_element, out=area_element)
    trace = g11 + g22
    bound = THINNEST_ASPECT * trace
    if (area_element < bound).any():
        thin = np.flatnonzero(area_element < bound)
        # The metric with the bounded area element: g stays definite beyond doubt by rounding.
        g11[thin] += THINNEST_ASPECT**2 * trace[thin]
        g22[thin] += THINNEST_ASPECT**2 * trace[thin]
        area_element[thin] = bound[thin]
    np.maximum(area_element, _TINY, out=area_element)
    return Metric(g11, g12, g22, normal, area_element)


def mean_curvature(metric: Metric, second_derivatives: RealArray) -> RealArray:
    """Mean curvature H at points, positive where the surface bends away from its normal.

    Parameters
    ----------
    metric : Metric
    second_derivatives : (3, 3, n_points)
        ∂11 x, ∂12 x, ∂22 x.

    Source: 2 H = tr(g⁻¹ h) up to the sign, with the second fundamental form h.
    """
    trace: RealArray
    x11, x12, x22 = second_derivatives
    trace = _product(x12, metric.normal)
    trace *= metric.g12
    trace *= -2
    for x, g in ((x11, metric.g22), (x22, metric.g11)):
        h = _product(x, metric.normal)
        h *= g
        trace += h
    # One division at a time: the cube of a tiny area element would underflow.
    for _ in range(3):
        trace /= metric.area_element
    trace *= -0.5
    return trace


def _product(a: RealArray, b: RealArray) -> RealArray:
    """Scalar products of vectors at points, (3, n_points) each."""
    products: RealArray = np.einsum("dp,dp->p", a, b)
    return products


def energy_ratio(energy: float, initial: float) -> float:
    """H(t)/H(0), the fraction of the curvature energy that is left; 0 for a flat start."""
    return energy / initial if initial > 0 else 0.0
