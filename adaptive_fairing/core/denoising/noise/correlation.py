"""Correlation of the noise at neighbouring vertices, estimated from the mesh alone.

Staircases fade in differences of higher order (`order_decay`) like white noise that was mixed with
the mean of the neighbours' noise.  Noise that is smooth over several edges cannot be distinguished
from shape here, and is not looked for.
"""

from __future__ import annotations

import numpy as np

from ...runtime.arrays import BoolArray
from ..noise_correlation import WHITE, NoiseCorrelation
from ..parameters import parameters
from .noisy_surface import NoisySurface

# Number of coefficients of the neighbours' mean that are tried; the first is 0, for white noise.
N_TRIED = 8


def noise_correlation(surface: NoisySurface, is_counted: BoolArray) -> NoiseCorrelation:
    """Find the correlation of noise that fades like the roughness of the mesh.

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
