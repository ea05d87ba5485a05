"""Model of the noise: how strong it is where, how alike at neighbours, and how certain.

The variance law has two terms, noise that grows with the edges and noise of one amplitude.  Smooth
noise is white noise that was mixed with the mean of the neighbours' noise.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..runtime.arrays import BoolArray, FloatArray
from .parameters import parameters
from .triangle_surface import TriangleSurface

# What is near to a limit counts less, from 1 - 1 / FADING of it on: else rounding would decide.
FADING = 3


def certainty(parts: FloatArray) -> FloatArray:
    """How much what comes to these parts of a limit counts, (k,): 0 at the limit and beyond."""
    weights: FloatArray = np.clip(FADING * (1 - parts), 0, 1)
    return weights


class VarianceLaw(NamedTuple):
    """Noise that grows with the edges, or has one amplitude, or both.

    Attributes
    ----------
    per_edge, per_length : float
        a ≥ 0 and b ≥ 0 of the variance a + b / h² in squared local edge lengths.
    """

    per_edge: float
    per_length: float

    def level(self, spacing: FloatArray) -> FloatArray:
        """Return the standard deviation in local edge lengths where the edges are h long, (n,)."""
        return np.sqrt(self.per_edge + self.per_length / np.square(spacing))

    def noise(self, spacing: FloatArray) -> FloatArray:
        """Return the level (n,) without the roughness of clean meshes.

        That grows with the edges, so it is a part of a alone.
        """
        variance = np.square(self.level(spacing))
        share = self.per_edge / np.maximum(variance, np.finfo(float).tiny)
        clean = share * parameters().clean_roughness ** 2
        noise: FloatArray = np.maximum(variance**2 - clean**2, 0) ** 0.25
        return noise

    def expected(self, fineness: FloatArray) -> FloatArray:
        """Return the standard deviation that contrasts of a fineness (k,) have, (k,)."""
        return np.sqrt(self.per_edge + self.per_length * fineness)


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

    @property
    def of_neighbours(self) -> float:
        """Correlation of smooth noise at neighbours.

        Averages half with the neighbours spread the noise of a vertex like a normal distribution,
        whose variance grows by a quarter of a squared edge with each of them.
        """
        return float(np.exp(-1 / self.passes)) if self.passes else 0.0

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


def averaged_noise(
    white: FloatArray, passes: int, frame: TriangleSurface, is_counted: BoolArray
) -> tuple[FloatArray, NoiseCorrelation]:
    """Average white noise (n,), and measure at vertices, (n,) bool, what is left of it.

    Wide noise is seen as it is, not by second differences.
    """
    noise = NoiseCorrelation(passes=passes).applied(white, frame)
    left = float(np.std(noise[is_counted]))
    return noise, NoiseCorrelation(seen=left, deviation=left, passes=passes)
