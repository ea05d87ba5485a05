"""Decay of roughness in differences of higher order, by which shape differs from white noise.

White noise has the same strength in differences with the neighbours' mean of every order.  Shape
fades in the higher orders, faster if it is smoother.  So do the staircases of contoured volumes,
like white noise that was mixed with the mean of the neighbours' noise.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ...runtime.arrays import BoolArray, FloatArray
from ..noise_model import WHITE, NoiseCorrelation
from ..parameters import parameters
from ..triangle_surface import TriangleSurface

# Orders of the differences that are compared.
LOW, HIGH = 2, 5

# Number of coefficients of the neighbours' mean that are tried; the first is 0, for white noise.
N_TRIED = 8


class Fading:
    """Differences of a mesh and of white noise on it.

    Parameters
    ----------
    positions : (n, 3)
    frame : TriangleSurface
    white : (n,)
        The white noise along the normals, in local edge lengths.
    """

    def __init__(self, positions: FloatArray, frame: TriangleSurface, white: FloatArray) -> None:
        self.white = white
        self._positions, self._frame = positions, frame

    def fades(self, is_counted: BoolArray) -> bool:
        """Whether the roughness of vertices, (n,) bool, fades more than that of white noise."""
        tuned = parameters()
        _, kept = self.of_mesh(is_counted)
        chance = tuned.fading_deviations / np.sqrt(np.count_nonzero(is_counted))
        return kept < min(tuned.fading_kept, tuned.white_kept - chance)

    def of_mesh(self, is_counted: BoolArray) -> tuple[float, float]:
        """Roughness in low order relative to white noise, and the fraction left in high order."""
        return self._compared(self._of_mesh, is_counted)

    def correlation(self, is_counted: BoolArray) -> NoiseCorrelation:
        """Find the correlation of noise that fades like the roughness of the mesh.

        From vertices, (n,) bool, at least one.
        """
        tuned = parameters()
        rough, kept = self.of_mesh(is_counted)
        if rough < tuned.least_roughness or not self.fades(is_counted):
            return WHITE
        coefficients = np.linspace(0, tuned.most_correlation, N_TRIED)
        rows = [(1.0, 1.0, np.std(self.white[is_counted]))]
        for coefficient in coefficients[1:]:
            noise = NoiseCorrelation(coefficient).applied(self.white, self._frame)
            differences = _differences(self._frame.raised(noise), self._frame)
            rows.append((*self._compared(differences, is_counted), np.std(noise[is_counted])))
        seen, kept_of_noise, deviation = np.array(rows).T
        found = float(np.interp(-kept, -np.minimum.accumulate(kept_of_noise), coefficients))
        return NoiseCorrelation(
            found,
            float(np.interp(found, coefficients, seen)),
            float(np.interp(found, coefficients, deviation)),
        )

    # Not needed for a mesh that is clean at first sight.
    @cached_property
    def _of_mesh(self) -> FloatArray:
        return _differences(self._positions, self._frame)

    @cached_property
    def _of_white(self) -> FloatArray:
        return _differences(self._frame.raised(self.white), self._frame)

    def _compared(self, differences: FloatArray, is_counted: BoolArray) -> tuple[float, float]:
        low, high = np.median(differences[:, is_counted], axis=1)
        white_low, white_high = np.median(self._of_white[:, is_counted], axis=1)
        # A surface without roughness does not fade.
        kept = (high / low) / (white_high / white_low) if low > 0 else 1.0
        return float(low / white_low), float(kept)


def _differences(values: FloatArray, frame: TriangleSurface) -> FloatArray:
    """Magnitudes of the normal parts of differences of low and high order, (2, n)."""
    found = []
    for order in range(1, HIGH + 1):
        values = values - frame.mean @ values
        if order in (LOW, HIGH):
            found.append(np.abs(frame.along_normal(values)))
    return np.stack(found)
