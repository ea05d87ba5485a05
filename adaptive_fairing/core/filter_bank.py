"""The filters that `auto` chooses from: corrected diffusion in several metrics, over several times.

One step of semi-implicit diffusion is S = (M + t L)⁻¹ M.  It also shrinks what it should keep; to
add what S makes of the part that it removed, S + S (1 - S) = 1 - (1 - S)², leaves twice the order
of accuracy at long waves and still damps the short ones.  Four such steps make one filter.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
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

# Times t of one step, in squared edge lengths.
TIMES = (0.25, 1.0, 4.0)
CORRECTED_STEPS = 4

# Smoothing before the first metric of a surface can be taken.
FIRST_TIME = 0.5
FIRST_STEPS = 2

# Passes of (3.6) over the edge length that serves as the unit in a metric.
SPACING_PASSES = 3

FILTER_TOLERANCE = 1e-4
MAX_ITERATIONS = 5000


class Filtered(NamedTuple):
    """What a filter makes of the positions.

    Attributes
    ----------
    positions : (n, 3)
    metric : LiftedMetric
    time : float
        Of one step, in squared edge lengths.
    """

    positions: FloatArray
    metric: LiftedMetric
    time: float


class FilterBank:
    """Filters on one topology.

    Parameters
    ----------
    space : LoopSpace
    on_solve : callable
        Called after each linear solve with its report.
    """

    def __init__(self, space: LoopSpace, on_solve: Callable[[SolveReport], None]) -> None:
        self._space = space
        self._limit = limit_matrix(space.topology)
        self._is_loose = space.topology.is_loose
        self._on_solve = on_solve
        n = space.topology.n_vertices
        # Does not see the surface: any will do.
        self._mesh_matrices = LiftedMetric().matrices(space, np.zeros((n, 3)), np.ones(n))

    def first_surface(self, positions: FloatArray) -> FloatArray:
        """Smooth positions enough for a metric to be taken from them."""
        control = near_control_points(self._limit, positions)
        control = self._corrected(self._mesh_matrices, control, FIRST_TIME, FIRST_STEPS)
        smooth: FloatArray = self._limit @ control
        return smooth

    def filtered(
        self, positions: FloatArray, surface: FloatArray, metrics: Sequence[LiftedMetric]
    ) -> list[Filtered]:
        """Filter positions in the metrics of a surface, over all times.

        Parameters
        ----------
        positions : (n, 3)
        surface : (n, 3)
            Positions of the surface that the metrics are taken from.
        metrics : sequence of LiftedMetric
        """
        control = near_control_points(self._limit, positions)
        spacing = spacing_of(self._space.topology, surface, SPACING_PASSES)
        surface_control = near_control_points(self._limit, surface)
        results = []
        for metric in metrics:
            if metric == LiftedMetric():
                matrices = self._mesh_matrices
            else:
                matrices = metric.matrices(self._space, surface_control, spacing)
            for time in TIMES:
                smooth = self._corrected(matrices, control, time, CORRECTED_STEPS)
                results.append(Filtered(self._limit @ smooth, metric, time))
        return results

    def _corrected(
        self,
        matrices: tuple[SymmetricMatrix, SymmetricMatrix],
        control: FloatArray,
        time: float,
        steps: int,
    ) -> FloatArray:
        """Apply 1 - (1 - S)² several times to control points."""
        mass, stiffness = matrices
        system = mass.plus(time, stiffness)
        for _ in range(steps):
            once = self._solve(system, mass, control)
            control = 2 * once - self._solve(system, mass, once)
        return control

    def _solve(
        self, system: SymmetricMatrix, mass: SymmetricMatrix, control: FloatArray
    ) -> FloatArray:
        smooth, report = conjugate_gradients(
            system,
            mass.product(control.T).T,
            control,
            is_held=self._is_loose,
            tolerance=FILTER_TOLERANCE,
            max_iterations=MAX_ITERATIONS,
        )
        self._on_solve(report)
        return smooth


def n_solves(n_metrics: int) -> int:
    """Count the linear solves of the first surface and of filtering in so many metrics."""
    return 2 * (FIRST_STEPS + n_metrics * len(TIMES) * CORRECTED_STEPS)
