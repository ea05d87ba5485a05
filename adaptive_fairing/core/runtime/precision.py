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
    """Bounds within which single precision changes nothing that counts.

    Attributes
    ----------
    least_triangles : float
        From this number on the time of a step counts.
    least_tolerance : float
        Of the quadrature: a hundred times the rounding of matrix entries.
    times : two floats
        Bounds of the largest timestep or diffusivity in the [-3, 3]³ frame: no number overflows.
    thinnest : float
        Least area element over the squared lengths of the tangents.  Rounding makes the metric of
        thinner triangles indefinite.
    shortest : float
        Least length of tangents in the [-3, 3]³ frame: its sixth power must not underflow.
    least_mass : float
        Least row sum of M over the diagonal of M + L.  Rows of L add up to 0, but rounding leaves
        1e-7 of the diagonal.
    least_reduction : float
        Least ratio of the residuals after and before a solve.
    """

    least_triangles: float = 20_000
    least_tolerance: float = 1e-4
    times: tuple[float, float] = (1e-15, 1e3)
    thinnest: float = 1e-3
    shortest: float = 1e-6
    least_mass: float = 1e-3
    least_reduction: float = 1e-4

    def serves_mesh(self, n_triangles: int, tolerance: float, is_normalized: bool) -> bool:
        """Whether it pays for a mesh, and is as exact as the quadrature."""
        is_large = n_triangles >= self.least_triangles
        return is_large and is_normalized and tolerance >= self.least_tolerance

    def serves_times(self, times: RealArray) -> bool:
        """Whether timesteps or diffusivities (n,) are in range."""
        low, high = self.times
        return bool(low < times.max(initial=0) < high)

    def serves_metric(self, g11: RealArray, g22: RealArray, area_element: RealArray) -> bool:
        """Whether it resolves a metric at points (n,)."""
        # Not "<": a surface that has shrunk to a point has 0 on both sides.
        is_thick = area_element > self.thinnest * (g11 + g22)
        return bool(is_thick.all() and g11.min() >= self.shortest**2)

    def serves_masses(self, masses: RealArray, diagonal: RealArray) -> bool:
        """Whether M + L, with this diagonal (n,), tells its row sums (n,) from rounding errors."""
        return bool((masses > self.least_mass * diagonal).all())

    def serves_solve(self, before: float, after: float) -> bool:
        """Whether a residual can be reduced so far."""
        return after >= self.least_reduction * before


SINGLE = SinglePrecision()
