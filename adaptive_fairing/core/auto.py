"""Fairing without a parameter: the noise is estimated, and filters are mixed for the least risk.

1.  Noise level of each connected part, by density (`noise_level`).
2.  Filters in metrics of the slightly smoothed surface (`filter_bank`), and the mixture of them
    with the least estimated distance to the surface without noise (`unbiased_risk`).
3.  The same again with metrics of that mixture, which knows the creases, and once more with a
    smaller angle; the last mixture is of all filters of all rounds.

How much of the noise a filter removes is measured by filtering a second time with a little noise
of our own added: the metrics follow the noise too, which no formula for a linear filter sees.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .assembly import LoopSpace
from .errors import InputError
from .filter_bank import GENTLE, STEEP, FilterBank, FilterFamily
from .lifted_metric import LiftedMetric
from .linear_solver import SolveReport
from .mesh_parts import MeshParts
from .noise_level import LocalFrame, beyond_clean
from .topology import TriangleTopology

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

# Filters of each round, in metrics of the mixture of the rounds before it.  The angles are for
# noise of `COARSE_NOISE` or more; with less noise the normals are less disturbed, and smaller
# angles tell creases from it.
ROUNDS = (
    (
        FilterFamily(LiftedMetric(0), STEEP),
        FilterFamily(LiftedMetric(1), STEEP),
        FilterFamily(LiftedMetric(1, 0.3), GENTLE),
    ),
    (
        FilterFamily(LiftedMetric(0, 0.07), GENTLE),
        FilterFamily(LiftedMetric(0, 0.3), STEEP),
        FilterFamily(LiftedMetric(1, 0.3), STEEP),
    ),
    (FilterFamily(LiftedMetric(0, 0.035), GENTLE),),
)
FAMILIES = tuple(family for families in ROUNDS for family in families)
COARSE_NOISE = 0.2
LEAST_ANGLE_FACTOR = 0.1

# Angle of each filter.  With at most `SHARP_ANGLE` it keeps creases, without one (inf) it rounds
# them; those between keep what stands out of the noise.
ANGLES = np.repeat(
    [np.inf if f.metric.angle is None else f.metric.angle for f in FAMILIES],
    [len(f.diffusions) for f in FAMILIES],
)
SHARP_ANGLE = 0.1
KEEPS_CREASES = ANGLES <= SHARP_ANGLE
USABLE = {"auto": ANGLES > 0, "sharp": KEEPS_CREASES, "smooth": np.isinf(ANGLES)}
# An edge is a crease if the normals beside it differ by this many radians; and a mesh with creases
# has at least such a share of them.
CREASE_ANGLE = 0.6
CREASE_SHARE = 0.02

# Strengths relative to the chosen one, as factors of the estimated noise.
STRENGTHS = (0.5, 0.75, 1.0, 1.5, 2.0)
CHOSEN = STRENGTHS.index(1.0)

# Least risk at the estimated noise leaves a little more of it than looks and measures best, because
# the estimate is a lower bound; found on meshes with known noise.
NOISE_FACTOR = 1.1

# Solves for the filters of one metric, as far as the progress goes; it differs a little.
EXPECTED_SOLVES = 9

PROBE_SIZE = 0.02  # in local edge lengths: small against any noise, large against rounding
PROBE_SEED = 0
# A probe that folds a triangle over changes the filtered surface by leaps; such outliers of its
# response, which is about 1 at most, are cut off.
LARGEST_RESPONSE = 3.0


@dataclass(frozen=True)
class AutoPlan:
    """How the filters were mixed on one mesh, for other frames of the same surface.

    Attributes
    ----------
    noise : (n,)
        Level at the solver's vertices, in local edge lengths; 0 where it was not judged.
    pilots : sequence of (k, n), mixtures : (s, k, n)
        Shares of the filters so far at each vertex after each round but the last, and of all of
        them for each strength.
    kept : (s,)
        Share of white noise that each mixture keeps.
    """

    noise: FloatArray
    pilots: tuple[FloatArray, ...]
    mixtures: FloatArray
    kept: FloatArray


@dataclass(frozen=True)
class AutoEstimate:
    """What `auto` found and chose.

    Attributes
    ----------
    strength : float
        Factor of the estimated noise that the positions are meant for.
    noise : float
        Median standard deviation of the noise along the normals, in local edge lengths.
    noise_length : float
        The same in object units.
    radius : float
        Smoothing radius: of the Gaussian filter that keeps the same share of white noise, in local
        edge lengths.
    sharp_share : float
        Share of the filters that keep creases in what was removed, 0 to 1.
    crease_share : float
        Share of creases among the edges of the faired mesh, 0 to 1.
    is_sharp : bool
        Whether creases were asked for; or else whether the faired mesh has a share of them that
        smooth meshes do not have.
    is_chosen : bool
        Whether this is the strength that was asked for.
    plan : AutoPlan
        For other frames of the same surface.
    """

    strength: float
    noise: float
    noise_length: float
    radius: float
    sharp_share: float
    crease_share: float
    is_sharp: bool
    is_chosen: bool
    plan: AutoPlan = field(repr=False, compare=False)


@dataclass(frozen=True)
class AutoOutcome:
    """Surfaces for all strengths, ascending.

    Attributes
    ----------
    positions : list of (n, 3)
    estimates : list of AutoEstimate
    solve : SolveReport
        Iterations of all solves together, and the worst of their residuals.
    notes : tuple of str
        Why nothing was done, if so.
    """

    positions: list[FloatArray]
    estimates: list[AutoEstimate]
    solve: SolveReport
    notes: tuple[str, ...]


def auto_surfaces(
    space: LoopSpace,
    positions: FloatArray,
    is_still: BoolArray,
    *,
    strength: float = 1.0,
    features: str = "auto",
    plan: AutoPlan | None = None,
    progress: Callable[[float], None] | None = None,
) -> AutoOutcome:
    """Fair a mesh for several strengths.

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
    plan : AutoPlan, optional
        Of another frame of this surface: nothing is estimated then.
    progress : callable, optional
        Called with the share of the work that is done; may raise to end it.

    Raises
    ------
    InputError
        A plan of a mesh of another size.
    """
    n_spaces = 1 + len(FAMILIES)
    solves = _Solves(EXPECTED_SOLVES * n_spaces * (2 if plan is None else 1), progress)
    bank = FilterBank(space, positions, solves.count)
    track = _Track(bank, positions)
    frame = LocalFrame.of(space.topology, track.surface, track.surface)
    notes: tuple[str, ...] = ()
    if plan is None:
        parts = MeshParts(space.topology, frame, is_still)
        noise, notes = parts.noise(positions, strength)
        if beyond_clean(max(STRENGTHS) * strength * noise).any():
            plan = _planned(bank, track, frame, parts, noise, strength, features)
        else:
            plan = _idle_plan(noise)
    elif plan.mixtures.shape[2] != len(positions):
        raise InputError(
            f"the plan is of a mesh of {plan.mixtures.shape[2]} vertices, not {len(positions)}"
        )
    elif plan.mixtures.any():
        first, *others = _rounds(strength * plan.noise)
        track.filter(first)
        for families, pilot in zip(others, plan.pilots, strict=True):
            track.surface = track.mixed(pilot)
            track.filter(families)
    results = [track.mixed(shares) for shares in plan.mixtures]
    estimates = [
        _estimate(plan, frame, strength, features, index, _crease_share(space.topology, result))
        for index, result in enumerate(results)
    ]
    if progress is not None:
        progress(1.0)
    return AutoOutcome(results, estimates, solves.report(), notes)


def _planned(
    bank: FilterBank,
    track: _Track,
    frame: LocalFrame,
    parts: MeshParts,
    noise: FloatArray,
    strength: float,
    features: str,
) -> AutoPlan:
    """Filter in all rounds, and choose the shares in each."""
    sign = np.random.default_rng(PROBE_SEED).choice([-1.0, 1.0], len(noise))
    probe = (PROBE_SIZE * sign * frame.spacing)[:, None] * frame.normals
    shadow = _Track(bank, track.positions + probe)

    def measured() -> tuple[FloatArray, FloatArray]:
        removed = track.removed(frame)
        return removed, 1 - _response(removed, shadow.removed(frame), sign)

    def variance(factor: float) -> FloatArray:
        return np.square(NOISE_FACTOR * beyond_clean(factor * strength * noise))

    first, *others = _rounds(strength * noise)
    pilots = []
    for one in (track, shadow):
        one.filter(first)
    for families in others:
        pilots.append(parts.best_shares(*measured(), variance(1.0)))
        for one in (track, shadow):
            one.surface = one.mixed(pilots[-1])
            one.filter(families)
    removed, divergence = measured()
    usable = USABLE[features]
    mixtures = np.zeros((len(STRENGTHS), *removed.shape))
    for shares, factor in zip(mixtures, STRENGTHS, strict=True):
        shares[usable] = parts.best_shares(removed[usable], divergence[usable], variance(factor))
    removed_noise = np.einsum("skn,kn->sn", mixtures, divergence)[:, parts.is_counted]
    return AutoPlan(noise, tuple(pilots), mixtures, 1 - removed_noise.mean(axis=1))


def _idle_plan(noise: FloatArray) -> AutoPlan:
    """Leave everything as it is."""
    nothing = np.zeros((len(STRENGTHS), 0, len(noise)))
    return AutoPlan(noise, (), nothing, np.ones(len(STRENGTHS)))


def _rounds(noise: FloatArray) -> list[list[FilterFamily]]:
    """Scale the angles of all rounds' metrics to the noise, (n,), of the vertices judged."""
    typical = float(np.median(noise[noise > 0])) if noise.any() else 0.0
    factor = float(np.clip(typical / COARSE_NOISE, LEAST_ANGLE_FACTOR, 1))

    def scaled(metric: LiftedMetric) -> LiftedMetric:
        return metric if metric.angle is None else metric._replace(angle=factor * metric.angle)

    return [
        [family._replace(metric=scaled(family.metric)) for family in families]
        for families in ROUNDS
    ]


