"""The filters that `auto` chooses from: corrected diffusion in several metrics, over several times.

One step of semi-implicit diffusion is S = (M + t L)⁻¹ M.  It also shrinks what it should keep; to
add what S makes of the part that it removed, and of what is still missing then, gives
1 - (1 - S)ᵖ: p times the order of accuracy at long waves, and still damps the short ones.  Several
such steps make one filter, the steeper the larger p.

Where creases stand close together, no diffusion has room between them.  There another filter fits
the surface to smoothed normals of its triangles, again by a semi-implicit step.

A vertex whose edges are shorter than those around it has less noise than its neighbours, as far as
noise grows with the edges: M counts it for more.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from itertools import chain
from typing import NamedTuple

import numpy as np

from ..fem.loop_space import LoopSpace
from ..linalg.conjugate_gradients import SolveReport, conjugate_gradients
from ..linalg.krylov_filters import MAX_ITERATIONS, Diffusion, removed_by
from ..linalg.symmetric_matrix import SymmetricMatrix
from ..mesh.limit_surface import limit_matrix, near_control_points
from ..mesh.normals import triangle_normals, unit_vectors
from ..runtime.arrays import FloatArray, IntArray
from .lifted_metric import LiftedMetric
from .local_frame import spacing_of
from .normal_filter import Smoothing, smoothed_normals, triangles_around, turns_between

# With at most this angle a metric keeps creases, without one it rounds them; those between keep
# what stands out of the noise.
SHARP_ANGLE = 0.1

# Solves for the filters of one metric, as far as a progress goes; it differs a little.
SOLVES_PER_METRIC = 9


class FilterFamily(NamedTuple):
    """Several diffusions in one metric."""

    metric: LiftedMetric
    diffusions: tuple[Diffusion, ...]

    @property
    def n_filters(self) -> int:
        """Number of surfaces that come out."""
        return len(self.diffusions)

    @property
    def n_solves(self) -> int:
        """Number of linear solves, about."""
        return SOLVES_PER_METRIC

    @property
    def keeps_creases(self) -> bool:
        """Whether diffusion stops at every crease."""
        return self.metric.angle is not None and self.metric.angle <= SHARP_ANGLE

    @property
    def rounds_creases(self) -> bool:
        """Whether diffusion does not see creases."""
        return self.metric.angle is None

    def scaled(self, factor: float) -> FilterFamily:
        """Return the same diffusions with the metric's angle times a factor."""
        if self.metric.angle is None:
            return self
        return self._replace(metric=self.metric._replace(angle=factor * self.metric.angle))


class NormalFamily(NamedTuple):
    """Fits to the normals of triangles, smoothed in several ways."""

    smoothings: tuple[Smoothing, ...]

    @property
    def n_filters(self) -> int:
        """Number of surfaces that come out."""
        return sum(len(smoothing.passes) for smoothing in self.smoothings)

    @property
    def n_solves(self) -> int:
        """Number of linear solves."""
        return self.n_filters

    @property
    def keeps_creases(self) -> bool:
        """Normals are not smoothed across creases."""
        return True

    @property
    def rounds_creases(self) -> bool:
        """See `keeps_creases`."""
        return False

    def scaled(self, factor: float) -> NormalFamily:
        """Return itself: the angles of normals do not follow the noise."""
        return self


# Creases need the gentle ones; smooth shapes, whose waves end somewhere, the steep ones too.
GENTLE = (Diffusion(0.25, 2, 4), Diffusion(1.0, 2, 4), Diffusion(4.0, 2, 4))
STEEP = (*GENTLE, Diffusion(0.5, 4, 4), Diffusion(1.2, 4, 4), Diffusion(3.0, 4, 4))

# Smoothing before the first metric of a surface can be taken.
FIRST = Diffusion(0.5, 2, 2)

# Time of the step that fits a surface to normals, in squared edge lengths, and the tolerance of its
# solve; the metric is that of the surface.
FIT_TIME, FIT_TOLERANCE = 4.0, 1e-3
FIT_METRIC = LiftedMetric(1)

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
        self,
        positions: FloatArray,
        surface: FloatArray,
        families: Sequence[FilterFamily | NormalFamily],
    ) -> Iterator[FloatArray]:
        """Filter positions in the metrics of a surface, or that surface by its normals.

        Parameters
        ----------
        positions : (n, 3)
        surface : (n, 3)
            Positions of the surface that the metrics are taken from.
        families : sequence of FilterFamily and NormalFamily

        Yields
        ------
        (n, 3)
            What the next filter makes of them, family by family.
        """
        control = near_control_points(self._limit, positions)
        spacing = spacing_of(self._space.topology, surface, SPACING_PASSES)
        surface_control = near_control_points(self._limit, surface)
        for family in families:
            if isinstance(family, NormalFamily):
                yield from self._fitted(surface, surface_control, spacing, family)
                continue
            metric, diffusions = family
            if metric == LiftedMetric():
                matrices = self._mesh_matrices
            else:
                matrices = self._matrices(metric, surface_control, spacing)
            for removed in self._removed(matrices, control, diffusions):
                yield self._limit @ (control - removed)

    def _fitted(
        self, surface: FloatArray, control: FloatArray, spacing: FloatArray, family: NormalFamily
    ) -> Iterator[FloatArray]:
        """Fit a surface (n, 3) to its normals, smoothed.

        The step X - (M + t L)⁻¹ t b turns the tangents of every triangle as far as its normal was
        turned, with b = ∫ (∇x - R ∇x) · ∇φ.
        """
        topology = self._space.topology
        mass, stiffness = self._matrices(FIT_METRIC, control, spacing)
        system = mass.plus(FIT_TIME, stiffness)
        normals = unit_vectors(triangle_normals(surface, topology.triangles))
        for smooth in chain.from_iterable(
            smoothed_normals(normals, self._around, smoothing) for smoothing in family.smoothings
        ):
            load = self._space.turning_load(control, turns_between(normals, smooth))
            removed, report = conjugate_gradients(
                system,
                FIT_TIME * load,
                np.zeros_like(load),
                is_held=self._is_loose,
                tolerance=FIT_TOLERANCE,
                max_iterations=MAX_ITERATIONS,
            )
            self._on_solve(report)
            yield surface - self._limit @ removed

    @cached_property
    def _around(self) -> IntArray:
        return triangles_around(self._space.topology)

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
