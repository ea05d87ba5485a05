"""Differential geometry at quadrature points: metric, area element, mean curvature, measures.

All arrays run over points in their last axis, so that the same lines serve one point or a million.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# A triangle whose limit patch is thinner than this ratio counts as having it: slivers and collapsed
# triangles get a large but bounded metric instead of a division by zero.
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

    g11: FloatArray
    g12: FloatArray
    g22: FloatArray
    normal: FloatArray
    area_element: FloatArray


def metric_at(tangents: FloatArray) -> Metric:
    """Compute the metric from the tangents ∂1 x, ∂2 x, given as (2, 3, n_points)."""
    (u0, u1, u2), (v0, v1, v2) = tangents
    g11 = u0 * u0 + u1 * u1 + u2 * u2
    g12 = u0 * v0 + u1 * v1 + u2 * v2
    g22 = v0 * v0 + v1 * v1 + v2 * v2
    normal = np.stack([u1 * v2 - u2 * v1, u2 * v0 - u0 * v2, u0 * v1 - u1 * v0])
    area_element = np.sqrt(np.einsum("dp,dp->p", normal, normal))
    trace = g11 + g22
    bound = THINNEST_ASPECT * trace
    thin = np.flatnonzero(area_element < bound)
    if len(thin):
        # The metric with the bounded area element: g stays definite beyond doubt by rounding.
        g11[thin] += THINNEST_ASPECT**2 * trace[thin]
        g22[thin] += THINNEST_ASPECT**2 * trace[thin]
        area_element[thin] = bound[thin]
    np.maximum(area_element, _TINY, out=area_element)
    return Metric(g11, g12, g22, normal, area_element)


def mean_curvature(metric: Metric, second_derivatives: FloatArray) -> FloatArray:
    """Mean curvature H at points, positive where the surface bends away from its normal.

    Parameters
    ----------
    metric : Metric
    second_derivatives : (3, 3, n_points)
        ∂11 x, ∂12 x, ∂22 x.

    Source: 2 H = tr(g⁻¹ h) up to the sign, with the second fundamental form h.
    """
    trace: FloatArray
    h11, h12, h22 = np.einsum("adp,dp->ap", second_derivatives, metric.normal)
    trace = h12 * metric.g12
    trace *= -2
    trace += h11 * metric.g22
    trace += h22 * metric.g11
    # One division at a time: the cube of a tiny area element would underflow.
    for _ in range(3):
        trace /= metric.area_element
    trace *= -0.5
    return trace
