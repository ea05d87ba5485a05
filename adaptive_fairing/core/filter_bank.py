"""The filters that `auto` chooses from: corrected diffusion in several metrics, over several times.

One step of semi-implicit diffusion is S = (M + t L)⁻¹ M.  It also shrinks what it should keep; to
add what S makes of the part that it removed, and of what is still missing then, gives
1 - (1 - S)ᵖ: p times the order of accuracy at long waves, and still damps the short ones.  Several
such steps make one filter, the steeper the larger p.

A vertex whose edges are shorter than those around it has less noise than its neighbours, as far as
noise grows with the edges: M counts it for more.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .assembly import LoopSpace
from .lifted_metric import LiftedMetric
from .limit_surface import limit_matrix, near_control_points
from .linear_solver import SolveReport, conjugate_gradients
from .noise_level import spacing_of
from .symmetric_matrix import SymmetricMatrix

FloatArray = NDArray[np.float64]


class Diffusion(NamedTuple):
    """A filter (1 - (1 - S)ᵖ)ᵏ.

    Attributes
    ----------
    time : float
        t of S, in squared edge lengths.
    order : int
        p.
    steps : int
        k.
    """

    time: float
    order: int
    steps: int

    @property
    def n_solves(self) -> int:
        """Number of times that S is applied."""
        return self.order * self.steps


class FilterFamily(NamedTuple):
    """Several diffusions in one metric."""

    metric: LiftedMetric
    diffusions: tuple[Diffusion, ...]

    @property
    def n_solves(self) -> int:
        """Number of linear solves for one set of positions."""
        return sum(diffusion.n_solves for diffusion in self.diffusions)


# Creases need the gentle ones; smooth shapes, whose waves end somewhere, the steep ones too.
GENTLE = (Diffusion(0.25, 2, 4), Diffusion(1.0, 2, 4), Diffusion(4.0, 2, 4))
STEEP = (*GENTLE, Diffusion(0.5, 4, 4), Diffusion(1.2, 4, 4), Diffusion(3.0, 4, 4))

# Smoothing before the first metric of a surface can be taken.
FIRST = Diffusion(0.5, 2, 2)

# A vertex counts for at most so many times, or parts, of the others around it.
LARGEST_WEIGHT = 8.0

# Passes of (3.6) over the edge length that serves as the unit in a metric.
SPACING_PASSES = 3

# Relative to what is filtered: the positions, or the small part that is still missing.
FILTER_TOLERANCE = 1e-4
MISSING_TOLERANCE = 1e-2
MAX_ITERATIONS = 5000


class FilterBank:
    """Filters for positions on one topology.

    Parameters
    ----------
    space : LoopSpace
    positions : (n, 3)
        Decide the weights of the vertices.
    on_solve : callable
        Called after each linear solve with its report.
    """

    def __init__(
        self,
        space: LoopSpace,
        positions: FloatArray,
        on_solve: Callable[[SolveReport], None],
    ) -> None:
        self._space = space
        self._limit = limit_matrix(space.topology)
        self._is_loose = space.topology.is_loose
        self._on_solve = on_solve
        around = spacing_of(space.topology, positions, SPACING_PASSES)
        ratio = around / spacing_of(space.topology, positions, 0)
        self._weights = np.clip(ratio, 1 / LARGEST_WEIGHT, LARGEST_WEIGHT)
        # Does not see the surface: any will do.
        n = space.topology.n_vertices
        self._mesh_matrices = self._matrices(LiftedMetric(), np.zeros((n, 3)), np.ones(n))

    def first_surface(self, positions: FloatArray) -> FloatArray:
        """Smooth positions enough for a metric to be taken from them."""
        control = near_control_points(self._limit, positions)
        smooth: FloatArray = self._limit @ self._diffused(self._mesh_matrices, control, FIRST)
        return smooth

    def filtered(
        self, positions: FloatArray, surface: FloatArray, families: Sequence[FilterFamily]
    ) -> Iterator[FloatArray]:
        """Filter positions in the metrics of a surface.

        Parameters
        ----------
        positions : (n, 3)
        surface : (n, 3)
            Positions of the surface that the metrics are taken from.
        families : sequence of FilterFamily

        Yields
        ------
        (n, 3)
            What the next filter makes of the positions, family by family.
        """
        control = near_control_points(self._limit, positions)
        spacing = spacing_of(self._space.topology, surface, SPACING_PASSES)
        surface_control = near_control_points(self._limit, surface)
        for metric, diffusions in families:
            if metric == LiftedMetric():
                matrices = self._mesh_matrices
            else:
                matrices = self._matrices(metric, surface_control, spacing)
            for diffusion in diffusions:
                yield self._limit @ self._diffused(matrices, control, diffusion)

    def _matrices(
        self, metric: LiftedMetric, control: FloatArray, spacing: FloatArray
    ) -> tuple[SymmetricMatrix, SymmetricMatrix]:
        mass, stiffness = metric.matrices(self._space, control, spacing)
        return mass.weighted(self._weights), stiffness

    def _diffused(
        self,
        matrices: tuple[SymmetricMatrix, SymmetricMatrix],
        control: FloatArray,
        diffusion: Diffusion,
    ) -> FloatArray:
        """Apply a diffusion to control points."""
        mass, stiffness = matrices
        system = mass.plus(diffusion.time, stiffness)
        for _ in range(diffusion.steps):
            whole, control = control, self._solve(system, mass, control, FILTER_TOLERANCE)
            for _ in range(diffusion.order - 1):
                control = control + self._solve(system, mass, whole - control, MISSING_TOLERANCE)
        return control

    def _solve(
        self,
        system: SymmetricMatrix,
        mass: SymmetricMatrix,
        control: FloatArray,
        tolerance: float,
    ) -> FloatArray:
        smooth, report = conjugate_gradients(
            system,
            mass.product(control.T).T,
            control,
            is_held=self._is_loose,
            tolerance=tolerance,
            max_iterations=MAX_ITERATIONS,
        )
        self._on_solve(report)
        return smooth
