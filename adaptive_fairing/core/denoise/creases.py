"""Creases of a mesh: inner edges where its triangles meet at an angle."""

from __future__ import annotations

import numpy as np

from ..mesh.normals import triangle_normals, unit_vectors
from ..mesh.topology import TriangleTopology
from ..runtime.arrays import FloatArray
from .parameters import parameters


def crease_part(topology: TriangleTopology, positions: FloatArray) -> float:
    """Measure which part of the inner edges of a mesh with positions (n, 3) are creases, 0 to 1."""
    normal = unit_vectors(triangle_normals(positions, topology.triangles))
    side = np.flatnonzero(topology.twin >= 0)
    cosine = np.einsum("ed,ed->e", normal[side // 3], normal[topology.twin[side] // 3])
    return float(np.mean(cosine < np.cos(parameters().crease_angle))) if len(side) else 0.0


def has_creases(topology: TriangleTopology, positions: FloatArray) -> bool:
    """Whether enough inner edges are creases for the filters that sharpen them to be worth it."""
    return crease_part(topology, positions) > parameters().fewest_creases