def _response(removed: FloatArray, shadow: FloatArray, sign: FloatArray) -> FloatArray:
    """Share of its own noise that each filter keeps at each vertex, (k, n).

    From what the filters remove of the positions, and of them with the probes added.  The
    neighbours' probes mix in, but cancel in sums over many vertices.

    Source: S. Ramani, T. Blu and M. Unser, Monte-Carlo SURE, 2008.
    """
    response = shadow - removed
    response *= -sign / PROBE_SIZE
    response += 1
    return np.clip(response, -LARGEST_RESPONSE, LARGEST_RESPONSE, out=response)


def _estimate(
    plan: AutoPlan,
    frame: LocalFrame,
    strength: float,
    features: str,
    index: int,
    crease_share: float,
) -> AutoEstimate:
    shares, kept = plan.mixtures[index], float(np.clip(plan.kept[index], 1e-6, 1))
    judged = plan.noise > 0
    level = plan.noise[judged] if judged.any() else np.zeros(1)
    length = level * frame.spacing[judged] if judged.any() else np.zeros(1)
    sharp = shares[KEEPS_CREASES] if len(shares) else shares
    total = float(shares.sum())
    sharp_share = float(sharp.sum()) / total if total > 0 else 0.0
    has_creases = crease_share > CREASE_SHARE
    # A Gaussian of standard deviation r keeps cell / (2 π r²) of white noise, with the area
    # √3/2 of a vertex's cell; the 1 makes the radius of doing nothing 0.
    radius = np.sqrt(np.sqrt(3) / (4 * np.pi) * (1 / kept - 1))
    return AutoEstimate(
        strength=STRENGTHS[index] * strength,
        noise=float(np.median(level)),
        noise_length=float(np.median(length)),
        radius=float(radius),
        sharp_share=sharp_share,
        crease_share=crease_share,
        is_sharp=has_creases if features == "auto" else features == "sharp",
        is_chosen=index == CHOSEN,
        plan=plan,
    )


