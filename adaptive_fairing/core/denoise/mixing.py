"""The automatic method: estimate the noise, filter in rounds, mix the filters for the least risk.

1.  Estimate the noise level of each connected part, by density (`mesh_parts`).
2.  Filter in the metrics of the slightly smoothed surface (`filter_bank`).  Mix the filters so that
    the estimated distance to the surface without noise is least (`unbiased_risk`).
3.  Filter in the metrics of that mixture, which shows the creases, and mix all filters so far.
    Repeat this in a metric of a smaller angle, and by fits to smoothed normals; last, where there
    are creases, by more of these and with flat faces made flat (`filter_rounds`, `flat_faces`).

How much of the noise a filter removes is measured by filtering a second time with a little noise
added: the metrics depend on the noise too, so a formula for linear filters would not do.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import compress
from threading import Lock

import numpy as np

from ..fem.loop_space import LoopSpace
from ..linalg.conjugate_gradients import SolveReport
from ..runtime.arrays import BoolArray, FloatArray, RealArray
from ..runtime.threads import for_each
from .creases import has_creases
from .filter_bank import FilterBank
from .filter_family import Filter
from .filter_rounds import Round, rounds_for
from .local_frame import LocalFrame
from .mesh_parts import MeshParts, NoiseFound
from .mixture import Mixture
from .noise.correlation import NoiseCorrelation, noise_correlation
from .noise.level import beyond_clean
from .noise.noisy_surface import NoisySurface
from .noise.repeats import repetition
from .noise.smooth_noise import SmoothNoise, smooth_noise
from .noise.spikes import without_spikes
from .parameters import parameters
from .plan import STRENGTHS, DenoisePlan
from .progress import ProgressReport
from .tangential_limit import Sliding

# Vertices of a mesh up to which both runs filter at once, each with one thread.  Most of their
# work is passes of numpy over all vertices, which no threads share.  It takes an eighth more
# memory.
MOST_SIDE_BY_SIDE = 1_000_000

SMOOTH = (
    "the surface is evenly uneven over several edges, by {:.2g} of an edge: fine detail, which was "
    "kept, or the smooth noise of a scanner, which is removed if all roughness counts as noise"
)
SMOOTH_REMOVED = (
    "the surface is uneven over several edges, by {:.2g} of an edge, as the smooth noise of a "
    'scanner is: it was removed; the setting "Keep Fine Detail" (clean "detail") keeps it'
)
IMPULSIVE = "the noise is impulsive: single vertices that stand out were put back first"


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
        Why nothing was done, if so.
    """

    positions: list[FloatArray]
    plan: DenoisePlan
    solve: SolveReport
    notes: tuple[str, ...]


def mixed_surfaces(
    space: LoopSpace,
    positions: FloatArray,
    is_still: BoolArray,
    *,
    strength: float = 1.0,
    features: str = "auto",
    clean: str = "keep",
    plan: DenoisePlan | None = None,
    progress: ProgressReport,
) -> MixedSurfaces:
    """Denoise positions on the solver's mesh, for all of `STRENGTHS`.

    Parameters
    ----------
    space : LoopSpace
    positions : (n, 3)
    is_still : (n,) bool
        Vertices that noise and risk are not judged from, besides those of the boundary.
    strength : float
        Factor of the estimated noise.
    features : "auto", "sharp" or "smooth"
        Which filters may be used: all, only those that keep creases, or only those that round
        them.
    clean : "keep", "detail" or "denoise"
        Whether what looks like a clean mesh stays as it is; with "detail" what is smooth over
        several edges does, too.
    plan : DenoisePlan, optional
        Of another frame of this surface: nothing is estimated then.
    progress : ProgressReport
    """
    solves = _Solves(progress)
    progress.begin("noise")
    stage = _Stage(space, positions, is_still, solves.count)
    notes: tuple[str, ...] = ()
    if plan is None:
        keeps_clean = clean != "denoise"
        found = stage.noise_found(strength, keeps_clean)
        impulsive, notes = found.impulsive, found.notes
        if impulsive.any():
            stage = stage.calmed(impulsive)
            found = stage.noise_found(strength, keeps_clean)
            notes = (IMPULSIVE,)
        level, counted = found.level, stage.parts.is_counted
        correlation = None
        # White noise that is stronger hides the smooth kind.
        if counted.any() and np.median(found.roughness[counted]) < parameters().least_roughness:
            smooth = smooth_noise(stage.noisy, counted)
            if clean == "denoise":
                is_removed = smooth.may_be_noise
            else:
                is_removed = clean == "keep" and stage.is_told(smooth)
            if is_removed:
                level, correlation = np.where(counted, smooth.level, 0), smooth.correlation
                notes = (SMOOTH_REMOVED.format(smooth.level),)
            elif smooth.is_likely and not beyond_clean(strength * level).any():
                notes = (SMOOTH.format(smooth.level), *notes)
        plan = DenoisePlan.idle(level)
        undented = stage.undented(level, impulsive)
        if undented is None and beyond_clean(max(STRENGTHS) * strength * level).any():
            if correlation is None:
                correlation = noise_correlation(stage.noisy, counted & (level > 0))
            plan = _planned(stage, level, correlation, strength, features, progress)
        plan = replace(plan, impulsive=impulsive)
    else:
        if plan.impulsive.any():
            stage = stage.calmed(plan.impulsive)
        undented = stage.undented(plan.noise, plan.impulsive) if plan.is_idle else None
        if not plan.is_idle:
            stage.repeat(plan, progress)
    if undented is not None:
        sliding = Sliding(space.topology, positions, stage.frame, has_creases=True)
        results = [sliding.limited(undented)] * len(STRENGTHS)
    elif plan.is_idle:
        results = [stage.track.positions] * len(STRENGTHS)
    else:
        progress.begin("mix")
        results = [stage.track.mixed(mixture) for mixture in plan.mixtures]
        is_sharp = has_creases(space.topology, results[STRENGTHS.index(1.0)])
        sliding = Sliding(space.topology, stage.track.positions, stage.frame, is_sharp)
        results = [sliding.limited(result) for result in results]
    return MixedSurfaces(results, plan, solves.report(), notes)


