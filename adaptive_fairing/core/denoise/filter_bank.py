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
from typing import NamedTuple

import numpy as np

from ..linalg.conjugate_gradients import SolveReport, conjugate_gradients
from ..linalg.edge_matrix import EdgeMatrix, EdgePattern
from ..linalg.krylov_filters import MAX_ITERATIONS, Diffusion, removed_by
from ..mesh.normals import triangle_normals, unit_vectors
from ..mesh.topology import TriangleTopology
from ..runtime.arrays import FloatArray, IndexArray, RealArray
from ..runtime.precision import SINGLE, Precision
from .lifted_metric import (
    LiftedMetric,
    area_elements,
    half_cotangents,
    linear_elements,
    rim_flux,
    squared_edges,
)
from .local_frame import spacing_of
from .normal_filter import Smoothing, smoothed_normals, triangles_around, turning_load

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

# Smoothing before the first metric of a surface can be taken, and the filters beside it.
FIRST = Diffusion(0.5, 2, 2)
MESH_FAMILY = FilterFamily(LiftedMetric(), STEEP)

# Of the filters' solves.  A filter need not be exactly that of its formula, because what it removes
# is measured.  At 0.01 the results are no better.
TOLERANCE = 0.05

# Time of the step that fits a surface to normals, in squared edge lengths, and the tolerance of its
# solve; the metric is that of the surface.
FIT_TIME, FIT_TOLERANCE = 4.0, 1e-2
FIT_METRIC = LiftedMetric(1)

# How much of the flux of the surface through its rims is not taken for bending.  With none rims are
# drawn inwards, with all of it their noise stays; found on an open mesh with slivers at its rims.
RIM_SHARE = 0.5

# A vertex counts for at most so many times, or parts, of the others around it.
LARGEST_WEIGHT = 8.0

# Passes of (3.6) over the edge length that serves as the unit in a metric.
SPACING_PASSES = 3


class FilterBank:
    """Filters for positions on one topology.

    Parameters
    ----------
    topology : TriangleTopology
    positions : (n, 3)
        Decide the weights of the vertices.
    on_solve : callable
        Called after each linear solve with its report.
    """

    def __init__(
        self,
        topology: TriangleTopology,
        positions: FloatArray,
        on_solve: Callable[[SolveReport], None],
    ) -> None:
        self.topology, self._on_solve = topology, on_solve
        self._pattern = EdgePattern(topology)
        self._is_loose = topology.is_loose
        is_large = topology.n_triangles >= SINGLE.least_triangles
        self._precision: Precision = np.float32 if is_large else np.float64
        around = spacing_of(topology, positions, SPACING_PASSES)
        ratio = around / spacing_of(topology, positions, 0)
        self._weights = np.clip(ratio, 1 / LARGEST_WEIGHT, LARGEST_WEIGHT)

    def started(self, positions: FloatArray) -> tuple[FloatArray, list[FloatArray]]:
        """Filter in the metric of the mesh alone, which needs no surface.

        Returns
        -------
        surface : (n, 3)
            Positions smoothed enough for a metric to be taken from them.
        filtered : list of (n, 3)
            The filters of `MESH_FAMILY`.
        """
        diffusions = FIRST, *MESH_FAMILY.diffusions
        n = self.topology.n_vertices
        # The metric does not see the surface: any will do.
        squares = MESH_FAMILY.metric.lengths(self._pattern, positions, np.ones(n))
        matrices = self._matrices(squares)
        first, *removed = self._removed(matrices, matrices[1].product(positions.T).T, diffusions)
        return positions - first, [positions - each for each in removed]

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
            The surface that the metrics are taken from.
        families : sequence of FilterFamily and NormalFamily

        Yields
        ------
        (n, 3)
            What the next filter makes of them, family by family.
        """
        spacing = spacing_of(self.topology, surface, SPACING_PASSES)
        for family in families:
            if isinstance(family, NormalFamily):
                yield from self._fitted(surface, spacing, family)
                continue
            metric, diffusions = family
            squares = metric.lengths(self._pattern, surface, spacing)
            matrices = self._matrices(squares)
            bending = matrices[1].product(positions.T).T
            bending -= RIM_SHARE * rim_flux(self._pattern, squares, surface)
            for removed in self._removed(matrices, bending, diffusions):
                yield positions - removed

    def _fitted(
        self, surface: FloatArray, spacing: FloatArray, family: NormalFamily
    ) -> Iterator[FloatArray]:
        """Fit a surface (n, 3) to its normals, smoothed.

        The step X - (M + t L)⁻¹ t b turns the tangents of every triangle as far as its normal was
        turned, with b = ∫ (∇x - R ∇x) · ∇φ.
        """
        mass, stiffness = self._matrices(FIT_METRIC.lengths(self._pattern, surface, spacing))
        normals = unit_vectors(triangle_normals(surface, self.topology.triangles))
        squares = squared_edges(self._pattern, surface)
        cotangents = half_cotangents(squares, area_elements(squares))
        loads = [
            FIT_TIME * turning_load(self._pattern, surface, cotangents, smooth)
            for smoothing in family.smoothings
            for smooth in smoothed_normals(normals, self._around, smoothing)
        ]
        # One system for all fits: they differ in the right sides alone.
        load = np.concatenate(loads, axis=1)
        removed, report = conjugate_gradients(
            mass.plus(FIT_TIME, stiffness).in_precision(self._precision),
            load,
            np.zeros_like(load),
            is_held=self._is_loose,
            tolerance=FIT_TOLERANCE,
            max_iterations=MAX_ITERATIONS,
        )
        self._on_solve(report)
        for each in np.split(removed, len(loads), axis=1):
            yield surface - each

    @cached_property
    def _around(self) -> IndexArray:
        return triangles_around(self.topology)

    def _matrices(self, squares: FloatArray) -> tuple[EdgeMatrix, EdgeMatrix]:
        mass, stiffness = linear_elements(self._pattern, squares)
        return mass.weighted(self._weights), stiffness

    def _removed(
        self,
        matrices: tuple[EdgeMatrix, EdgeMatrix],
        bending: FloatArray,
        diffusions: Sequence[Diffusion],
    ) -> list[RealArray]:
        return removed_by(
            diffusions,
            *matrices,
            bending,
            self._is_loose,
            self._on_solve,
            TOLERANCE,
            self._precision,
        )
