"""Filters of the automatic method, in families and rounds.

One step of semi-implicit diffusion is S = (M + t L)⁻¹ M.  It also shrinks long waves, which it
should keep.  The corrected step 1 - (1 - S)ᵖ has p times the order of accuracy at long waves and
still damps the short ones.  Several such steps make one filter; it is steeper with a larger p.

Where creases are close together, no diffusion has room between them.  There another filter fits the
surface to smoothed normals of its triangles, again by a semi-implicit step.

Where noise grows with the edges, a vertex with shorter edges than its neighbours has less noise
than they have.  It gets a larger weight in M.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple, Self

import numpy as np

from ..linalg.conjugate_gradients import SolveReport, conjugate_gradients
from ..linalg.edge_matrix import EdgeMatrix, EdgePattern
from ..linalg.krylov_filters import MAX_ITERATIONS, Diffusion, removed_by
from ..runtime.arrays import FloatArray, RealArray
from ..runtime.precision import SINGLE, Precision
from ..runtime.threads import ordered_map
from .flat_faces import FlatFaces
from .lifted_metric import LiftedMetric, boundary_flux, linear_elements
from .noise_model import WHITE, NoiseCorrelation
from .normal_filter import (
    Smoothing,
    TurningLoads,
    smoothed_normals,
    triangles_around,
    weights_of_normals,
)
from .parameters import parameters
from .triangle_surface import TriangleSurface

# Behaviour of a filter at creases. Filters that see creases keep those that stand out of the noise.
KEEPS, SEES, IGNORES = "keeps", "sees", "ignores"

# Relative residual of the solves. A filter need not follow its formula exactly, because its effect
# is measured. With 0.03 errors on 19 shapes were the same, at 1.06 times the time; with 0.05 those
# of staircases were 1.3 % larger.
TOLERANCE = 0.04

# Factors with which more sets of flat faces are merged.  Jitter of 0.0001 of an edge changed
# thirteen meshes with noise of 0.2 by up to 1.8 % of what is removed, and with heavy tails by up to
# 3.3 %; with one set 3.1 and 5.5 %.  Two sets more gave less still, but took 1.2 times as long.
OTHER_FACTORS = 0.85, 1.15

# The fit to normals is a step in the metric of the surface.
FIT_METRIC = LiftedMetric(1)


class Filter(NamedTuple):
    """One filter of the bank.

    Attributes
    ----------
    name : str
        Unique name among the filters of a run.
    creases : str
        `KEEPS`, `SEES` or `IGNORES`.
    """

    name: str
    creases: str

    def serves(self, features: str) -> bool:
        """Whether the setting "auto", "sharp" or "smooth" allows this filter."""
        return features == "auto" or self.creases == {"sharp": KEEPS, "smooth": IGNORES}[features]


class FilterFamily(NamedTuple):
    """Several diffusions in one metric.

    Attributes
    ----------
    name : str
    creases : str
        As in `Filter`.
    metric : LiftedMetric
    diffusions : tuple of Diffusion
    """

    name: str
    creases: str
    metric: LiftedMetric
    diffusions: tuple[Diffusion, ...]

    @property
    def filters(self) -> tuple[Filter, ...]:
        """The filters, in the order of the diffusions."""
        return tuple(
            Filter(f"{self.name}: time {each.time:g}, order {each.order}", self.creases)
            for each in self.diffusions
        )

    def filtered(
        self, bank: FilterBank, noisy: TriangleSurface, surface: TriangleSurface
    ) -> Iterator[FloatArray]:
        """Filter noisy positions in the metric of a smoother surface, (n, 3) each."""
        fraction = parameters().boundary_flux_fraction
        return bank.diffused(noisy, surface, self.metric, self.diffusions, fraction)


class FlatFamily(NamedTuple):
    """The mixture of the earlier rounds with its flat faces flattened, see `flat_faces`.

    Attributes
    ----------
    name : str
    correlation : NoiseCorrelation
        Correlation of smooth noise in which faces are to be found; no correlation otherwise.
    faces : tuple of FlatFaces, optional
        Faces that were found already, on a surface much like the one to flatten.
    """

    name: str
    correlation: NoiseCorrelation = WHITE
    faces: tuple[FlatFaces, ...] = ()

    @property
    def filters(self) -> tuple[Filter, ...]:
        """The only filter."""
        return (Filter(self.name, KEEPS),)

    def found(self, bank: FilterBank, noisy: TriangleSurface, surface: TriangleSurface) -> Self:
        """Return the family with the faces of a surface."""
        return self._replace(faces=bank.sets_of_faces(noisy, surface, self.correlation))

    def filtered(
        self, bank: FilterBank, noisy: TriangleSurface, surface: TriangleSurface
    ) -> Iterator[FloatArray]:
        """Flatten the faces of a surface into planes fitted to the noisy positions, (n, 3)."""
        sets = self.faces or bank.sets_of_faces(noisy, surface, self.correlation)
        start = surface.positions
        yield start + np.mean([e.flattened(noisy.positions, start) - start for e in sets], axis=0)


class NormalFamily(NamedTuple):
    """Fits to the normals of triangles, smoothed in several ways but not across creases.

    Attributes
    ----------
    name : str
    smoothings : tuple of Smoothing
    is_of_noisy : bool
        Whether the normals are those of the noisy mesh, instead of the mixture of the earlier
        rounds.
    """

    name: str
    smoothings: tuple[Smoothing, ...]
    is_of_noisy: bool = False

    @property
    def filters(self) -> tuple[Filter, ...]:
        """The filters, in the order of the smoothings and their passes."""
        return tuple(
            Filter(f"{self.name} within {math.degrees(each.angle):g}°: {passes} passes", KEEPS)
            for each in self.smoothings
            for passes in each.passes
        )

    def filtered(
        self, bank: FilterBank, noisy: TriangleSurface, surface: TriangleSurface
    ) -> Iterator[FloatArray]:
        """Fit one of two surfaces to its smoothed normals, (n, 3) each."""
        return bank.fitted(noisy if self.is_of_noisy else surface, surface, self.smoothings)


Round = tuple[FilterFamily | NormalFamily | FlatFamily, ...]


def gentle_diffusions() -> tuple[Diffusion, ...]:
    """Return the diffusions of low order, which suffice near creases."""
    tuned = parameters()
    return tuple(
        Diffusion(time, tuned.gentle_order, tuned.diffusion_steps) for time in tuned.gentle_times
    )


def all_diffusions() -> tuple[Diffusion, ...]:
    """Return the gentle diffusions and those of high order, for smooth shapes."""
    tuned = parameters()
    steep = (
        Diffusion(time, tuned.steep_order, tuned.diffusion_steps) for time in tuned.steep_times
    )
    return *gentle_diffusions(), *steep


def mesh_family() -> FilterFamily:
    """Return the filters in the metric of the mesh alone."""
    return FilterFamily("mesh", IGNORES, LiftedMetric(), all_diffusions())


def rounds_for(typical: float, correlation: NoiseCorrelation = WHITE) -> tuple[Round, ...]:
    """Choose the filters of all rounds besides those of the mesh.

    The metrics and normals of a round are those of the mixture of the earlier rounds, at first
    those of the slightly smoothed surface.

    Parameters
    ----------
    typical : float
        Typical size of the noise in local edge lengths, above 0.  The angles of the metrics are
        scaled to it.  Noise that turns triangles over leaves no information in their normals, so
        filters by normals of the noisy mesh are then left out.
    correlation : NoiseCorrelation
        Correlation of smooth noise in which flat faces are to be found.
    """
    tuned = parameters()
    factor = min(typical / tuned.coarse_noise, 1.0)
    wide, narrow = factor * tuned.wide_angle, factor * tuned.narrow_angle
    short = Smoothing(tuned.short_fit_angle, tuned.fit_passes)
    long = Smoothing(tuned.long_fit_angle, tuned.fit_passes[-1:])
    of_noisy = NormalFamily("noisy normals", (long,), is_of_noisy=True)
    every, gentle = all_diffusions(), gentle_diffusions()
    return (
        (FilterFamily("surface", IGNORES, LiftedMetric(1), every),),
        (FilterFamily("mesh, wide angle", SEES, LiftedMetric(0, wide), every),),
        (
            FilterFamily("mesh, narrow angle", KEEPS, LiftedMetric(0, narrow), gentle),
            *((of_noisy,) if typical <= tuned.coarse_noise else ()),
        ),
        (NormalFamily("normals", (short, long)),),
        (FlatFamily("flat faces", correlation),),
    )


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
        self._weights = start.smooth_spacing / start.spacing
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
            After the first of the steep filters: smooth enough to take a metric from it.
        filtered : dict of Filter to (n, 3)
            Positions after each filter of `mesh_family`.
        """
        family = mesh_family()
        results = list(self.diffused(noisy, noisy, family.metric, family.diffusions))
        surface = TriangleSurface(noisy.topology, results[len(gentle_diffusions())])
        return surface, dict(zip(family.filters, results, strict=True))

    def filtered(
        self, noisy: TriangleSurface, surface: TriangleSurface, families: Round
    ) -> Iterator[tuple[Filter, FloatArray]]:
        """Filter a surface in the metrics of a smoother one, or by the normals of either.

        Yields the next filter and the positions (n, 3) after it, family by family.
        """
        for family in families:
            yield from zip(family.filters, family.filtered(self, noisy, surface), strict=True)

    def flat_faces(
        self, noisy: TriangleSurface, surface: TriangleSurface, correlation: NoiseCorrelation
    ) -> FlatFaces:
        """Find the flat faces of a surface, and their planes, in spite of smooth noise."""
        return FlatFaces(surface, noisy.positions, self._noise, correlation)

    def sets_of_faces(
        self, noisy: TriangleSurface, surface: TriangleSurface, correlation: NoiseCorrelation
    ) -> tuple[FlatFaces, ...]:
        """Find the flat faces of a surface three times, in orders that differ; once if it is large.

        One triangle may join two faces, or lead a face around a bend.  Then it decides for one set.
        """
        found = self.flat_faces(noisy, surface, correlation)
        is_large = surface.topology.n_vertices >= parameters().least_probed
        return found, *(() if is_large else ordered_map(found.again, OTHER_FACTORS))

    def fitted(
        self, surface: TriangleSurface, smooth: TriangleSurface, smoothings: Sequence[Smoothing]
    ) -> Iterator[FloatArray]:
        """Fit a surface to its smoothed normals, with the local edge length of a smoother surface.

        The step X - (M + t L)⁻¹ t b, with b = ∫ (∇x - R ∇x) · ∇φ, turns the tangents of every
        triangle as far as its normal was turned.
        """
        # One system for all fits: they differ in the right sides alone.  Both are made apart and
        # have no names here, so that all is free that the solve does not need.
        n_fits = sum(len(each.passes) for each in smoothings)
        removed, report = conjugate_gradients(
            self._fit_system(surface, smooth),
            self._fit_loads(surface, smoothings, n_fits).T,
            is_held=self._is_loose,
            tolerance=TOLERANCE,
            max_iterations=MAX_ITERATIONS,
        )
        self._on_solve(report)
        for each in np.split(removed, n_fits, axis=1):
            yield surface.positions - each

    def _fit_system(self, surface: TriangleSurface, smooth: TriangleSurface) -> EdgeMatrix:
        mass, stiffness = self._matrices(FIT_METRIC.lengths(surface, smooth))
        return mass.plus(parameters().gentle_times[-1], stiffness).in_precision(self._precision)

    def _fit_loads(
        self, surface: TriangleSurface, smoothings: Sequence[Smoothing], n_fits: int
    ) -> RealArray:
        """Right sides of all fits, three rows each."""
        time, turning = parameters().gentle_times[-1], TurningLoads(surface)
        loads = np.empty((3 * n_fits, surface.topology.n_vertices), self._precision)
        fits = (
            each
            for smoothing in smoothings
            for each in smoothed_normals(
                turning.normals, self._around, smoothing, self._normal_weights
            )
        )
        for own, normals in zip(np.split(loads, n_fits), fits, strict=True):
            own[:] = time * turning.of(normals).T
        return loads

    def diffused(
        self,
        noisy: TriangleSurface,
        surface: TriangleSurface,
        metric: LiftedMetric,
        diffusions: Sequence[Diffusion],
        flux_fraction: float = 0.0,
    ) -> Iterator[FloatArray]:
        """Diffuse the noisy positions in a metric of a surface, (n, 3) each.

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
            TOLERANCE,
            self._precision,
        )
        for each in removed:
            yield noisy.positions - each

    def _matrices(self, squares: FloatArray) -> tuple[EdgeMatrix, EdgeMatrix]:
        mass, stiffness = linear_elements(self._pattern, squares)
        return mass.weighted(self._weights), stiffness
