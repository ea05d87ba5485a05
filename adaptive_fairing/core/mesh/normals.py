"""Normals of triangles and of vertices."""

from __future__ import annotations

import numpy as np

from ..runtime.arrays import FloatArray, IntArray
from .topology import TriangleTopology


def triangle_normals(positions: FloatArray, triangles: IntArray) -> FloatArray:
    """Compute the normals of triangles (m, 3), as long as twice their area, (m, 3)."""
    corners = positions[triangles]
    normals: FloatArray = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return normals


def vertex_normals(topology: TriangleTopology, positions: FloatArray) -> FloatArray:
    """Average the normals of the triangles around by area; unit vectors, (n, 3), 0 without any."""
    by_area = triangle_normals(positions, topology.triangles)
    corners = topology.triangles.T.reshape(-1)
    sums = [np.bincount(corners, np.tile(x, 3), topology.n_vertices) for x in by_area.T]
    return unit_vectors(np.stack(sums, axis=1))


def unit_vectors(vectors: FloatArray) -> FloatArray:
    """Divide vectors (n, 3) by their lengths; those of length 0 stay."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    units: FloatArray = vectors / np.where(lengths > 0, lengths, 1)
    return units
