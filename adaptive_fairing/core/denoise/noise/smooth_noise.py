"""Noise that is alike over several edges, as that of range scanners and depth cameras.

In differences of second order it hardly shows.  In wider bands, between averages over few and over
many neighbours, it does, but so does shape.  Noise is as strong everywhere; a shape bends more here
and less there.  So the quietest tenth of the surface tells how much noise there may be in each
band, and how far it lies below the rest tells how surely it is noise.  Shapes that are as bumpy
everywhere look the same.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...runtime.arrays import BoolArray, FloatArray
from ..local_frame import LocalFrame
from ..parameters import parameters
from .correlation import NoiseCorrelation
from .noisy_surface import NoisySurface

# Passes of averaging that bound the bands, from narrow to wide.
BANDS = ((0, 1), (1, 3), (3, 8))
# Passes of averaging of white noise that are tried.
PASSES = (2, 4, 8, 16, 32)


class SmoothNoise(NamedTuple):
    """What may be smooth noise.

    Attributes
    ----------
    evenness : float
        How even the bands are over the surface, relative to noise; 0 to about 1.
    level : float
        Standard deviation in local edge lengths.
    correlation : NoiseCorrelation
    n_counted : int
        Number of vertices that it was judged from.
    """

    evenness: float
    level: float
    correlation: NoiseCorrelation
    n_counted: int

    @property
    def may_be_noise(self) -> bool:
        """Whether it is as even as noise."""
        return self.evenness >= parameters().least_evenness

    @property
    def is_likely(self) -> bool:
        """Whether it is more even, and stronger, than clean shapes are."""
        tuned = parameters()
        is_strong = self.evenness >= tuned.likely_evenness and self.level >= tuned.likely_level
        return is_strong and self.n_counted >= tuned.fewest_of_scan


def smooth_noise(surface: NoisySurface, is_counted: BoolArray) -> SmoothNoise:
    """Find the noise of several edges' width that explains the quietest part of a mesh.

    Parameters
    ----------
    surface : NoisySurface
    is_counted : (n,) bool
        Vertices to judge from, at least one.
    """
    tuned, frame, heights = parameters(), surface.frame, surface.fading.white
    white = _bands(frame.raised(heights), frame, is_counted)
    own = _bands(surface.positions, frame, is_counted)
    quiet, typical = (np.quantile(own, part, axis=1) for part in (tuned.quiet_fraction, 0.5))
    white_quiet, white_typical = (
        np.quantile(white, part, axis=1) for part in (tuned.quiet_fraction, 0.5)
    )
    evenness = float(np.min((quiet / typical / (white_quiet / white_typical))[1:]))
    best = None
    for passes in PASSES:
        noise = frame.spread(heights * frame.spacing, passes) / frame.spacing
        bands = np.median(_bands(frame.raised(noise), frame, is_counted), axis=1)
        ratios = quiet / white_quiet / (bands / white_typical)
        # All bands have at least the noise; the one with the least has no more.
        misfit = float(np.sum(np.log(ratios / ratios.min())))
        if best is None or misfit < best[0]:
            deviation = float(np.std(noise[is_counted]))
            # The level is that of the noise itself, not what second differences see of it.
            correlation = NoiseCorrelation(seen=deviation, deviation=deviation, passes=passes)
            best = misfit, float(ratios.min()) * deviation, correlation
    assert best is not None
    return SmoothNoise(evenness, best[1], best[2], int(np.count_nonzero(is_counted)))


def _bands(positions: FloatArray, frame: LocalFrame, is_counted: BoolArray) -> FloatArray:
    """Local strength of the bands along the normals at the counted vertices, (k, m)."""
    tuned = parameters()
    found = []
    weight = np.maximum(frame.spread(is_counted.astype(float), tuned.band_passes), 1e-9)
    for low, high in BANDS:
        near = frame.spread(positions, low)
        band = near - frame.spread(near, high - low)
        band = band - frame.spread(band, high)
        root = np.where(is_counted, np.sqrt(np.abs(frame.along_normal(band))), 0)
        found.append(np.square(frame.spread(root, tuned.band_passes) / weight)[is_counted])
    return np.maximum(np.stack(found), 1e-12)
