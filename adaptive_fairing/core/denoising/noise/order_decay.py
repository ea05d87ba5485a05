"""Decay of roughness in differences of higher order, by which shape differs from white noise.

White noise has the same strength in differences with the neighbours' mean of every order.  Shape
fades in the higher orders, faster if it is smoother.  So do the staircases of contoured volumes,
which are like white noise after one average with the neighbours.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ...runtime.arrays import BoolArray, FloatArray
from ..parameters import parameters
from ..triangle_surface import TriangleSurface

# Orders of the differences that are compared.
LOW, HIGH = 2, 5


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

    def of_noise(self, noise: FloatArray, is_counted: BoolArray) -> tuple[float, float]:
        """Return the same two numbers for noise (n,) along the normals, in local edge lengths."""
        return self._compared(_differences(self._frame.raised(noise), self._frame), is_counted)

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
        # What is not rough at all does not fade.
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
