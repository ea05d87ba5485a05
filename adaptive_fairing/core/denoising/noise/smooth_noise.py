"""Smooth noise: correlated over several edges, like that of range scanners and depth cameras.

It hardly shows in differences of second order.  It does in wider bands, between averages over few
and over many neighbours, but so does shape.  Three properties together separate the two:

- Noise is equally strong everywhere, while a shape bends more here and less there.  The quiet part
  of a noisy shape has only noise, so evenness, hills and outliers are judged there.
- Noise has, band by band, the strengths of averaged white noise.
- Noise is normally distributed: it has no outliers, and as many hills as valleys.

None of them tells alone.  Their sum, each with a weight, is the logarithm of the odds that this is
noise and not detail of the shape (`evidence_of_noise`).  `python -m
research.denoising.smooth_evidence` judges the weights on shapes with noise and with detail.  Two
things no other makes up for.  Noise is everywhere, in the hinges and where bands are low, too
(`with_presence`).  And in the next wider band it is hardly stronger, while shape goes on growing.

Detail as fine, as even and as random as noise, such as the grain of a rock, looks the same.

Noise whose width the user has told is not questioned (`given_width`).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ...runtime.arrays import BoolArray, FloatArray
from ..noise_model import WHITE, NoiseCorrelation, averaged_noise
from ..parameters import parameters
from ..triangle_surface import TriangleSurface
from .contrast import hinges
from .level import NORMAL_MEDIAN
from .noisy_surface import NoisySurface
from .own_numbers import SEVERAL_NOISES, WHITE_NOISE

# Passes of averaging that bound the bands, from narrow to wide.  Evenness is that of the first
# three; the last one tells whether waves go on growing.
BANDS = ((0, 1), (1, 3), (3, 8), (8, 20))
N_NARROW = 3
# Passes of averaging of white noise that are tried, and fewest of noise that is smooth.
PASSES = (0, 1, 2, 3, 4, 6, 8, 12, 16)
FEWEST_PASSES = 2
# Weights of the bands in the fit: the narrowest shows the edges of the mesh, the widest the shape.
WEIGHTS = np.array([0.5, 1.0, 1.0, 0.0])

# Weaker bands are rounding. They count as so strong, since logarithms and quotients are taken.
LEAST_STRENGTH = 1e-12

# Quantile of the outliers, and that over the median of |x| for a normal distribution.
TAIL, NORMAL_TAIL = 0.95, 2.9058


class SmoothNoise(NamedTuple):
    """Candidate for smooth noise.

    Attributes
    ----------
    level : float
        Standard deviation in local edge lengths.
    correlation : NoiseCorrelation
    misfit : float
        Weighted sum of the squared logarithms by which the bands differ from those of noise.
    evenness : float
        Evenness of the bands over the surface, relative to this noise; 0 to about 1.
    outliers : float
        Size of the largest heights, relative to a normal distribution.
    lean : float
        Imbalance between hills and valleys, 0 to 1.
    is_enough : bool
        Whether it was measured on enough of the surface to be told.
    excess : float
        Logarithm of the strength of the widest band relative to noise; 0 where no shape adds to it.
    least_evidence : float
        Evidence with which it is removed without being asked.
    presence : float
        Strength where there is least of it, relative to this noise; 1 if it is not asked.
    """

    level: float
    correlation: NoiseCorrelation = WHITE
    misfit: float = np.inf
    evenness: float = 0.0
    outliers: float = np.inf
    lean: float = 1.0
    is_enough: bool = True
    excess: float = 0.0
    least_evidence: float = 0.0
    presence: float = 1.0

    @property
    def may_be_noise(self) -> bool:
        """Whether this is noise, provided that all roughness is noise."""
        tuned = parameters()
        return (
            self.correlation.passes >= FEWEST_PASSES
            and self.level >= tuned.clean_roughness
            and self.misfit <= tuned.most_misfit
        )

    @property
    def may_be_judged(self) -> bool:
        """Whether it was measured on enough of the surface, and is not stronger than noise is."""
        return self.may_be_noise and self.is_enough and self.level <= parameters().face_height

    @property
    def evidence(self) -> float:
        """Logarithm of the odds that this is noise and not detail."""
        return evidence_of_noise(self.misfit, self.evenness, self.outliers, self.lean)

    @property
    def is_likely(self) -> bool:
        """Whether this is noise rather than detail, but not as clearly as `is_noise`."""
        return self.may_be_judged and self.evidence >= 0

    @property
    def may_be_told(self) -> bool:
        """Whether evidence decides: there is enough, and nothing contradicts it alone.

        Noise is everywhere, and the widest band does not go on growing.
        """
        tuned = parameters()
        is_everywhere = self.presence >= tuned.least_presence
        return self.may_be_judged and is_everywhere and self.excess <= tuned.told_excess

    @property
    def is_noise(self) -> bool:
        """Whether this differs from shape clearly enough to be removed without being asked."""
        return self.may_be_told and self.evidence >= self.least_evidence


class _Compared(NamedTuple):
    """A noise that a surface was compared with.

    Attributes
    ----------
    correlation : NoiseCorrelation
    bands : (k, n)
        Its heights.
    ratios : (k,)
        Logarithms of the strength of the surface's bands, where it is quiet, over that of noise.
    """

    correlation: NoiseCorrelation
    bands: FloatArray
    ratios: FloatArray


def evidence_of_noise(misfit: float, evenness: float, outliers: float, lean: float) -> float:
    """Logarithm of the odds that the roughness is smooth noise and not detail of the shape.

    The arguments are measures of `SmoothNoise`.

    The weights are those that tell the most noise at few alarms.

    Source: the logistic model, D. R. Cox, The regression analysis of binary sequences, 1958.
    """
    tuned = parameters()
    if not np.isfinite(misfit):
        return -np.inf
    measures = measures_of_noise(misfit, evenness, outliers, lean)
    return float(np.dot(tuned.evidence_weights, (*measures, 1)))


def measures_of_noise(
    misfit: float, evenness: float, outliers: float, lean: float
) -> tuple[float, ...]:
    """Return the variables in which the evidence is linear, bounded on the side of noise."""
    return (
        float(np.log(misfit + 0.005)),
        min(evenness, 1.0),
        # Too few outliers are as little like noise as too many.
        float(np.log(max(outliers, 0.9, 0.64 / max(outliers, 1e-9)))),
        float(np.log(lean + 0.01)),
    )


def smooth_noise(surface: NoisySurface, is_counted: BoolArray) -> SmoothNoise:
    """Find the noise, several edges wide, that explains the quietest part of a mesh.

    Parameters
    ----------
    surface : NoisySurface
    is_counted : (n,) bool
        Vertices to judge from, at least one.
    """
    tuned, frame = parameters(), surface.frame
    heights = band_heights(surface.positions, frame)
    strength = local_strengths(heights, frame, is_counted)
    quiet = quiet_part(strength)

    def compared(use: float, tried: tuple[int, ...]) -> Iterator[_Compared]:
        """Compare with one random noise, averaged by each of several numbers of passes."""
        white = surface.own.noise(use)
        unit = _of_white_noise(white, frame, is_counted)
        for passes in tried:
            noise, correlation = averaged_noise(white, passes, frame, is_counted)
            bands = band_heights(frame.raised(noise), frame)
            ratios = np.log(quiet / unit / typical_sizes(bands[:, is_counted]))
            yield _Compared(correlation, bands, ratios)

    first, *others = SEVERAL_NOISES
    candidates = list(compared(first, PASSES))
    _, misfits = levels_and_misfits(np.stack([each.ratios for each in candidates]), WEIGHTS)
    best = int(np.argmin(misfits))
    # Bands and evenness of one random noise differ by some percent from those of the next.
    same = [candidates[best]]
    for use in others:
        same += compared(use, PASSES[best : best + 1])
    ratios = np.mean([each.ratios for each in same], axis=0)
    (level,), (misfit,) = levels_and_misfits(ratios[None], WEIGHTS)
    strengths_of_noise = (local_strengths(each.bands, frame, is_counted) for each in same)
    evennesses = [
        least_evenness(strength, of_noise, tuned.low_quantile) for of_noise in strengths_of_noise
    ]
    # Shape stands out: where it is quiet there is as much noise, and less of shape.
    is_quiet = strength[1] <= np.median(strength[1])
    relative = (heights[:2, is_counted] / strength[:2])[:, is_quiet]
    relative /= np.maximum(typical_sizes(relative), 1e-9)[:, None]
    correlation = candidates[best].correlation
    found = SmoothNoise(
        float(np.exp(level)) * correlation.deviation,
        correlation,
        float(misfit),
        evenness=float(np.mean(evennesses)),
        outliers=float(np.quantile(np.abs(relative), TAIL, axis=1).max()) / NORMAL_TAIL,
        lean=leaning(relative),
        is_enough=np.count_nonzero(is_counted) >= tuned.fewest_to_tell_smooth,
        excess=float(ratios[-1] - level),
        least_evidence=tuned.least_evidence,
    )
    return with_presence(found, surface, is_counted)


def with_presence(told: SmoothNoise, surface: NoisySurface, is_counted: BoolArray) -> SmoothNoise:
    """Ask whether noise that may be told is everywhere, as noise is.

    It is in all hinges, where flat facets have none.  It is in the bands where they are low, too,
    where bent walls that were taken for noisy flat faces have less.  The presence is the geometric
    mean of both.
    """
    if not told.may_be_judged:
        return told
    frame, white = surface.frame, surface.own.noise(WHITE_NOISE)
    heights, correlation = averaged_noise(white, told.correlation.passes, frame, is_counted)
    noise = frame.raised(told.level / correlation.deviation * heights)
    found = surface.hinges.among(is_counted)
    if not len(found.value):
        return told._replace(presence=0.0)
    expected = hinges(frame.positions + noise, frame).among(is_counted)
    in_hinges = found.deviation(found.value) / max(found.deviation(expected.value), LEAST_STRENGTH)

    # The narrowest band shows the edges of the mesh, the widest the shape.
    bands, low = BANDS[1:N_NARROW], parameters().low_quantile
    of_surface, of_noise = (
        quiet_strengths(each, frame, bands, is_counted, low) for each in (surface.positions, noise)
    )
    in_bands = min(float((of_surface / of_noise).min()), 1.0)
    return told._replace(presence=float(np.sqrt(in_hinges * in_bands)))


def _of_white_noise(white: FloatArray, frame: TriangleSurface, is_counted: BoolArray) -> FloatArray:
    """Strength (k,) of the bands of white noise (n,) where it is quiet, over that of all."""
    heights = band_heights(frame.raised(white), frame)
    quiet = quiet_part(local_strengths(heights, frame, is_counted))
    return quiet / typical_sizes(heights[:, is_counted])


def levels_and_misfits(ratios: FloatArray, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mean logarithm of every noise's bands, (p, k), and the squares by which they differ, (p,)."""
    levels = np.average(ratios, axis=1, weights=weights)
    return levels, np.square(ratios - levels[:, None]) @ weights


