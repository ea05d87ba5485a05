"""Filter bank of the automatic method: corrected diffusions in several metrics.

One step of semi-implicit diffusion is S = (M + t L)⁻¹ M.  It also shrinks long waves, which it
should keep.  The corrected step 1 - (1 - S)ᵖ has p times the order of accuracy at long waves and
still damps the short ones.  Several such steps make one filter; it is steeper with a larger p.

Where creases are close together, no diffusion has room between them.  There another filter fits the
surface to smoothed normals of its triangles, again by a semi-implicit step.

Where noise grows with the edges, a vertex with shorter edges than its neighbours has less noise
than they have.  It gets a larger weight in M.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence

import numpy as np

from ..linalg.conjugate_gradients import SolveReport, conjugate_gradients
from ..linalg.edge_matrix import EdgeMatrix, EdgePattern
from ..linalg.krylov_filters import MAX_ITERATIONS, Diffusion, removed_by
from ..runtime.arrays import FloatArray, RealArray
from ..runtime.precision import SINGLE, Precision
from .filter_rounds import Filter, FlatFamily, NormalFamily, Round, mesh_family
from .flat_faces import FlatFaces, flattened
from .lifted_metric import LiftedMetric, boundary_flux, linear_elements
from .noise_model import NoiseCorrelation
from .normal_filter import (
    TurningLoads,
    smoothed_normals,
    triangles_around,
    weights_of_normals,
)
from .parameters import parameters
from .triangle_surface import TriangleSurface

# The fit to normals is a step in the metric of the surface.
FIT_METRIC = LiftedMetric(1)


class FilterBank:
    """Filters for surfaces of one topology.

    Parameters
    ----------
    start : TriangleSurface
        Decides the weights of the vertices.
    on_solve : callable
        Called after each linear solve with its report.
    """

    def __init__(self, start: TriangleSurface, on_solve: Callable[[SolveReport], None]) -> None:
        topology, self._on_solve = start.topology, on_solve
        self._pattern = EdgePattern(topology)
        self._around = triangles_around(topology)
        self._is_loose = topology.is_loose
        is_large = topology.n_triangles >= SINGLE.least_triangles
        self._precision: Precision = np.float32 if is_large else np.float64
        ratio, largest = start.smooth_spacing / start.spacing, parameters().largest_weight
        self._weights = np.clip(ratio, 1 / largest, largest)
        self._noise: FloatArray | None = None
        self._normal_weights: FloatArray | None = None

    def know_noise(self, noise: FloatArray) -> None:
        """Give normals less weight where the noise, (n,) in local edge lengths, is stronger."""
        self._noise = noise
        self._normal_weights = weights_of_normals(self._pattern.topology, noise)

    def started(self, noisy: TriangleSurface) -> tuple[TriangleSurface, dict[Filter, FloatArray]]:
        """Filter in the metric of the mesh alone, which needs no smooth surface.

        Returns
        -------
        surface : TriangleSurface
            Surface that is smooth enough to take a metric from it.
        filtered : dict of Filter to (n, 3)
            Positions after each filter of `mesh_family`.
        """
        tuned, family = parameters(), mesh_family()
        first_diffusion = Diffusion(tuned.first_time, tuned.first_order, tuned.first_steps)
        diffusions = first_diffusion, *family.diffusions
        results = self._diffused(noisy, noisy, family.metric, diffusions)
        surface = TriangleSurface(noisy.topology, next(results))
        return surface, dict(zip(family.filters, results, strict=True))

    def filtered(
        self, noisy: TriangleSurface, surface: TriangleSurface, families: Round
    ) -> Iterator[tuple[Filter, FloatArray]]:
        """Filter a surface in the metrics of a smoother one, or by the normals of either.

        Parameters
        ----------
        noisy : TriangleSurface
        surface : TriangleSurface
            The same surface, smoothed; the metrics are taken from it.
        families : sequence of FilterFamily, NormalFamily and FlatFamily

        Yields
        ------
        Filter, (n, 3)
            Next filter, and the positions after it, family by family.
        """
        for family in families:
            results: Iterable[FloatArray]
            if isinstance(family, FlatFamily):
                flat = self.flattened(noisy, surface, family.correlation)
                # Not the noisy positions: another frame's plan may rely on this filter.
                results = (surface.positions if flat is None else flat,)
            elif isinstance(family, NormalFamily):
                results = self._fitted(noisy if family.is_of_noisy else surface, surface, family)
            else:
                flux_fraction = parameters().boundary_flux_fraction
                results = self._diffused(
                    noisy, surface, family.metric, family.diffusions, flux_fraction
                )
            yield from zip(family.filters, results, strict=True)

    def flattened(
        self,
        noisy: TriangleSurface,
        surface: TriangleSurface,
        correlation: NoiseCorrelation,
    ) -> FloatArray | None:
        """Flatten the flat faces of a surface into planes fitted to the noisy surface, (n, 3).

        None if the surface counts as round.
        """
        return flattened(surface, noisy.positions, self._around, self._noise, correlation)

    def flat_faces(
        self, noisy: TriangleSurface, surface: TriangleSurface, correlation: NoiseCorrelation
    ) -> FlatFaces:
        """Find the flat faces of a surface, and their planes, in spite of smooth noise."""
        return FlatFaces(surface, noisy.positions, self._around, self._noise, correlation)

    def _fitted(
        self, surface: TriangleSurface, smooth: TriangleSurface, family: NormalFamily
    ) -> Iterator[FloatArray]:
        """Fit a surface to its smoothed normals, with the local edge length of a smoother surface.

        The step X - (M + t L)⁻¹ t b, with b = ∫ (∇x - R ∇x) · ∇φ, turns the tangents of every
        triangle as far as its normal was turned.
        """
        # One system for all fits: they differ in the right sides alone.  Both are made apart and
        # have no names here, so that all is free that the solve does not need.
        removed, report = conjugate_gradients(
            self._fit_system(surface, smooth),
            self._fit_loads(surface, family).T,
            is_held=self._is_loose,
            tolerance=parameters().fit_tolerance,
            max_iterations=MAX_ITERATIONS,
        )
        self._on_solve(report)
        for each in np.split(removed, len(family.filters), axis=1):
            yield surface.positions - each

    def _fit_system(self, surface: TriangleSurface, smooth: TriangleSurface) -> EdgeMatrix:
        mass, stiffness = self._matrices(FIT_METRIC.lengths(surface, smooth))
        return mass.plus(parameters().fit_time, stiffness).in_precision(self._precision)

    def _fit_loads(self, surface: TriangleSurface, family: NormalFamily) -> RealArray:
        """Right sides of all fits of a family, three rows each."""
        tuned, turning = parameters(), TurningLoads(surface)
        loads = np.empty((3 * len(family.filters), surface.topology.n_vertices), self._precision)
        fits = (
            each
            for smoothing in family.smoothings
            for each in smoothed_normals(
                turning.normals, self._around, smoothing, self._normal_weights
            )
        )
        for own, normals in zip(np.split(loads, len(family.filters)), fits, strict=True):
            own[:] = tuned.fit_time * turning.of(normals).T
        return loads

    def _diffused(
        self,
        noisy: TriangleSurface,
        surface: TriangleSurface,
        metric: LiftedMetric,
        diffusions: Sequence[Diffusion],
        flux_fraction: float = 0.0,
    ) -> Iterator[FloatArray]:
        """Diffuse the noisy positions in a metric of a surface.

        A fraction of the pull that exists only because the surface has a boundary is left out.
        """
        squares = metric.lengths(surface)
        mass, stiffness = self._matrices(squares)
        bending = stiffness.product(noisy.positions.T).T
        if flux_fraction:
            bending -= flux_fraction * boundary_flux(surface, squares)
        del squares  # among the largest arrays
        mass, stiffness = (each.in_precision(self._precision) for each in (mass, stiffness))
        removed = removed_by(
            diffusions,
            mass,
            stiffness,
            bending,
            self._is_loose,
            self._on_solve,
            parameters().filter_tolerance,
            self._precision,
        )
        for each in removed:
            yield noisy.positions - each

    def _matrices(self, squares: FloatArray) -> tuple[EdgeMatrix, EdgeMatrix]:
        mass, stiffness = linear_elements(self._pattern, squares)
        return mass.weighted(self._weights), stiffness
