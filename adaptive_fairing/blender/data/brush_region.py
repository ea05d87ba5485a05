"""Region under a brush: the vertices in a ball, within a face set, where nothing is hidden."""

from __future__ import annotations

from typing import NamedTuple

import bpy
import numpy as np
from numpy.typing import NDArray

from .attribute_arrays import read_or_zeros
from .mesh_arrays import read_mesh_coordinates
from .mesh_building import integers

FACE_SET = ".sculpt_face_set"
FULL_PART = 0.5
"""Fraction of the radius within which the weight is 1; from there it falls to 0."""


class BrushRegion(NamedTuple):
    """A ball in object space, and the polygon that was pointed at."""

    centre: tuple[float, float, float]
    radius: float
    polygon: int

    def weights(self, mesh: bpy.types.Mesh) -> NDArray[np.float64]:
        """Weights (n,) in [0, 1] of the vertices of a mesh in Object Mode."""
        away = read_mesh_coordinates(mesh) - np.float32(self.centre)
        rest = (1 - np.linalg.norm(away, axis=1).astype(np.float64) / self.radius) / (1 - FULL_PART)
        rest = np.clip(rest, 0.0, 1.0)
        weights = rest**2 * (3 - 2 * rest)
        weights[self._is_beyond(mesh)] = 0.0
        return weights

    def _is_beyond(self, mesh: bpy.types.Mesh) -> NDArray[np.bool_]:
        """Whether each vertex is hidden or has a face of another face set, (n,)."""
        is_beyond = read_or_zeros(mesh, ".hide_vert", len(mesh.vertices), bool)
        if FACE_SET in mesh.attributes and self.polygon < len(mesh.polygons):
            face_set = integers(mesh.attributes[FACE_SET].data, "value", 1)
            corner_set = np.repeat(face_set, integers(mesh.polygons, "loop_total", 1))
            corners = integers(mesh.attributes[".corner_vert"].data, "value", 1)
            is_beyond[corners[corner_set != face_set[self.polygon]]] = True
        return is_beyond
