"""Mixing of filters for the least risk, in rounds: the automatic method as a whole.

1.  Judge the noise: its kind, and its level by connected part and density (`noise_verdict`).
2.  Filter in the metrics of the slightly smoothed surface (`filters`).  Mix the filters so that
    the estimated distance to the surface without noise is least (`mixture`).
3.  Filter in the metrics of that mixture, which shows the creases, and mix all filters so far.
    Repeat this in a metric of a smaller angle, by fits to smoothed normals, and last on flat faces.

How much of the noise a filter removes is measured by filtering again with a little noise added, the
probe.  A formula for linear filters would be wrong, because the metrics depend on the noise too.
Few vertices measure little, so small meshes are filtered with several probes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import compress, repeat
from threading import Lock
from typing import NamedTuple

import numpy as np

from ..linalg.conjugate_gradients import SolveReport
from ..mesh.topology import TriangleTopology
from ..runtime.arrays import BoolArray, FloatArray, RealArray
from ..runtime.threads import for_each, ordered_map
from .bounds import Bounds, Sliding, unfolded
from .filters import Filter, Round, rounds_for
from .mixture import Mixture, filter_divergence
from .noise_model import NoiseCorrelation
from .noise_verdict import NoiseVerdict, noise_verdict
from .parameters import parameters
from .plan import STRENGTHS, DenoisePlan
from .progress import ProgressReport
from .settings import DenoiseSettings
from .stage import Stage, Track
from .triangle_surface import TriangleSurface

# Vertices of a mesh up to which all runs filter at once, each with one thread.  Most of their
# work is passes of numpy over all vertices, which no threads share.  Measured on 2 cores, relative
# to one after the other: 0.64 to 0.98 of the time, and 1.2 to 1.34 of the memory on large meshes.
MOST_SIDE_BY_SIDE = 1_000_000

LIKE_DETAIL = (
    "some of what was removed lies side by side, as detail does and noise hardly does: if it is "
    'detail, the setting "Keep Fine Detail" (clean "detail") keeps it'
)
IN_DOUBT = (
    "the edges follow some of the roughness, as in decimated models: only a part of it was "
    'removed; the setting "Keep Fine Detail" (clean "detail") keeps all of it, "Denoise Anyway" '
    '(clean "denoise") keeps none'
)
UNLIKE_NOISE = (
    "what would have been removed is not like noise, but like corners and creases: nothing was "
    "changed"
)


@dataclass(frozen=True)
class MixedSurfaces:
    """Surfaces for all strengths, ascending.

    Attributes
    ----------
    positions : list of (n, 3)
    plan : DenoisePlan
    solve : SolveReport
        Iterations of all solves together, and the worst of their residuals.
    notes : tuple of str
        Reason why nothing was done, if so.
    other_readings : tuple of str
        See `DenoiseResult`.
    """

    positions: list[FloatArray]
    plan: DenoisePlan
    solve: SolveReport
    notes: tuple[str, ...]
    other_readings: tuple[str, ...]


def mixed_surfaces(
    topology: TriangleTopology,
    positions: FloatArray,
    is_still: BoolArray,
    settings: DenoiseSettings,
    *,
    width: float | None = None,
    plan: DenoisePlan | None = None,
    progress: ProgressReport,
) -> MixedSurfaces:
    """Denoise positions on the solver's mesh, for all of `STRENGTHS`.

    Parameters
    ----------
    topology : TriangleTopology
    positions : (n, 3)
    is_still : (n,) bool
        Vertices from which noise and risk are not judged, besides those of the boundary.
    settings : DenoiseSettings
    width : float, optional
        Width of the noise in edges of this mesh, if it was given.
    plan : DenoisePlan, optional
        Plan of another frame of this surface; then nothing is estimated.
    progress : ProgressReport
    """
    solves = _Solves(progress)
    progress.begin("noise")
    stage = Stage(topology, positions, is_still, solves.count)
    before = stage.track.start
    notes: tuple[str, ...] = ()
    other_readings: tuple[str, ...] = ()
    sliding: Sliding | None = None
    if plan is None:
        verdict = noise_verdict(stage, settings.clean, width)
        stage, level, impulsive = verdict.stage, verdict.level, verdict.impulsive
        notes, other_readings = verdict.notes, verdict.other_readings
        plan = DenoisePlan.idle(level, impulsive, verdict.reach)
        if level.any():
            planned = _of_likely_reading(before, verdict, settings, progress)
            plan, sliding = planned.plan, planned.sliding
            if plan.is_idle:
                notes, other_readings = (UNLIKE_NOISE,), ("denoise",)
            elif (planned.certainty % 1).any():
                notes, other_readings = (*notes, IN_DOUBT), ("detail", "denoise")
            elif planned.clusters:
                notes, other_readings = (*notes, LIKE_DETAIL), ("detail",)
    else:
        impulsive = plan.impulsive
        if impulsive.any():
            stage = stage.calmed(impulsive)
        if not plan.is_idle:
            stage.track.repeat(plan, progress)
    start = stage.track.start
    # What does not look like noise stays, spikes too.
    stays = impulsive & ~plan.impulsive
    was_spike = (stage.spikes > 0) & ~stays
    numbers = range(len(STRENGTHS))

    def without_folds(faired: FloatArray) -> FloatArray:
        kept = np.where(stays[:, None], positions, faired)
        return unfolded(kept, before, was_spike, stage.parts.is_counted)

    if plan.is_idle:
        results = [without_folds(start.positions)] * len(STRENGTHS)
    else:
        progress.begin("mix")
        limits = sliding or _sliding(stage, plan.noise, plan.correlation, settings)

        def at_strength(number: int) -> FloatArray:
            mixed = stage.track.mixed(plan.mixtures[number])
            return without_folds(limits.limited(mixed, STRENGTHS[number] * settings.strength))

        results = list(ordered_map(at_strength, numbers))
    bounds = Bounds(before, stage.frame, stage.parts.is_counted, start.positions, plan.reach)

    def bounded(number: int) -> FloatArray:
        return bounds.kept(results[number], STRENGTHS[number] * settings.strength)

    results = list(ordered_map(bounded, numbers))
    return MixedSurfaces(results, plan, solves.report(), notes, other_readings)


class _Planned(NamedTuple):
    """A plan, and what it would remove from the surface before, spikes included.

    Attributes
    ----------
    plan : DenoisePlan
    sliding : Sliding
    certainty : (p,)
        How certainly that is noise in each part, 0 to 1.
    clusters : bool
        Whether some of it lies in clusters, as detail does.
    """

    plan: DenoisePlan
    sliding: Sliding
    certainty: FloatArray
    clusters: bool


def _of_likely_reading(
    before: TriangleSurface,
    verdict: NoiseVerdict,
    settings: DenoiseSettings,
    progress: ProgressReport,
) -> _Planned:
    """Plan for the first reading of a verdict that removes what looks like noise, or the last."""
    stage, (first, *others) = verdict.stage, verdict.readings()
    planned = _planned(before, first, settings, progress)
    for reading in others:
        if planned.certainty.all():
            break
        stage.track = Track(stage.bank, stage.track.start)
        planned = _planned(before, reading, settings, progress)
    return planned


def _sliding(
    stage: Stage, noise: FloatArray, correlation: NoiseCorrelation, settings: DenoiseSettings
) -> Sliding:
    is_free = settings.boundary == "free"
    return Sliding(stage.track.start, stage.frame, noise, correlation if is_free else None)


def _planned(
    before: TriangleSurface,
    verdict: NoiseVerdict,
    settings: DenoiseSettings,
    progress: ProgressReport,
) -> _Planned:
    """Filter in all rounds, and choose the coefficients of the filters after each."""
    tuned, stage, correlation = parameters(), verdict.stage, verdict.correlation
    noise = verdict.whole(verdict.level)
    sliding = _sliding(stage, noise, correlation, settings)
    track, frame, parts = stage.track, stage.frame, stage.parts
    seen = verdict.level
    typical = float(np.median(noise[noise > 0]))
    stage.bank.know_noise(noise)
    # The divergence weighted with the correlation of the noise comes from probes that have it too.
    size, n_counted = tuned.probe_size * typical, np.count_nonzero(parts.is_counted)
    own_probes = stage.noisy.own.probes(math.ceil(tuned.least_probed / n_counted))
    probes = [size * correlation.applied(each, frame) for each in own_probes]
    probed = (track.start.positions + frame.raised(each) for each in probes)
    shadows = [Track(stage.bank, TriangleSurface(frame.topology, each)) for each in probed]
    tracks = track, *shadows

    # The risk is in local edge lengths, but not in less than the noise: else a few vertices of tiny
    # edges, with noise of many, would decide for all.
    unit = np.maximum(noise, 1)
    # In single precision, like the arrays that they are measured from.
    removed: list[RealArray] = []
    divergence: list[RealArray] = []

    def measure() -> None:
        """Measure the removed part of each new filter along the normals, and its divergence."""

        def measured(each: Filter) -> tuple[RealArray, RealArray]:
            own, *others = (one.removed(each, frame) for one in tracks)
            gains = map(filter_divergence, repeat(own), others, probes, repeat(size))
            gain = np.mean(list(gains), axis=0)
            return (own / unit).astype(np.float32), gain.astype(np.float32)

        for taken, gain in ordered_map(measured, list(track.taken)[len(removed) :]):
            removed.append(taken)
            divergence.append(gain)

    def variance(factor: float) -> FloatArray:
        return np.square(factor * tuned.noise_factor * seen / correlation.seen / unit)

    # The pilots are for the noise as it is, so that runs of all strengths mix the same filters.
    first, *others = rounds_for(typical, correlation)
    pilots: list[Mixture] = []
    progress.begin("filter", 1)
    _filter_all(tracks, first)
    for number, families in enumerate(others, start=2):
        progress.begin("filter", number)
        measure()
        pilots += parts.best_mixtures(removed, divergence, variance(1)[None])
        _filter_all(tracks, families, pilots[-1])
    progress.begin("mix")
    measure()
    for shadow in shadows:
        shadow.taken.clear()  # large, and not needed any more
    filters = tuple(track.taken)
    usable = [each.serves(settings.features) for each in filters]
    rows = list(compress(removed, usable)), list(compress(divergence, usable))
    # First the noise as it is, whatever strength was asked for: it decides what looks like noise.
    factors = 1, *(settings.strength * each for each in STRENGTHS)
    variances = np.stack([variance(factor) for factor in factors])
    as_it_is, *mixtures = parts.best_mixtures(*rows, variances)
    mixtures = [each.spread(usable) for each in mixtures]
    # Smooth noise had to look like noise in every band before it was told; or the user has told it.
    is_told = settings.clean == "denoise" or settings.width != "auto" or correlation.passes
    impulsive, certainty, clusters = verdict.impulsive, np.ones(len(parts.counts())), False
    if not is_told:
        mixed = track.mixed(as_it_is.spread(usable))
        after = TriangleSurface(before.topology, sliding.limited(mixed))
        certainty, clusters = _certainty(before, after, verdict, settings.clean)
        mixtures = [each.weighted(certainty) for each in mixtures]
        impulsive = parts.at_vertices(certainty > 0) & impulsive
    counted, kept = parts.is_counted, np.ones(len(mixtures))
    for index, mixture in enumerate(mixtures):
        for used in mixture.used:
            removed_noise = (mixture.coefficients(used) * divergence[used])[counted]
            kept[index] -= removed_noise.mean(dtype=float) / correlation.deviation**2
    plan = DenoisePlan(
        filters,
        noise,
        tuple(pilots),
        tuple(mixtures),
        kept,
        impulsive,
        verdict.whole(verdict.reach),
        typical,
        correlation,
    )
    return _Planned(plan, sliding, certainty, clusters)


def _certainty(
    before: TriangleSurface, after: TriangleSurface, verdict: NoiseVerdict, clean: str
) -> tuple[FloatArray, bool]:
    """How certainly what was removed from each part is noise, (p,), and some of it like detail."""
    tuned, stage, parts = parameters(), verdict.stage, verdict.stage.parts
    noises = (stage.frame.raised(each) for each in verdict.examples())
    like_noise = [TriangleSurface(before.topology, before.positions - each) for each in noises]
    # Smooth patches have no noise, and what is removed beside them no clusters.
    there = np.where(parts.is_rough(before), verdict.whole(verdict.level), 0)
    found, *of_noise = ordered_map(
        lambda surface: parts.clustering(before, surface, there), (after, *like_noise)
    )
    # Many spikes leave many neighbours that stand out.
    share = parts.sums(stage.spikes) / np.maximum(parts.counts(), 1)
    excess = found - np.mean(of_noise, axis=0) - share
    # Uneven noise could explain clusters, so only noise without any is taken for uneven.
    is_strict = clean == "detail" or verdict.unevenness is not None
    is_noise = excess <= (tuned.clustered_detail if is_strict else tuned.most_clustered)
    is_noise &= parts.likeness(before, after, there) <= tuned.most_alike
    # Where nothing goes, nothing is alike.
    clusters = is_noise & (found > 0) & (excess > tuned.clustered_detail)
    certainty = np.where(is_noise, verdict.certainty, 0.0)
    # What may be detail stays where it was asked for.
    return np.floor(certainty) if clean == "detail" else certainty, bool(clusters.any())


def _filter_all(tracks: Sequence[Track], families: Round, pilot: Mixture | None = None) -> None:
    """Filter all surfaces in the next round, on the surfaces of a mixture if one is given.

    All have the flat faces of the first: a probe tells what flattening them removes, not which
    other faces may be found.
    """
    if pilot is not None:
        _for_all(tracks, lambda one: one.mix(pilot))
    found = tracks[0].with_faces(families)
    _for_all(tracks, lambda one: one.filter(found))


def _for_all(tracks: Sequence[Track], work: Callable[[Track], None]) -> None:
    """Work on all surfaces, side by side if they are not too large."""
    if tracks[0].start.topology.n_vertices <= MOST_SIDE_BY_SIDE:
        for_each(work, tracks)
    else:
        for each in tracks:
            work(each)


class _Solves:
    """Report of all linear solves, collected from all runs, each in its own thread."""

    def __init__(self, progress: ProgressReport) -> None:
        self._progress = progress
        self._iterations = 0
        self._residual = 0.0
        self._converged = True
        self._lock = Lock()

    def count(self, report: SolveReport) -> None:
        """Count a finished solve."""
        with self._lock:
            self._iterations += report.iterations
            self._residual = max(self._residual, report.residual)
            self._converged &= report.converged
            self._progress.again()

    def report(self) -> SolveReport:
        """Report of all solves together."""
        return SolveReport(self._iterations, self._residual, self._converged)
