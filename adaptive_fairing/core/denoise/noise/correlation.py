"""How much the noise of neighbouring vertices is alike, told from the mesh alone.

Staircases fade in differences of higher order (`fading`) as white noise does of which a share was
replaced by the mean of the neighbours'.  Noise that is smooth over several edges cannot be told
from shape, and is not sought.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...runtime.arrays import BoolArray, FloatArray
from ..local_frame import LocalFrame
from .order_decay import Fading

# Roughness of less than so many edge lengths that fades is shape, which fades as well.  Contoured
# voxels measure 0.13 to 0.18.
LEAST_ROUGHNESS = 0.11

# Shares of the neighbours' mean that are tried; the first is white noise.  Contoured voxels fade as
# with 0.55 to 0.63, but the shape's own fading is in it: more than the last share is not believed.
SHARES = np.linspace(0, 0.56, 8)


class NoiseCorrelation(NamedTuple):
    """Noise as white noise of which a share was replaced by the mean of the neighbours' noise.

    Attributes
    ----------
    share : float
        0 for white noise.
    seen : float
        How strong differences of second order are, relative to those of the white noise.
    deviation : float
        Standard deviation relative to that of the white noise.
    passes : int
        Of averaging half with the neighbours' mean, for noise that is smooth over several edges.
    """

    share: float = 0.0
    seen: float = 1.0
    deviation: float = 1.0
    passes: int = 0

    def applied(self, values: FloatArray, frame: LocalFrame) -> FloatArray:
        """Give white noise (n,), in local edge lengths, this correlation."""
        if self.passes:
            return frame.spread(values * frame.spacing, self.passes) / frame.spacing
        if self.share == 0:
            return values
        mean: FloatArray = (frame.mean @ (values * frame.spacing)) / frame.spacing
        return (1 - self.share) * values + self.share * mean


def noise_correlation(fading: Fading, frame: LocalFrame, is_counted: BoolArray) -> NoiseCorrelation:
    """Find the correlation with which noise fades as the mesh does.

    Parameters
    ----------
    fading : Fading
        Of the mesh.
    frame : LocalFrame
    is_counted : (n,) bool
        Vertices to judge from, at least one.
    """
    rough, kept = fading.of_mesh(is_counted)
    if rough < LEAST_ROUGHNESS or not fading.fades(is_counted):
        return NoiseCorrelation()
    rows = [(1.0, 1.0, np.std(fading.white[is_counted]))]
    for share in SHARES[1:]:
        noise = NoiseCorrelation(share).applied(fading.white, frame)
        rows.append((*fading.of_noise(noise, is_counted), np.std(noise[is_counted])))
    seen, kept_by_share, deviation = np.array(rows).T
    share = float(np.interp(-kept, -np.minimum.accumulate(kept_by_share), SHARES))
    return NoiseCorrelation(
        share, float(np.interp(share, SHARES, seen)), float(np.interp(share, SHARES, deviation))
    )
