"""Solids of many flat facets that meet at small angles."""

from __future__ import annotations

import numpy as np

from tools.geometry.triangles import convex_hull, triangle_areas

from .meshing import MeshArrays, remeshed

LEAST_CREASE = 8.0
"""Edges bent by more than this many degrees are kept."""


def polyhedron(n_corners: int, n_vertices: int, seed: int) -> MeshArrays:
    """Return a convex solid with random corners on a sphere, and even triangles on its facets."""
    corners = np.random.default_rng(seed).normal(size=(n_corners, 3))
    vertices, faces = convex_hull(corners / np.linalg.norm(corners, axis=1, keepdims=True))
    area = triangle_areas(vertices, faces).sum()
    # Two triangles for each vertex, of √3 / 4 squared edges.
    edge = np.sqrt(area / (2 * n_vertices) * 4 / np.sqrt(3))
    return remeshed(vertices, faces, edge, LEAST_CREASE)
