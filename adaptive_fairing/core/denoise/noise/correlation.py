"""The correlation of the noise at neighbouring vertices, estimated from the mesh alone.

Staircases fade in differences of higher order (`order_decay`) as white noise does that was mixed
with the mean of the neighbours' noise.  Noise that is smooth over several edges cannot be told
from shape, and is not sought.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...runtime.arrays import BoolArray, FloatArray
from ..parameters import parameters
from ..triangle_surface import TriangleSurface
from .noisy_surface import NoisySurface

# Number of coefficients of the neighbours' mean that are tried; the first is 0, for white noise.
N_TRIED = 8


class NoiseCorrelation(NamedTuple):
    """White noise that was mixed with the mean of the neighbours' noise.

    Attributes
    ----------
    coefficient : float
        c of the neighbours' mean in (1 - c) w + c mean(w), with white noise w; 0 for white noise.
    seen : float
        How strong differences of second order are, relative to those of the white noise.
    deviation : float
        Standard deviation relative to that of the white noise.
    passes : int
        Of averaging half with the neighbours' mean, for noise that is smooth over several edges.
    """

    coefficient: float = 0.0
    seen: float = 1.0
    deviation: float = 1.0
    passes: int = 0

    def applied(self, values: FloatArray, frame: TriangleSurface) -> FloatArray:
        """Give white noise (n,), in local edge lengths, this correlation."""
        if self.passes:
            return frame.spread(values * frame.spacing, self.passes) / frame.spacing
        if self.coefficient == 0:
            return values
        mean: FloatArray = (frame.mean @ (values * frame.spacing)) / frame.spacing
        return (1 - self.coefficient) * values + self.coefficient * mean


WHITE = NoiseCorrelation()
"""Noise that neighbours have nothing of in common."""


def noise_correlation(surface: NoisySurface, is_counted: BoolArray) -> NoiseCorrelation:
    """Find the correlation with which noise fades as the mesh does.

    Parameters
    ----------
    surface : NoisySurface
    is_counted : (n,) bool
        Vertices to judge from, at least one.
    """
    tuned, fading = parameters(), surface.fading
    rough, kept = fading.of_mesh(is_counted)
    if rough < tuned.least_roughness or not fading.fades(is_counted):
        return WHITE
    coefficients = np.linspace(0, tuned.most_correlation, N_TRIED)
    rows = [(1.0, 1.0, np.std(fading.white[is_counted]))]
    for coefficient in coefficients[1:]:
        noise = NoiseCorrelation(coefficient).applied(fading.white, surface.frame)
        rows.append((*fading.of_noise(noise, is_counted), np.std(noise[is_counted])))
    seen, kept_of_noise, deviation = np.array(rows).T
    found = float(np.interp(-kept, -np.minimum.accumulate(kept_of_noise), coefficients))
    return NoiseCorrelation(
        found,
        float(np.interp(found, coefficients, seen)),
        float(np.interp(found, coefficients, deviation)),
    )
