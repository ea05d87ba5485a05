"""Bilinear forms: the factors of basis products at a quadrature point."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from ..runtime.arrays import RealArray
from ..runtime.threads import Workspace
from .surface_evaluation import SurfaceBlock

_workspace = Workspace()


class Form(Protocol):
    """A symmetric bilinear form of second order in parametric coordinates."""

    @property
    def measured(self) -> bool:
        """Whether the load -L X and the surface's measures are integrated in the same pass."""

    @property
    def curved(self) -> bool:
        """Whether the form, or the measuring, needs second derivatives of the surface."""

    def coefficients(self, surface: SurfaceBlock) -> RealArray:
        """Compute the factors of φa φb, ∂1φa ∂1φb, ∂1φa ∂2φb + ∂2φa ∂1φb and ∂2φa ∂2φb, (4, n)."""


class ScalarForm(NamedTuple):
    """M and L of the paper, with a scalar field as timestep or as diffusivity."""

    inverse_mass: bool = False
    scaled_stiffness: bool = False
    measured: bool = False

    @property
    def curved(self) -> bool:
        """Second derivatives are needed for the curvature energy alone."""
        return self.measured

    def coefficients(self, surface: SurfaceBlock) -> RealArray:
        """Factors of the product table at each point, (4, n_points): t⁻¹ √g, then c √g g⁻¹."""
        metric = surface.metric
        field = 1 if surface.field is None else surface.field
        coefficients = np.empty((4, len(metric.area_element)), surface.precision)
        np.divide(metric.area_element, field if self.inverse_mass else 1, out=coefficients[0])
        factor = (field if self.scaled_stiffness else 1) / metric.area_element
        np.multiply(metric.g22, factor, out=coefficients[1])
        np.multiply(metric.g11, factor, out=coefficients[3])
        np.multiply(metric.g12, factor, out=factor)
        np.negative(factor, out=coefficients[2])
        return coefficients


def gradient_fluxes(surface: SurfaceBlock, coefficients: RealArray) -> RealArray:
    """Compute c √g g⁻¹ ∂x at each point: with ∂φ, the integrand of L x.

    Parameters
    ----------
    surface : SurfaceBlock
    coefficients : (4, n_points)
        As a form computes them.

    Returns
    -------
    (3, 2, n_points)
        Valid until this thread's next call.
    """
    _, c11, c12, c22 = coefficients
    first, second = surface.tangents
    precision = c11.dtype.type
    fluxes = _workspace.array("fluxes", 3, 2, len(c11), dtype=precision)
    mixed = _workspace.array("mixed", 3, len(c11), dtype=precision)
    for flux, c1, c2 in ((fluxes[:, 0], c11, c12), (fluxes[:, 1], c12, c22)):
        np.multiply(c1, first, out=flux)
        flux += np.multiply(c2, second, out=mixed)
    return fluxes
