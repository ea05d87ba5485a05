"""Bilinear forms: what multiplies the products of basis functions at a quadrature point."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from .blocks import SurfaceBlock

FloatArray = NDArray[np.float64]


class Form(Protocol):
    """A symmetric bilinear form of second order in parametric coordinates."""

    @property
    def measured(self) -> bool:
        """Whether the right side M X and the surface's measures are integrated on the way."""

    @property
    def curved(self) -> bool:
        """Whether the form, or the measuring, needs second derivatives of the surface."""

    def coefficients(self, surface: SurfaceBlock) -> FloatArray:
        """Compute the factors of φa φb, ∂1φa ∂1φb, ∂1φa ∂2φb + ∂2φa ∂1φb and ∂2φa ∂2φb, (4, n)."""


class ScalarForm(NamedTuple):
    """M and L of the paper: what a scalar field means in them."""

    inverse_mass: bool = False
    scaled_stiffness: bool = False
    measured: bool = False

    @property
    def curved(self) -> bool:
        """Second derivatives are needed for the curvature energy alone."""
        return self.measured

    def coefficients(self, surface: SurfaceBlock) -> FloatArray:
        """Factors of the product table at each point, (4, n_points): t⁻¹ √g, then c √g g⁻¹."""
        metric, field = surface.metric, surface.values[3]
        coefficients = np.empty((4, len(field)))
        np.divide(metric.area_element, field if self.inverse_mass else 1, out=coefficients[0])
        factor = (field if self.scaled_stiffness else 1) / metric.area_element
        np.multiply(metric.g22, factor, out=coefficients[1])
        np.multiply(metric.g11, factor, out=coefficients[3])
        np.multiply(metric.g12, factor, out=factor)
        np.negative(factor, out=coefficients[2])
        return coefficients


def gradient_fluxes(surface: SurfaceBlock) -> FloatArray:
    """Compute √g g⁻¹ ∂x at each point, (3, 2, n_points): with ∂φ, the integrand of L x."""
    metric = surface.metric
    first, second = surface.tangents
    fluxes = np.empty((3, 2, len(metric.area_element)))
    np.subtract(metric.g22 * first, metric.g12 * second, out=fluxes[:, 0])
    np.subtract(metric.g11 * second, metric.g12 * first, out=fluxes[:, 1])
    fluxes /= metric.area_element
    return fluxes