def _planned(
    stage: _Stage,
    noise: FloatArray,
    correlation: NoiseCorrelation,
    strength: float,
    features: str,
    progress: ProgressReport,
) -> DenoisePlan:
    """Filter in all rounds, and choose the coefficients of the filters after each."""
    tuned = parameters()
    bank, track, frame, parts = stage.bank, stage.track, stage.frame, stage.parts
    seen, noise = noise, noise / correlation.seen * correlation.deviation
    # The divergence weighted with the correlation of the noise comes from probes that have it too.
    probe = tuned.probe_size * correlation.applied(stage.noisy.own.probe(), frame)
    shadow = _Track(bank, track.positions + frame.raised(probe))

    # Kept in single precision, as what they are measured from.
    removed: list[RealArray] = []
    divergence: list[RealArray] = []

    def measure() -> None:
        """Measure the filters that are new: the normal part of what they remove, and of whose."""
        for each in list(track.taken)[len(removed) :]:
            own, probed = (one.removed(each, frame) for one in (track, shadow))
            removed.append(own.astype(np.float32))
            divergence.append(filter_divergence(own, probed, probe).astype(np.float32))

    def variance(factor: float) -> FloatArray:
        return np.square(
            tuned.noise_factor * beyond_clean(factor * strength * seen) / correlation.seen
        )

    # The pilots are for the noise as it is, so that runs of all strengths mix the same filters.
    first, *others = rounds_for(noise)
    pilot_variance = np.square(tuned.noise_factor * seen / correlation.seen)
    pilots: list[Mixture] = []
    progress.begin("filter", 1)
    _filter_both(track, shadow, first)
    for number, families in enumerate(others, start=2):
        progress.begin("filter", number)
        # The last round sharpens creases and takes a quarter of the time.
        if number > len(others) and not has_creases(bank.topology, track.surface):
            break
        measure()
        pilots.extend(parts.best_mixtures(removed, divergence, pilot_variance[None]))
        _filter_both(track, shadow, families, pilots[-1])
    progress.begin("mix")
    measure()
    shadow.taken.clear()  # has told all, and is large
    filters = tuple(track.taken)
    usable = [each.serves(features) for each in filters]
    rows = list(compress(removed, usable)), list(compress(divergence, usable))
    variances = np.stack([variance(factor) for factor in STRENGTHS])
    mixtures = [each.spread(usable) for each in parts.best_mixtures(*rows, variances)]
    counted, kept = parts.is_counted, np.ones(len(mixtures))
    for index, mixture in enumerate(mixtures):
        for used in mixture.used:
            removed_noise = (mixture.coefficients(used) * divergence[used])[counted]
            kept[index] -= removed_noise.mean(dtype=float) / correlation.deviation**2
    return DenoisePlan(filters, noise, tuple(pilots), tuple(mixtures), kept, np.zeros(len(noise)))


def _filter_both(
    track: _Track, shadow: _Track, families: Round, pilot: Mixture | None = None
) -> None:
    """Filter in the next round, on the surfaces of a mixture if one is given."""

    def filter_one(one: _Track) -> None:
        if pilot is not None:
            one.surface = one.mixed(pilot)
        one.filter(families)

    if len(track.positions) <= MOST_SIDE_BY_SIDE:
        for_each(filter_one, (track, shadow))
    else:
        filter_one(track)
        filter_one(shadow)


def filter_divergence(removed: FloatArray, shadow: FloatArray, probe: FloatArray) -> FloatArray:
    """How much of its own noise a filter removes at each vertex, (n,); for white noise 0 to 1.

    From what it removes of the positions, and of them with the probes added, (n,) each.  The
    neighbours' probes mix in, but cancel in sums over many vertices.

    Source: S. Ramani, T. Blu and M. Unser, Monte-Carlo SURE, 2008.
    """
    tuned = parameters()
    size = probe / tuned.probe_size
    divergence = shadow - removed
    divergence *= size / tuned.probe_size
    # Large probes would count for more than small ones, mostly with the probe itself.
    divergence -= np.square(size) - np.mean(np.square(size))
    return np.clip(
        divergence, 1 - tuned.largest_response, 1 + tuned.largest_response, out=divergence
    )


