"""Bounds within which single precision is exact enough.

A step of a large mesh is computed in single precision, which saves about a fifth of its time.
Positions stay in double precision: the step solves for what it adds to them, and rounding
changes that by a relative error of 1e-6, far less than the quadrature does.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from .arrays import RealArray

Precision: TypeAlias = type[np.floating[Any]]


@dataclass(frozen=True)
class SinglePrecision:
    """Bounds within which single precision makes no relevant difference.

    Attributes
    ----------
    least_triangles : float
        Least number of triangles for which the saved time matters.
    least_tolerance : float
        Least quadrature tolerance: a hundred times the rounding of matrix entries.
    times : two floats
        Bounds of the largest timestep or diffusivity in the [-3, 3]³ frame, so that no number
        overflows.
    thinnest : float
        Least ratio of the area element to the squared lengths of the tangents.  Rounding makes the
        metric of thinner triangles indefinite.
    shortest : float
        Least length of tangents in the [-3, 3]³ frame: its sixth power must not underflow.
    least_mass : float
        Least ratio of a row sum of M to the diagonal of M + L.  Rows of L add up to 0, but rounding
        leaves 1e-7 of the diagonal.
    least_reduction : float
        Least ratio of the residual after a solve to the one before it.
    """

    least_triangles: float = 20_000
    least_tolerance: float = 1e-4
    times: tuple[float, float] = (1e-15, 1e3)
    thinnest: float = 1e-3
    shortest: float = 1e-6
    least_mass: float = 1e-3
    least_reduction: float = 1e-4

    def serves_mesh(self, n_triangles: int, tolerance: float, is_normalized: bool) -> bool:
        """Whether it saves relevant time on a mesh, and is as exact as the quadrature."""
        is_large = n_triangles >= self.least_triangles
        return is_large and is_normalized and tolerance >= self.least_tolerance

    def serves_times(self, times: RealArray) -> bool:
        """Whether timesteps or diffusivities (n,) are in range."""
        low, high = self.times
        return bool(low < times.max(initial=0) < high)

    def serves_metric(self, g11: RealArray, g22: RealArray, area_element: RealArray) -> bool:
        """Whether it resolves the metric at points (n,)."""
        # Not "<": a surface that has shrunk to a point has 0 on both sides.
        is_thick = area_element > self.thinnest * (g11 + g22)
        return bool(is_thick.all() and g11.min() >= self.shortest**2)

    def serves_masses(self, masses: RealArray, diagonal: RealArray) -> bool:
        """Whether row sums (n,) of M + L, with this diagonal (n,), stand above rounding errors."""
        return bool((masses > self.least_mass * diagonal).all())

    def serves_solve(self, before: float, after: float) -> bool:
        """Whether a solve can reduce the residual by this factor."""
        return after >= self.least_reduction * before


SINGLE = SinglePrecision()
