"""Correlation of noise, as white noise mixed with the mean of the neighbours' noise."""

from __future__ import annotations

from typing import NamedTuple

from ..runtime.arrays import FloatArray
from .triangle_surface import TriangleSurface


class NoiseCorrelation(NamedTuple):
    """White noise that was mixed with the mean of the neighbours' noise.

    Attributes
    ----------
    coefficient : float
        c of the neighbours' mean in (1 - c) w + c mean(w), with white noise w; 0 for white noise.
    seen : float
        Strength of differences of second order, relative to those of the white noise.
    deviation : float
        Standard deviation relative to that of the white noise.
    passes : int
        Number of averages half with the neighbours' mean, for noise smooth over several edges.
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
"""Noise without correlation between neighbours."""
