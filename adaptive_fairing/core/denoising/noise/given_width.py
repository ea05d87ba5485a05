"""Noise of a given width: its correlation is known, and only its level is estimated.

Noise of width w has the correlation exp(-r² / w²) at a distance of r edges.  White noise has it
after w² passes, each of which averages half with the neighbours.

The contrasts that see such noise best are differences between averages that are narrower than it,
and heights over flat faces.  Each is an upper bound of the level, as always (`noise.contrast`):
shape and finer noise only add to it.  There is no other test: noise of a given width is not
questioned.
"""

from __future__ import annotations

import numpy as np

from ...runtime.arrays import BoolArray, FloatArray
from ..noise_model import NoiseCorrelation
from ..parameters import parameters
from ..triangle_surface import TriangleSurface
from .face_noise import FaceNoise
from .noisy_surface import NoisySurface
from .smooth_noise import band_height


def noise_of_width(
    noisy: NoisySurface, on_faces: FaceNoise, is_counted: BoolArray, width: float
) -> tuple[FloatArray, NoiseCorrelation]:
    """Level (n,) and correlation of the noise if all of it has one width.

    Parameters
    ----------
    noisy : NoisySurface
    on_faces : FaceNoise
        Deviations from flat faces: on a plane there is no shape.
    is_counted : (n,) bool
        Vertices to judge from.
    width : float
        Distance in edges at which the correlation is 1 / e; 1 for white noise.
    """
    frame, passes = noisy.frame, passes_of_width(width)
    level = np.zeros(len(is_counted))
    if not is_counted.any():
        return level, NoiseCorrelation(passes=passes)
    noise = NoiseCorrelation(passes=passes).applied(noisy.fading.white, frame)
    deviation = float(np.std(noise[is_counted]))
    size = _least_size(noisy, noise / deviation, is_counted, passes)
    if on_faces.part >= parameters().least_flat:
        size = min(size, on_faces.level)
    level[is_counted] = size
    return level, NoiseCorrelation(seen=deviation, deviation=deviation, passes=passes)


def passes_of_width(width: float) -> int:
    """Count the averages half with the neighbours that give white noise a width in edges."""
    return round(width**2) if width > 1 else 0


def _least_size(noisy: NoisySurface, noise: FloatArray, counted: BoolArray, passes: int) -> float:
    """Least standard deviation, in local edge lengths, that the contrasts allow for a noise.

    The noise (n,) is given with a standard deviation of 1.
    """
    frame = noisy.frame
    found, expected = (
        [np.median(np.abs(each[counted])) for each in _bands(positions, frame, passes)]
        for positions in (noisy.positions, frame.raised(noise))
    )
    narrow, wide = np.array(found) / np.maximum(expected, 1e-12)
    # Both bands have all of the noise, and the narrow one this part of what the wide has of shape.
    of_shape = parameters().narrow_of_shape ** 2
    variance = max((narrow**2 - of_shape * wide**2) / (1 - of_shape), 0.0)
    least = parameters().least_of_narrow * narrow
    return float(max(np.sqrt(variance), least))


def _bands(
    positions: FloatArray, frame: TriangleSurface, passes: int
) -> tuple[FloatArray, FloatArray]:
    """Heights (n,) of a band narrower than noise of some passes, and of a wider band."""
    typical = max(passes, 1)
    bounds = (passes // 4, max(1, passes // 2)), (typical, 2 * typical)
    narrow, wide = (band_height(positions, frame, low, high) for low, high in bounds)
    return narrow, wide
