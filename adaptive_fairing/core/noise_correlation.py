"""How much the noise of neighbouring vertices is alike, told from the mesh alone.

White noise shows with the same strength in every difference with the neighbours' mean, of whatever
order.  The staircases of contoured volumes fade in the higher ones: they are like white noise that
was averaged with the neighbours' once.  Noise that is smooth over several edges cannot be told from
shape, and is not sought.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .local_frame import LocalFrame

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

# Orders of the differences that are compared.
LOW, HIGH = 2, 5

# Noise that fades no further than this from the low to the high order counts as white; measured
# for white noise on many shapes: 0.91 to 1.05, for staircases: 0.71 to 0.85.
WHITE_FADING = 0.88

# Roughness of less than so many edge lengths that fades is taken for shape, which fades as well.
# Contoured voxels measure 0.13 to 0.18.
LEAST_ROUGHNESS = 0.11

# Shares of the neighbours' mean that are tried; the first is white noise.
SHARES = np.linspace(0, 0.9, 10)
NOISE_SEED = 1


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
    """

    share: float = 0.0
    seen: float = 1.0
    deviation: float = 1.0

    def applied(self, values: FloatArray, frame: LocalFrame) -> FloatArray:
        """Give white noise (n,), in local edge lengths, this correlation."""
        if self.share == 0:
            return values
        mean: FloatArray = (frame.mean @ (values * frame.spacing)) / frame.spacing
        return (1 - self.share) * values + self.share * mean


def noise_correlation(
    positions: FloatArray, frame: LocalFrame, is_counted: BoolArray
) -> NoiseCorrelation:
    """Find the correlation with which noise fades as positions (n, 3) do.

    Parameters
    ----------
    positions : (n, 3)
    frame : LocalFrame
    is_counted : (n,) bool
        Vertices to judge from, at least one.
    """
    white = np.random.default_rng(NOISE_SEED).normal(size=len(positions))

    def strengths(values: FloatArray) -> FloatArray:
        """Median differences of low and high order, (2,)."""
        found = []
        for order in range(1, HIGH + 1):
            values = values - frame.mean @ values
            if order in (LOW, HIGH):
                normal_part = frame.along_normal(values)
                found.append(np.median(np.abs(normal_part[is_counted])))
        return np.array(found)

    low, high = strengths(positions)
    white_low, white_high = strengths(frame.raised(white))
    if low < LEAST_ROUGHNESS * white_low:
        return NoiseCorrelation()
    fading = (high / low) / (white_high / white_low)
    if fading > WHITE_FADING:
        return NoiseCorrelation()
    rows = [(1.0, 1.0, np.std(white[is_counted]))]
    for share in SHARES[1:]:
        noise = NoiseCorrelation(share).applied(white, frame)
        noise_low, noise_high = strengths(frame.raised(noise))
        own_fading = (noise_high / noise_low) / (white_high / white_low)
        rows.append((own_fading, noise_low / white_low, np.std(noise[is_counted])))
    fadings, seen, deviation = np.array(rows).T
    # Fading deepens with the share, until most of the noise is mean; no share beyond is sought.
    deepest = int(np.argmin(fadings)) + 1
    share = float(np.interp(-fading, -fadings[:deepest], SHARES[:deepest]))
    return NoiseCorrelation(
        share, float(np.interp(share, SHARES, seen)), float(np.interp(share, SHARES, deviation))
    )
