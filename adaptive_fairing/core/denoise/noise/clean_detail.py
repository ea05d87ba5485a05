"""Detail of clean meshes that the noise level takes for noise."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ...mesh.topology import TriangleTopology
from ...runtime.arrays import BoolArray, FloatArray
from ..local_frame import LocalFrame
from .correlation import LEAST_ROUGHNESS
from .level import CLEAN_ROUGHNESS, beyond_clean
from .line_roughness import LineRoughness
from .order_decay import Fading

# A mesh with creases everywhere is clean if along them it is no rougher than clean meshes are, and
# this share of its vertices no rougher than this, in local edge lengths of noise.
SMOOTH_SHARE, CORNER_ROUGHNESS = 0.9, 0.3


class CleanDetail:
    """What tells the detail of a clean mesh from noise.

    Parameters
    ----------
    topology : TriangleTopology
    positions : (n, 3)
    frame : LocalFrame
    fading : Fading
    """

    def __init__(
        self,
        topology: TriangleTopology,
        positions: FloatArray,
        frame: LocalFrame,
        fading: Fading,
    ) -> None:
        self._topology, self._positions, self._frame = topology, positions, frame
        self._fading = fading

    def without(self, level: FloatArray, is_counted: BoolArray) -> FloatArray:
        """Return the noise level (n,) of some vertices, (n,) bool, or what clean meshes have."""
        if not beyond_clean(level).any():
            return level
        along_lines = self._lines.level(is_counted)
        # Creases everywhere look like noise to the level; along them all may be smooth, but for the
        # few places where they meet.  Contoured voxels have more of these.
        is_smooth = along_lines <= CLEAN_ROUGHNESS
        if is_smooth and self._lines.level(is_counted, SMOOTH_SHARE) <= CORNER_ROUGHNESS:
            return np.minimum(level, along_lines)
        # Detail as fine as the mesh fades a little, while white noise does not.
        rough, _ = self._fading.of_mesh(is_counted)
        if rough < LEAST_ROUGHNESS and self._fading.fades(is_counted):
            return np.minimum(level, CLEAN_ROUGHNESS)
        return level

    @cached_property
    def _lines(self) -> LineRoughness:
        return LineRoughness(self._topology, self._positions, self._frame)
