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
from .diffusion_space import Diffusion, removed_by
from .lifted_metric import LiftedMetric
from .limit_surface import limit_matrix, near_control_points
from .linear_solver import SolveReport
from .local_frame import spacing_of
from .symmetric_matrix import SymmetricMatrix

FloatArray = NDArray[np.float64]


class FilterFamily(NamedTuple):
    """Several diffusions in one metric."""

    metric: LiftedMetric
    diffusions: tuple[Diffusion, ...]


# Creases need the gentle ones; smooth shapes, whose waves end somewhere, the steep ones too.
GENTLE = (Diffusion(0.25, 2, 4), Diffusion(1.0, 2, 4), Diffusion(4.0, 2, 4))
STEEP = (*GENTLE, Diffusion(0.5, 4, 4), Diffusion(1.2, 4, 4), Diffusion(3.0, 4, 4))

# Smoothing before the first metric of a surface can be taken.
FIRST = Diffusion(0.5, 2, 2)

# A vertex counts for at most so many times, or parts, of the others around it.
LARGEST_WEIGHT = 8.0

# Passes of (3.6) over the edge length that serves as the unit in a metric.
SPACING_PASSES = 3


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
        (removed,) = self._removed(self._mesh_matrices, control, [FIRST])
        smooth: FloatArray = self._limit @ (control - removed)
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
            for removed in self._removed(matrices, control, diffusions):
                yield self._limit @ (control - removed)

    def _matrices(
        self, metric: LiftedMetric, control: FloatArray, spacing: FloatArray
    ) -> tuple[SymmetricMatrix, SymmetricMatrix]:
        mass, stiffness = metric.matrices(self._space, control, spacing)
        return mass.weighted(self._weights), stiffness

    def _removed(
        self,
        matrices: tuple[SymmetricMatrix, SymmetricMatrix],
        control: FloatArray,
        diffusions: Sequence[Diffusion],
    ) -> list[FloatArray]:
        return removed_by(diffusions, *matrices, control, self._is_loose, self._on_solve)