class _Stage:
    """Positions with all that the method needs of them before the noise is known."""

    def __init__(
        self,
        space: LoopSpace,
        positions: FloatArray,
        is_still: BoolArray,
        on_solve: Callable[[SolveReport], None],
    ) -> None:
        self._space, self._is_still, self._on_solve = space, is_still, on_solve
        self.bank = FilterBank(space.topology, positions, on_solve)
        self.track = _Track(self.bank, positions)
        self.frame = LocalFrame.of(space.topology, self.track.surface, self.track.surface)
        self.noisy = NoisySurface(space.topology, positions, self.frame)
        self.parts = MeshParts(space.topology, self.frame, is_still)

    def noise_found(self, strength: float, keeps_clean: bool) -> NoiseFound:
        """Estimate the noise."""
        return self.parts.noise(self.noisy, strength, keeps_clean=keeps_clean)

    def is_told(self, smooth: SmoothNoise) -> bool:
        """Whether smooth noise is told from shape: models, which repeat triangles, have none."""
        triangles = self.noisy.topology.triangles
        return smooth.is_noise and not repetition(triangles, self.noisy.positions).part

    def calmed(self, impulsive: FloatArray) -> _Stage:
        """Put vertices back that stand out, by a part (n,) of their way."""
        positions = self.track.positions
        calm = without_spikes(self.noisy, self.parts.is_counted, self.parts.may_move)
        start = positions + impulsive[:, None] * (calm - positions)
        return _Stage(self._space, start, self._is_still, self._on_solve)

    def undented(self, level: FloatArray, impulsive: FloatArray) -> FloatArray | None:
        """Make flat faces flat, where low spikes left dents, by a part (n,) of the way.

        None where that is not all there is to do: where spikes were not the noise, or the level
        (n,) of the rest is more than that of clean meshes, or there are no flat faces.
        """
        judged = level[level > 0]
        is_clean = not len(judged) or not beyond_clean(np.median(judged, keepdims=True)).any()
        start = calm = self.track.positions
        if not (impulsive.any() and is_clean and has_creases(self.bank.topology, start)):
            return None
        for _ in range(parameters().undenting_rounds):
            flat = self.bank.flattened(calm, calm, parameters().least_flat_dented)
            if flat is None:
                return None
            calm = flat
        result: FloatArray = start + impulsive[:, None] * (calm - start)
        return result

    def repeat(self, plan: DenoisePlan, progress: ProgressReport) -> None:
        """Filter as on another frame of the surface."""
        first, *others = rounds_for(plan.noise)
        progress.begin("filter", 1)
        self.track.filter(first)
        # Without creases there was no last round.
        for number, (families, pilot) in enumerate(zip(others, plan.pilots, strict=False), start=2):
            progress.begin("filter", number)
            self.track.surface = self.track.mixed(pilot)
            self.track.filter(families)


class _Track:
    """Positions on their way through the filters, with what each filter takes away.

    What is taken away is kept in single precision, which is plenty for it, to save memory.
    """

    def __init__(self, bank: FilterBank, positions: FloatArray) -> None:
        self.positions = positions
        self._bank = bank
        self.surface, filtered = bank.started(positions)
        self.taken: dict[Filter, RealArray] = {
            each: (positions - result).astype(np.float32) for each, result in filtered.items()
        }

    def filter(self, families: Round) -> None:
        """Add filters in metrics of the present surface, or fits to its normals."""
        for each, filtered in self._bank.filtered(self.positions, self.surface, families):
            self.taken[each] = (self.positions - filtered).astype(np.float32)

    def removed(self, each: Filter, frame: LocalFrame) -> FloatArray:
        """Measure the normal part of what a filter takes away, in local edge lengths, (n,)."""
        return frame.along_normal(self.taken[each].astype(np.float64))

    def mixed(self, mixture: Mixture) -> FloatArray:
        """Mix the filters so far."""
        result, taken = self.positions.copy(), list(self.taken.values())
        for used in mixture.used:
            result -= mixture.coefficients(used)[:, None] * taken[used]
        return result


class _Solves:
    """What is to be reported of all linear solves; both runs count here, each in its thread."""

    def __init__(self, progress: ProgressReport) -> None:
        self._progress = progress
        self._iterations = 0
        self._residual = 0.0
        self._converged = True
        self._lock = Lock()

    def count(self, report: SolveReport) -> None:
        """Note that a solve is done."""
        with self._lock:
            self._iterations += report.iterations
            self._residual = max(self._residual, report.residual)
            self._converged &= report.converged
            self._progress.again()

    def report(self) -> SolveReport:
        """All solves together."""
        return SolveReport(self._iterations, self._residual, self._converged)
