"""Edges, angles and normals of closed triangle meshes; numpy only."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Faces = NDArray[np.int32]


def edges_of(triangles: Faces) -> NDArray[np.int32]:
    """Return the edges (k, 2) of a closed mesh, each once, smaller index first."""
    pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    return np.unique(np.sort(pairs, axis=1), axis=0)


def edge_lengths(vertices: FloatArray, triangles: Faces) -> FloatArray:
    """Return the length of every edge."""
    ends = vertices[edges_of(triangles)]
    return np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)


def mean_edge_lengths(vertices: FloatArray, triangles: Faces) -> FloatArray:
    """Return the mean length (n,) of the edges at every vertex."""
    edges = edges_of(triangles)
    length = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    ends = edges.ravel()
    total = np.bincount(ends, np.repeat(length, 2), minlength=len(vertices))
    return total / np.bincount(ends, minlength=len(vertices))


def density_ratio(vertices: FloatArray, triangles: Faces) -> float:
    """Return the 99th over the 1st percentile of the vertices' mean edge lengths."""
    low, high = np.percentile(mean_edge_lengths(vertices, triangles), [1, 99])
    return float(high / low)


def corner_angles(vertices: FloatArray, triangles: Faces) -> FloatArray:
    """Return the angles (m, 3) in degrees."""
    corners = vertices[triangles]
    after = np.roll(corners, -1, axis=1) - corners
    before = np.roll(corners, 1, axis=1) - corners
    sine = np.linalg.norm(np.cross(after, before), axis=2)
    return np.degrees(np.arctan2(sine, np.einsum("mcd,mcd->mc", after, before)))


def normals(vertices: FloatArray, triangles: Faces) -> FloatArray:
    """Return unit normals (m, 3)."""
    corners = vertices[triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return cross / np.maximum(np.linalg.norm(cross, axis=1, keepdims=True), 1e-30)


def vertex_normals(vertices: FloatArray, triangles: Faces) -> FloatArray:
    """Return unit vertex normals (n, 3), triangles weighted by area."""
    corners = vertices[triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    total = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(total, triangles[:, k], cross)
    return total / np.linalg.norm(total, axis=1, keepdims=True)


def triangle_areas(vertices: FloatArray, triangles: Faces) -> FloatArray:
    """Return the areas (m,)."""
    corners = vertices[triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return 0.5 * np.linalg.norm(cross, axis=1)