def quiet_part(strength: FloatArray, fraction: float | None = None) -> FloatArray:
    """Strength (k,) of the bands in the quietest part of the surface, or at another fraction."""
    if fraction is None:
        fraction = parameters().quiet_fraction
    quiet: FloatArray = np.quantile(strength, fraction, axis=1)
    return quiet


def quiet_strengths(
    positions: FloatArray,
    frame: TriangleSurface,
    bands: tuple[tuple[int, int], ...],
    is_counted: BoolArray,
    fraction: float | None = None,
) -> FloatArray:
    """Strength (k,) of bands of positions (n, 3) in a quiet part of the counted vertices."""
    heights = band_heights(positions, frame, bands)
    return quiet_part(local_strengths(heights, frame, is_counted), fraction)


def least_evenness(strength: FloatArray, of_noise: FloatArray, fraction: float) -> float:
    """Least evenness of the narrow bands (k, m), relative to those of noise.

    It is the strength in the quietest part over that in a less quiet fraction of the surface.
    """

    def evenness(of_bands: FloatArray) -> FloatArray:
        narrow = of_bands[:N_NARROW]
        return quiet_part(narrow) / np.quantile(narrow, fraction, axis=1)

    return float((evenness(strength) / evenness(of_noise)).min())


def leaning(relative: FloatArray) -> float:
    """Imbalance between the hills and the valleys of bands (k, m), 0 to 1, the largest of any."""
    return float(np.abs(np.tanh(NORMAL_MEDIAN * relative).mean(axis=1)).max())


def typical_sizes(heights: FloatArray) -> FloatArray:
    """Median magnitude of every band, (k,)."""
    sizes: FloatArray = np.median(np.abs(heights), axis=1)
    return sizes


def band_heights(
    positions: FloatArray, frame: TriangleSurface, bands: tuple[tuple[int, int], ...] = BANDS
) -> FloatArray:
    """Heights of bands along the normals, (k, n)."""
    found, near, done = [], positions, 0
    for low, high in bands:
        near = frame.spread(near, low - done)
        done = low
        band = near - frame.spread(near, high - low)
        found.append(frame.along_normal(band - frame.spread(band, high)))
    return np.stack(found)


def local_strengths(
    heights: FloatArray, frame: TriangleSurface, is_counted: BoolArray
) -> FloatArray:
    """Local strength of the bands' heights (k, n) at the counted vertices, (k, m)."""
    passes = parameters().band_passes
    weight = np.maximum(frame.spread(is_counted.astype(float), passes), 1e-9)
    roots = np.where(is_counted, np.sqrt(np.abs(heights)), 0).T
    local = np.square(frame.spread(roots, passes) / weight[:, None])
    return np.maximum(local[is_counted].T, LEAST_STRENGTH)
