"""Noise along the vertex normals, as strong as the mesh is coarse."""

from __future__ import annotations

import numpy as np

from .triangles import Faces, FloatArray, local_edge_lengths, vertex_normals


def add_noise(vertices: FloatArray, triangles: Faces, strength: float, seed: int) -> FloatArray:
    """Return the vertices (n, 3) moved along their normals by seeded Gaussian noise.

    The standard deviation is `strength` times the mean length of the vertex's edges; moves
    beyond 2.5 standard deviations are cut, so that no triangle turns over.
    """
    amount = np.random.default_rng(seed).standard_normal(len(vertices)).clip(-2.5, 2.5)
    height = strength * local_edge_lengths(vertices, triangles) * amount
    return vertices + height[:, None] * vertex_normals(vertices, triangles)
