"""Noise of a width that the user has told: its level, and whether it is narrower than told.

Whether it is noise is not questioned.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from ...runtime.arrays import BoolArray, FloatArray
from ..noise_model import NoiseCorrelation, averaged_noise
from ..parameters import parameters
from .noisy_surface import NoisySurface
from .own_numbers import WHITE_NOISE
from .smooth_noise import (
    LEAST_STRENGTH,
    SmoothNoise,
    levels_and_misfits,
    quiet_strengths,
)

# Passes that are tried for noise of a given width, over those of that width: down to 0.65 of it.
PARTS_OF_PASSES = (1.0, 0.75, 0.56, 0.42)
# Weight of the narrowest band in that fit: finer noise and rounded depths show there as well.
WEIGHT_OF_NARROWEST = 0.25

# Parts of a band's variance that are tried as that of the noise.
N_PARTS = 200


def noise_of_width(
    noisy: NoisySurface, on_faces: SmoothNoise | None, is_counted: BoolArray, width: float
) -> tuple[float, NoiseCorrelation]:
    """Level, in the surface's unit of length, and correlation of noise of about a given width.

    Noise of width w has the correlation exp(-r² / w²) at a distance of r edges.  A user tells it
    roughly, and noise that is narrower than assumed seems much stronger than it is.  So the noise
    is as wide as fits best, from 0.65 of the given width on, or white.

    The contrasts that see it best are heights over flat faces, and differences between averages
    that are narrower than it or as wide.  Shape adds to these.  So much of them is noise as is
    likely for noise and shape of usual sizes.  The lesser of both is the level: whether it is noise
    is not questioned.

    Parameters
    ----------
    noisy : NoisySurface
    on_faces : SmoothNoise, optional
        Deviations from flat faces, if there are any: on a plane there is no shape.
    is_counted : (n,) bool
        Vertices to judge from, several.
    width : float
        Distance in edges at which the correlation is about 1 / e; 1 for white noise.
    """
    passes = _likeliest_passes(noisy, is_counted, passes_of_width(width))
    white = noisy.own.noise(WHITE_NOISE)
    noise, correlation = averaged_noise(white, passes, noisy.frame, is_counted)
    level = _likely_level(noisy, noise / correlation.deviation, is_counted, passes)
    if on_faces is not None:
        level = min(level, on_faces.level)
    return level, correlation


def passes_of_width(width: float) -> int:
    """Count the averages half with the neighbours that give white noise a width in edges."""
    return round(width**2) if width > 1 else 0


def _likeliest_passes(noisy: NoisySurface, is_counted: BoolArray, most: int) -> int:
    """Count the averages that give noise whose bands fit best, at most as many as for the width."""
    if most == 0:
        return 0
    frame, white = noisy.frame, noisy.own.noise(WHITE_NOISE)
    bands = tuple(pairwise(sorted({most // 8, most // 4, most // 2, most})))
    weights = np.ones(len(bands))
    weights[0] = WEIGHT_OF_NARROWEST
    found = quiet_strengths(noisy.positions, frame, bands, is_counted)

    def ratios(passes: int) -> FloatArray:
        noise, _ = averaged_noise(white, passes, frame, is_counted)
        return np.log(found / quiet_strengths(frame.raised(noise), frame, bands, is_counted))

    tried = np.unique([0, *(round(part * most) for part in PARTS_OF_PASSES)])
    _, misfits = levels_and_misfits(np.stack([ratios(passes) for passes in tried]), weights)
    likeliest = int(np.argmin(misfits))
    if likeliest == 0 or len(tried) < 4:
        return int(tried[likeliest])
    # A parabola through three numbers besides that of white noise refines it.
    middle = min(max(likeliest, 2), len(tried) - 2)
    near = slice(middle - 1, middle + 2)
    square, slope, _ = np.polyfit(np.log(tried[near]), misfits[near], 2)
    if square <= 0:
        return most
    best = float(np.exp(np.clip(-slope / (2 * square), *np.log(tried[[1, -1]]))))
    # With two passes noise seems far weaker than with three: rather one too many.
    return max(round(best), min(math.ceil(best), 3))


def _likely_level(
    noisy: NoisySurface, noise: FloatArray, is_counted: BoolArray, passes: int
) -> float:
    """Mean of the levels that are likely for a noise, from two bands that have shape as well.

    One band is narrower than the noise, one as wide.  The variance of both is that of the noise and
    of the shape.  The noise, the shape, and its growth from band to band have usual sizes, from
    which they differ by a factor of e or so.

    The noise (n,) is given with a standard deviation of 1, averaged by a number of passes.
    """
    tuned, frame, typical = parameters(), noisy.frame, max(passes, 1)
    bands = (passes // 4, max(1, passes // 2)), (typical, 2 * typical)
    found, expected = (
        quiet_strengths(positions, frame, bands, is_counted)
        for positions in (noisy.positions, frame.raised(noise))
    )
    if found.min() <= LEAST_STRENGTH:
        return 0.0
    sizes = found / expected
    # Finer noise adds to the narrow band alone.
    sizes[1] = sizes.max()
    part = (np.arange(N_PARTS) + 0.5) / N_PARTS
    level = sizes[0] * np.sqrt(part)
    narrow, wide = np.sqrt(np.square(sizes)[:, None] - np.square(level))
    # Shape goes with the squared width of a band, which is that of its passes, and with the length
    # of the edges: n vertices over the same shape make them as long as 1 / √n.
    usual_shape = tuned.usual_bend * typical / np.sqrt(np.count_nonzero(is_counted))
    usual_growth = bands[1][1] / bands[0][1] * expected[0] / expected[1]
    factors = level / tuned.usual_noise, narrow / usual_shape, wide / narrow / usual_growth
    unlikely = np.square(np.log(factors)).sum(axis=0)
    # Equal steps of the variance are no equal steps of the logarithms.
    odds = np.exp((unlikely.min() - unlikely) / 2) / (part * np.square(narrow * wide))
    return float(np.average(level, weights=odds))
