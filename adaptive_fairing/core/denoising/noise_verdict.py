"""Verdict on the noise of a surface, of all kinds."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..runtime.arrays import BoolArray, FloatArray
from ..runtime.lazy import cached_property
from .mesh_parts import NoiseFound
from .noise.given_width import noise_of_width
from .noise.noisy_surface import NoisySurface
from .noise.own_numbers import WHITE_NOISE
from .noise.smooth_noise import SmoothNoise, smooth_noise
from .noise.spikes import KnownNoise, left_of_spikes, put_back_of, spike_law
from .noise_model import NoiseCorrelation
from .parameters import parameters
from .stage import Stage

SMOOTH = (
    "the surface is uniformly rough over several edges, by {:.2g} of an edge: fine detail, which "
    "was kept, or the smooth noise of a scanner, which is removed if all roughness counts as noise "
    "or its size is given"
)
SMOOTH_REMOVED = (
    "the surface is rough over several edges, by {:.2g} of an edge, as the smooth noise of a "
    'scanner is: it was removed; the setting "Keep Fine Detail" (clean "detail") keeps it'
)
IMPULSIVE = "the noise is impulsive: single vertices that stand out were put back first"


@dataclass(frozen=True)
class NoiseVerdict:
    """The noise of a surface.

    Attributes
    ----------
    stage : Stage
        The surface; spikes were put back.
    level : (n,)
        Standard deviation in local edge lengths, as differences of second order show it; 0 where
        there is no noise, or none was judged.
    smooth : NoiseCorrelation or None
        Correlation of noise that is smooth over several edges; None for other noise.
    impulsive : (n,) bool
        Where the noise was that of single vertices.
    reach : (n,)
        Standard deviation in local edge lengths of all noise, including spikes; 0 where nothing
        may move.
    notes : tuple of str
    other_readings : tuple of str
        See `DenoiseResult`.
    spiky : (n,), optional
        Random noise with spikes like those that were put back: heights in local edge lengths.
    unevenness : (n,), optional
        Factor in `level` and `reach` of noise that is stronger in one place than in another.
    certainty : (p,) or float
        How certainly that is noise in each part of the mesh, 0 to 1: so much of it is removed.
    """

    stage: Stage
    level: FloatArray
    smooth: NoiseCorrelation | None
    impulsive: BoolArray
    reach: FloatArray
    notes: tuple[str, ...]
    other_readings: tuple[str, ...] = ()
    spiky: FloatArray | None = None
    unevenness: FloatArray | None = None
    certainty: FloatArray | float = 1.0

    def readings(self) -> tuple[NoiseVerdict, ...]:
        """Return this verdict and, if the noise is uneven, that for even noise."""
        if self.unevenness is None:
            return (self,)
        level, reach = (each / self.unevenness for each in (self.level, self.reach))
        return self, replace(self, level=level, reach=reach, unevenness=None)

    @cached_property
    def correlation(self) -> NoiseCorrelation:
        """Correlation of the noise at neighbours."""
        if self.smooth is not None:
            return self.smooth
        judged = self.stage.parts.is_counted & (self.level > 0)
        return self.stage.noisy.fading.correlation(judged)

    def whole(self, seen: FloatArray) -> FloatArray:
        """Size (n,) of the whole noise, from its size in differences of second order.

        Those show less of noise that is correlated at neighbours.
        """
        return seen / self.correlation.seen * self.correlation.deviation

    def examples(self) -> list[FloatArray]:
        """Return random noises like all that was found: heights in local edge lengths, (n,)."""
        if self.spiky is not None:
            return [self.spiky]
        noisy, correlation = self.stage.noisy, self.correlation
        scale = self.level / correlation.seen
        return [scale * correlation.applied(each, noisy.frame) for each in noisy.own.several()]


def noise_verdict(stage: Stage, clean: str, width: float | None = None) -> NoiseVerdict:
    """Judge the noise of a surface.

    Parameters
    ----------
    stage : Stage
    clean : "keep", "detail" or "denoise"
        See `DenoiseSettings`.
    width : float, optional
        Width of the noise in edges of this mesh, if it was given: that is not questioned.
    """
    counted = stage.parts.is_counted
    if np.count_nonzero(counted) < parameters().fewest:
        none = np.zeros(len(counted))
        return NoiseVerdict(stage, none, None, none > 0, none, (stage.parts.too_few(),))
    verdict, roughness = _narrow_noise(stage, keeps_clean=clean != "denoise")
    if width is not None:
        return _of_width(verdict, width)
    # White noise that is stronger hides the smooth kind.
    if np.median(roughness[counted]) >= parameters().least_roughness:
        return verdict
    return _with_smooth_noise(verdict, clean)


class _Calm(NamedTuple):
    """A surface whose spikes were put back.

    Attributes
    ----------
    stage : Stage
    found : NoiseFound
        What noise is left.
    other : KnownNoise
        Normal noise like it, put back in the same way.
    moved : (n,)
        How far the spikes were put back, along the normals, in local edge lengths.
    """

    stage: Stage
    found: NoiseFound
    other: KnownNoise
    moved: FloatArray


def _narrow_noise(stage: Stage, *, keeps_clean: bool) -> tuple[NoiseVerdict, FloatArray]:
    """Judge spikes and noise that is at most alike at neighbours; also give the roughness, (n,)."""
    found = stage.parts.noise(stage.noisy, keeps_clean=keeps_clean)
    if found.impulsive.any():
        calm = _calmed(stage, found.impulsive, keeps_clean)
        impulsive = _noisy_spikes(stage, found, calm)
        if impulsive.any():
            if not np.array_equal(impulsive, found.impulsive):
                calm = _calmed(stage, impulsive, keeps_clean)
            return _without_spikes(found, calm, impulsive), calm.found.roughness
        # Spikes of the shape: there is noise only where it is rough without them.
        level = np.where(calm.found.level > 0, found.level, 0)
        notes = found.notes or calm.found.notes
        if not (notes or level.any()):
            notes = (stage.parts.why_nothing(found.roughness),)
        found = found._replace(level=level, impulsive=impulsive, notes=notes)
    was_kept = bool(found.notes) and keeps_clean
    others = ("denoise",) if was_kept and found.roughness.any() else ()
    level, impulsive = found.level, found.impulsive
    verdict = NoiseVerdict(
        stage,
        level,
        None,
        impulsive,
        level,
        found.notes,
        others,
        unevenness=found.unevenness,
        certainty=found.certainty,
    )
    return verdict, found.roughness


def _calmed(stage: Stage, impulsive: BoolArray, keeps_clean: bool) -> _Calm:
    """Put spikes back among some vertices, (n,) bool, and estimate what noise is left."""
    calm = stage.calmed(impulsive)
    noisy, parts = calm.noisy, calm.parts
    found = parts.noise(noisy, keeps_clean=keeps_clean)
    noise = found.level * noisy.own.noise(WHITE_NOISE)
    other = put_back_of(noise, noisy, parts.is_counted, parts.may_move)
    moved = calm.frame.along_normal(stage.noisy.positions - noisy.positions)
    return _Calm(calm, found, other, moved)


def _noisy_spikes(stage: Stage, found: NoiseFound, calm: _Calm) -> BoolArray:
    """Whether vertices which stand out are noise, (n,); not if they belong to the shape."""
    tuned, parts, spikes = parameters(), stage.parts, calm.stage.spikes
    n_spikes, n_judged = parts.sums(spikes), np.maximum(parts.counts(), 1)
    # Where there is no other noise, they stand out of more than the roughness of clean meshes: the
    # corners of facets that were divided had up to 0.067 edges, rounded depths 0.11, spikes 0.58.
    size, _ = spike_law(np.abs(calm.moved[parts.is_counted]), spikes[parts.is_counted])
    may_be_alone = (n_spikes >= tuned.fewest) & (size > 2 * tuned.clean_roughness)
    # Spikes may be anywhere, corners of a shape are beside others.
    least = np.maximum(found.roughness, tuned.clean_roughness)
    clustering = parts.clustering(stage.track.start, calm.stage.track.start, least)
    # What chance may have hidden counts against them: few corners are beside each other.
    most = n_spikes / n_judged + tuned.most_clustered_spikes
    are_anywhere = clustering + 1 / np.sqrt(n_judged) <= most
    # Normal noise has vertices that stand out, too.
    explained, squares = (parts.sums(np.square(each)) for each in (calm.other.moved, calm.moved))
    are_more = explained <= tuned.most_explained * squares
    is_noise = parts.at_vertices(may_be_alone) | (calm.found.level > 0)
    is_noise &= parts.at_vertices(are_anywhere & are_more)
    noisy: BoolArray = is_noise & found.impulsive
    return noisy


def _without_spikes(found: NoiseFound, calm: _Calm, impulsive: BoolArray) -> NoiseVerdict:
    """Judge what is left without spikes: other noise, low spikes, and what was put back."""
    stage, after = calm.stage, calm.found
    parts = stage.parts
    noise, more = left_of_spikes(
        stage.noisy, calm.moved, stage.spikes, calm.other, parts.is_counted, parts.may_move
    )
    left = np.where(impulsive & parts.is_counted, more, 0)
    level = np.sqrt(np.square(after.level) + left)
    reach = np.maximum(level, np.where(impulsive, found.roughness, 0))
    return NoiseVerdict(
        stage,
        level,
        None,
        impulsive,
        reach,
        (IMPULSIVE,),
        spiky=noise,
        unevenness=after.unevenness,
        certainty=after.certainty,
    )


def _with_smooth_noise(verdict: NoiseVerdict, clean: str) -> NoiseVerdict:
    """Look for noise that is smooth over several edges, on flat faces and elsewhere."""
    stage, counted = verdict.stage, verdict.stage.parts.is_counted
    seen = stage.noisy.in_unit(counted)
    anywhere = smooth_noise(seen, counted)
    # Wider waves that are stronger and stronger are those of terrain, and this is none.
    if stage.noisy.is_object:
        anywhere = anywhere._replace(excess=0.0)
    for smooth in (stage.face_noise(seen), anywhere):
        if smooth is not None and _is_removed(smooth, clean):
            verdict = _of_level(verdict, _per_edge(smooth.level, seen, stage), smooth.correlation)
            notes = (*verdict.notes, SMOOTH_REMOVED.format(smooth.level))
            others = ("detail",) if clean == "keep" else ()
            return replace(verdict, notes=notes, other_readings=others)
    if anywhere.is_likely and not verdict.level.any():
        return replace(verdict, notes=(SMOOTH.format(anywhere.level), *verdict.notes))
    return verdict


def _of_width(verdict: NoiseVerdict, width: float) -> NoiseVerdict:
    """Judge noise of a given width: it is not questioned.

    Where white noise was found anyway, it is as it was found, uneven or that of staircases.
    """
    stage, counted = verdict.stage, verdict.stage.parts.is_counted
    seen = stage.noisy.in_unit(counted)
    size, correlation = noise_of_width(seen, stage.face_noise(seen), counted, width)
    told = _per_edge(size, seen, stage)
    if correlation.passes or not verdict.level.any():
        return _of_level(verdict, told, correlation)
    level = np.where(verdict.level > 0, verdict.level, told)
    return replace(verdict, level=level, reach=np.maximum(verdict.reach, level), other_readings=())


def _of_level(
    verdict: NoiseVerdict, level: FloatArray, correlation: NoiseCorrelation
) -> NoiseVerdict:
    """Return a verdict on noise of another level (n,), which is smooth, besides any spikes."""
    return replace(
        verdict,
        level=level,
        reach=np.maximum(verdict.reach, level),
        smooth=correlation,
        unevenness=None,
        notes=verdict.notes if verdict.impulsive.any() else (),
        other_readings=(),
    )


def _per_edge(size: float, seen: NoisySurface, stage: Stage) -> FloatArray:
    """Express a level in the unit of a surface along its lines of sight in local edges, (n,)."""
    per_edge = seen.frame.spacing / stage.noisy.frame.spacing
    return np.where(stage.parts.is_counted, size * per_edge, 0)


def _is_removed(smooth: SmoothNoise, clean: str) -> bool:
    """Whether smooth noise is to be removed."""
    if clean == "denoise":
        return smooth.may_be_noise
    return clean == "keep" and smooth.is_noise