def _crease_share(topology: TriangleTopology, positions: FloatArray) -> float:
    """Share of the inner edges of a mesh that are creases."""
    corner = positions[topology.triangles]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    side = np.flatnonzero(topology.twin >= 0)
    cosine = np.einsum("ed,ed->e", normal[side // 3], normal[topology.twin[side] // 3])
    return float(np.mean(cosine < np.cos(CREASE_ANGLE))) if len(side) else 0.0


class _Track:
    """Positions on their way through the filters, with what each filter takes away.

    What is taken away is kept in single precision, which is plenty for it, to save memory.
    """

    def __init__(self, bank: FilterBank, positions: FloatArray) -> None:
        self.positions = positions
        self.surface = bank.first_surface(positions)
        self.taken: list[NDArray[np.float32]] = []
        self._bank = bank

    def filter(self, families: list[FilterFamily]) -> None:
        """Add filters in metrics of the present surface."""
        for filtered in self._bank.filtered(self.positions, self.surface, families):
            self.taken.append((self.positions - filtered).astype(np.float32))

    def removed(self, frame: LocalFrame) -> FloatArray:
        """Measure the normal part of what each filter takes away, in local edge lengths, (k, n)."""
        removed = np.empty((len(self.taken), len(self.positions)))
        for row, taken in zip(removed, self.taken, strict=True):
            row[:] = frame.along_normal(taken.astype(np.float64))
        return removed

    def mixed(self, shares: FloatArray) -> FloatArray:
        """Mix the filters with shares (k, n) at each vertex."""
        result = self.positions.copy()
        for share, taken in zip(shares, self.taken, strict=True):
            if share.any():
                result -= share[:, None] * taken
        return result


class _Solves:
    """Count of the linear solves: the progress, and what is to be reported of them."""

    def __init__(self, n_expected: int, progress: Callable[[float], None] | None) -> None:
        self._n_expected, self._progress = n_expected, progress
        self._n_done = self._iterations = 0
        self._residual = 0.0
        self._converged = True

    def count(self, report: SolveReport) -> None:
        """Note that a solve is done."""
        self._n_done += 1
        self._iterations += report.iterations
        self._residual = max(self._residual, report.residual)
        self._converged &= report.converged
        if self._progress is not None:
            self._progress(min(self._n_done / self._n_expected, 1.0))

    def report(self) -> SolveReport:
        """All solves together."""
        return SolveReport(self._iterations, self._residual, self._converged)
