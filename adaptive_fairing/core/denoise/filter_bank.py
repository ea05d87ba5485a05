"""The filters of the automatic method: corrected diffusion in several metrics.

One step of semi-implicit diffusion is S = (M + t L)⁻¹ M.  It also shrinks long waves, which it
should keep.  The corrected step 1 - (1 - S)ᵖ has p times the order of accuracy at long waves and
still damps the short ones.  Several such steps make one filter, which is the steeper the larger p.

Where creases stand close together, no diffusion has room between them.  There another filter fits
the surface to smoothed normals of its triangles, again by a semi-implicit step.

Where noise grows with the edges, a vertex with shorter edges than its neighbours has less noise
than they have.  It gets a larger weight in M.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from ..linalg.conjugate_gradients import SolveReport, conjugate_gradients
from ..linalg.edge_matrix import EdgeMatrix, EdgePattern
from ..linalg.krylov_filters import MAX_ITERATIONS, Diffusion, removed_by
from ..mesh.topology import TriangleTopology
from ..runtime.arrays import FloatArray, RealArray
from ..runtime.precision import SINGLE, Precision
from .filter_family import Filter, FlatFamily, NormalFamily
from .filter_rounds import Round, mesh_family
from .flat_faces import FlatFaces, flattened
from .lifted_metric import LiftedMetric, linear_elements, rim_flux
from .local_frame import spacing_of
from .noise.correlation import WHITE, NoiseCorrelation
from .normal_filter import TurningLoads, smoothed_normals, triangles_around
from .parameters import parameters

# The fit to normals is a step in the metric of the surface.
FIT_METRIC = LiftedMetric(1)


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
        tuned = parameters()
        self.topology, self._on_solve = topology, on_solve
        self._pattern = EdgePattern(topology)
        self._around = triangles_around(topology)
        self._is_loose = topology.is_loose
        is_large = topology.n_triangles >= SINGLE.least_triangles
        self._precision: Precision = np.float32 if is_large else np.float64
        around = spacing_of(topology, positions, tuned.spacing_passes)
        ratio = around / spacing_of(topology, positions, 0)
        self._weights = np.clip(ratio, 1 / tuned.largest_weight, tuned.largest_weight)

    def started(self, positions: FloatArray) -> tuple[FloatArray, dict[Filter, FloatArray]]:
        """Filter in the metric of the mesh alone, which needs no surface.

        Returns
        -------
        surface : (n, 3)
            Positions smoothed enough for a metric to be taken from them.
        filtered : dict of Filter to (n, 3)
            What those of `mesh_family` make of the positions.
        """
        tuned, family = parameters(), mesh_family()
        first_diffusion = Diffusion(tuned.first_time, tuned.first_order, tuned.first_steps)
        diffusions = first_diffusion, *family.diffusions
        n = self.topology.n_vertices
        # This metric does not depend on the positions and the unit of length.
        squares = family.metric.lengths(self._pattern, positions, np.ones(n))
        matrices = self._matrices(squares)
        first, *removed = self._removed(matrices, matrices[1].product(positions.T).T, diffusions)
        filtered = dict(zip(family.filters, (positions - each for each in removed), strict=True))
        return positions - first, filtered

    def filtered(
        self,
        positions: FloatArray,
        surface: FloatArray,
        families: Round,
    ) -> Iterator[tuple[Filter, FloatArray]]:
        """Filter positions in the metrics of a surface, or either of them by its normals.

        Parameters
        ----------
        positions : (n, 3)
        surface : (n, 3)
            The surface that the metrics are taken from.
        families : sequence of FilterFamily, NormalFamily and FlatFamily

        Yields
        ------
        Filter, (n, 3)
            The next filter and what it makes of them, family by family.
        """
        tuned = parameters()
        spacing = spacing_of(self.topology, surface, tuned.spacing_passes)
        for family in families:
            if isinstance(family, FlatFamily):
                flat = self.flattened(positions, surface, tuned.least_flat, family.correlation)
                # Not the positions: another frame's plan may rely on this filter.
                yield family.filters[0], surface if flat is None else flat
                continue
            if isinstance(family, NormalFamily):
                start = positions if family.is_of_noisy else surface
                fits = self._fitted(start, spacing, family)
                yield from zip(family.filters, fits, strict=True)
                continue
            squares = family.metric.lengths(self._pattern, surface, spacing)
            matrices = self._matrices(squares)
            bending = matrices[1].product(positions.T).T
            bending -= tuned.rim_fraction * rim_flux(self._pattern, squares, surface)
            all_removed = self._removed(matrices, bending, family.diffusions)
            for each, removed in zip(family.filters, all_removed, strict=True):
                yield each, positions - removed

    def flattened(
        self,
        positions: FloatArray,
        surface: FloatArray,
        least: float,
        correlation: NoiseCorrelation = WHITE,
    ) -> FloatArray | None:
        """Make the flat faces of a surface flat, in planes fitted to positions, (n, 3) all.

        None if less than the fraction `least` of the triangles is on flat faces.
        """
        spacing = spacing_of(self.topology, surface, parameters().spacing_passes)
        return flattened(
            self.topology, self._around, positions, surface, spacing, least, correlation
        )

    def flat_faces(
        self, positions: FloatArray, surface: FloatArray, correlation: NoiseCorrelation
    ) -> FlatFaces:
        """Find the flat faces of a surface with smooth noise, and their planes."""
        spacing = spacing_of(self.topology, surface, parameters().spacing_passes)
        return FlatFaces(self.topology, self._around, positions, surface, spacing, correlation)

    def _fitted(
        self, surface: FloatArray, spacing: FloatArray, family: NormalFamily
    ) -> Iterator[FloatArray]:
        """Fit a surface (n, 3) to its normals, smoothed.

        The step X - (M + t L)⁻¹ t b turns the tangents of every triangle as far as its normal was
        turned, with b = ∫ (∇x - R ∇x) · ∇φ.
        """
        tuned = parameters()
        mass, stiffness = self._matrices(FIT_METRIC.lengths(self._pattern, surface, spacing))
        turning = TurningLoads(self._pattern, surface)
        loads = (
            tuned.fit_time * turning.of(smooth)
            for smoothing in family.smoothings
            for smooth in smoothed_normals(turning.normals, self._around, smoothing)
        )
        # One system for all fits: they differ in the right sides alone.
        load = np.concatenate([each.astype(self._precision) for each in loads], axis=1)
        removed, report = conjugate_gradients(
            mass.plus(tuned.fit_time, stiffness).in_precision(self._precision),
            load,
            np.zeros_like(load),
            is_held=self._is_loose,
            tolerance=tuned.fit_tolerance,
            max_iterations=MAX_ITERATIONS,
        )
        self._on_solve(report)
        for each in np.split(removed, len(family.filters), axis=1):
            yield surface - each

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
            parameters().filter_tolerance,
            self._precision,
        )
