"""Noise of a given width: its correlation is known, and only its level is estimated.

Noise of width w has the correlation exp(-r² / w²) at a distance of r edges.  White noise has it
after w² passes, each of which averages half with the neighbours.

The contrasts that see such noise best are differences between averages that are narrower than it,
and heights over flat faces.  Each is an upper bound of the level, as always (`noise.contrast`):
shape and finer noise only add to it.  As in `smooth_noise` the level is read where the surface is
quiet, for there is the least of shape.  There is no other test: noise of a given width is not
questioned.
"""

from __future__ import annotations

import numpy as np

from ...runtime.arrays import BoolArray, FloatArray
from ..noise_model import NoiseCorrelation
from ..parameters import parameters
from .face_noise import FaceNoise
from .noisy_surface import NoisySurface
from .smooth_noise import LEAST_STRENGTH, band_heights, local_strengths, quiet_part


def noise_of_width(
    noisy: NoisySurface, on_faces: FaceNoise, is_counted: BoolArray, width: float
) -> tuple[float, NoiseCorrelation]:
    """Level, in the surface's unit of length, and correlation of noise if all of it has one width.

    Parameters
    ----------
    noisy : NoisySurface
    on_faces : FaceNoise
        Deviations from flat faces: on a plane there is no shape.
    is_counted : (n,) bool
        Vertices to judge from, several.
    width : float
        Distance in edges at which the correlation is 1 / e; 1 for white noise.
    """
    frame, passes = noisy.frame, passes_of_width(width)
    noise = NoiseCorrelation(passes=passes).applied(noisy.fading.white, frame)
    deviation = float(np.std(noise[is_counted]))
    level = _least_level(noisy, noise / deviation, is_counted, passes)
    if on_faces.part >= parameters().least_flat:
        level = min(level, on_faces.level)
    return level, NoiseCorrelation(seen=deviation, deviation=deviation, passes=passes)


def passes_of_width(width: float) -> int:
    """Count the averages half with the neighbours that give white noise a width in edges."""
    return round(width**2) if width > 1 else 0


def _least_level(noisy: NoisySurface, noise: FloatArray, counted: BoolArray, passes: int) -> float:
    """Least standard deviation that a band narrower than a noise and one as wide allow for it.

    The noise (n,) is given with a standard deviation of 1.
    """
    tuned, frame, typical = parameters(), noisy.frame, max(passes, 1)
    bounds = (passes // 4, max(1, passes // 2)), (typical, 2 * typical)
    found, expected = (
        quiet_part(local_strengths(band_heights(positions, frame, bounds), frame, counted))
        for positions in (noisy.positions, frame.raised(noise))
    )
    narrow, wide = np.where(found > LEAST_STRENGTH, found, 0) / expected
    # Both bands have all of the noise, and the narrow one this part of what the wide has of shape.
    of_shape = tuned.narrow_of_shape**2
    variance = max((narrow**2 - of_shape * wide**2) / (1 - of_shape), 0.0)
    return float(max(np.sqrt(variance), tuned.least_of_narrow * narrow))
