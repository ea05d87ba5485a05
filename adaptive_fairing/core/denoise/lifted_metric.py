"""Metrics that follow the mesh and the bending of a surface: what diffusion takes for distance.

The paper's scalar diffusion tensor makes diffusion as fast as the mesh is coarse.  Taken further,
the mesh itself gives the unit of length in every direction,

    ĝ = (1 - s) m + s g / h² + III / a²,

with the metric m in which every triangle is equilateral with unit edges, the surface's own metric
g in units of the local edge length h, and the third fundamental form III, in which the length of a
path is the angle by which the normal turns.  Points count as distant if many edges or a turn of
many times the angle a lie between them: diffusion with the Laplace-Beltrami operator of ĝ runs
along creases, not across them.

Source: the anisotropic diffusion of the paper's references [3] and [4], written as a metric in the
spirit of N. Sochen, R. Kimmel and R. Malladi, A general framework for low level vision, 1998.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..fem.differential_geometry import Metric
from ..fem.loop_space import LoopSpace
from ..fem.surface_evaluation import SurfaceBlock
from ..linalg.symmetric_matrix import SymmetricMatrix
from ..runtime.arrays import FloatArray

# Metric of a triangle with unit edges in its parametric coordinates: m11, m12, m22.
EQUILATERAL = (1.0, 0.5, 1.0)

# ĝ counts as at least this definite: relative to its squared trace.
LEAST_DETERMINANT = 1e-8


class LiftedMetric(NamedTuple):
    """Parameters of ĝ.

    Attributes
    ----------
    surface_share : float
        s in [0, 1]: 0 takes lengths from the mesh alone, 1 from the surface.
    angle : float or None
        a > 0 in radians; None leaves the bending out.
    """

    surface_share: float = 0.0
    angle: float | None = None

    def matrices(
        self, space: LoopSpace, positions: FloatArray, spacing: FloatArray
    ) -> tuple[SymmetricMatrix, SymmetricMatrix]:
        """Assemble mass and stiffness matrix in the metric ĝ of a surface.

        Parameters
        ----------
        space : LoopSpace
        positions : (n, 3)
            Control points of the surface.
        spacing : (n,)
            Local edge length h > 0, in the units of the positions.

        Returns
        -------
        M, L : SymmetricMatrix
            Time in (M + t L) is in squared edge lengths.
        """
        return space.mass_and_stiffness(_LiftedForm(self), positions, spacing)


class _LiftedForm(NamedTuple):
    """M and L in the metric ĝ, for the assembly."""

    lifted: LiftedMetric

    @property
    def measured(self) -> bool:
        return False

    @property
    def curved(self) -> bool:
        return self.lifted.angle is not None

    def coefficients(self, surface: SurfaceBlock) -> FloatArray:
        """√ĝ, and √ĝ ĝ⁻¹, at each point."""
        g11, g12, g22 = _lifted(self.lifted, surface)
        determinant = g11 * g22 - g12 * g12
        np.maximum(determinant, LEAST_DETERMINANT * (g11 + g22) ** 2, out=determinant)
        element = np.sqrt(determinant)
        return np.stack([element, g22 / element, -g12 / element, g11 / element])


def _lifted(lifted: LiftedMetric, surface: SurfaceBlock) -> FloatArray:
    """Entries of ĝ at each point, (3, n)."""
    metric, share = surface.metric, lifted.surface_share
    entries = np.empty((3, len(metric.area_element)))
    entries[:] = (1 - share) * np.array(EQUILATERAL)[:, None]
    if share > 0:
        entries += share * np.stack([metric.g11, metric.g12, metric.g22]) / surface.field**2
    if lifted.angle is not None and surface.second_derivatives is not None:
        entries += third_form(metric, surface.second_derivatives) / lifted.angle**2
    return entries


def third_form(metric: Metric, second_derivatives: FloatArray) -> FloatArray:
    """Third fundamental form, (3, n_points): III11, III12, III22 of III = II g⁻¹ II.

    Parameters
    ----------
    metric : Metric
    second_derivatives : (3, 3, n_points)
        ∂11 x, ∂12 x, ∂22 x.
    """
    h11, h12, h22 = np.einsum("adp,dp->ap", second_derivatives, metric.normal)
    # The normal has the length of the area element, as long as that is not bounded from below.
    for form in (h11, h12, h22):
        form /= metric.area_element
    determinant = metric.area_element**2
    i11, i12, i22 = metric.g22 / determinant, -metric.g12 / determinant, metric.g11 / determinant
    # The columns of g⁻¹ II.
    a1, a2 = i11 * h11 + i12 * h12, i12 * h11 + i22 * h12
    b1, b2 = i11 * h12 + i12 * h22, i12 * h12 + i22 * h22
    return np.stack([h11 * a1 + h12 * a2, h11 * b1 + h12 * b2, h12 * b1 + h22 * b2])
