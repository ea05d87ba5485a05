"""Edge lengths, normals and volumes of triangle meshes: what noise and errors are measured by."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Faces = NDArray[np.int32]


def edges_of(faces: Faces) -> NDArray[np.int64]:
    """Return every edge (k, 2) once, the smaller index first."""
    return np.unique(_sides(faces), axis=0)


def is_closed(faces: Faces) -> bool:
    """Tell whether every edge has two triangles."""
    return bool(np.all(np.unique(_sides(faces), axis=0, return_counts=True)[1] == 2))


def _sides(faces: Faces) -> NDArray[np.int64]:
    return np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1).astype(np.int64)


def inner_edges(faces: Faces, opposite: bool = False) -> tuple[NDArray, NDArray]:
    """Return the edges that have two triangles, and these.

    Parameters
    ----------
    faces
        (m, 3) triangles.
    opposite
        Give the corners of both triangles, (k, 4): an end of the edge, the corner opposite to the
        edge in the first triangle, the other end, and the corner opposite in the second one. Else
        the ends alone, (k, 2).

    Returns
    -------
    edges, triangles
        The corners, and (k, 2) indices of the triangles.
    """
    order = np.lexsort(_sides(faces).T)
    first, second = order[:-1], order[1:]
    ends = _sides(faces)[order]
    twice = (ends[:-1] == ends[1:]).all(axis=1)
    first, second = first[twice], second[twice]
    start = faces[first // 3, first % 3]
    end = faces[first // 3, (first + 1) % 3]
    corners = [start, end]
    if opposite:
        corners = [
            start,
            faces[first // 3, (first + 2) % 3],
            end,
            faces[second // 3, (second + 2) % 3],
        ]
    return np.stack(corners, axis=1), np.stack([first // 3, second // 3], axis=1)


def local_edge_lengths(vertices: FloatArray, faces: Faces) -> FloatArray:
    """Return the mean length (n,) of the edges at every vertex, 0 at loose ones."""
    edges = edges_of(faces)
    lengths = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    total = np.bincount(edges.ravel(), np.repeat(lengths, 2), len(vertices))
    return total / np.maximum(np.bincount(edges.ravel(), minlength=len(vertices)), 1)


def scaled_normals(vertices: FloatArray, faces: Faces) -> FloatArray:
    """Return normals (m, 3) of the triangles, twice their area long."""
    corner = vertices[faces]
    return np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])


def unit(vectors: FloatArray) -> FloatArray:
    """Return vectors (n, 3) of length one; those of no length stay as they are."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.where(lengths > 0, lengths, 1.0)


def vertex_normals(vertices: FloatArray, faces: Faces) -> FloatArray:
    """Return unit normals (n, 3) of the vertices, triangles weighted by area."""
    face_normals = np.repeat(scaled_normals(vertices, faces), 3, axis=0)
    columns = [np.bincount(faces.ravel(), column, len(vertices)) for column in face_normals.T]
    return unit(np.stack(columns, axis=1))


def signed_volume(vertices: FloatArray, faces: Faces) -> float:
    """Return the volume inside a closed mesh, negative where its triangles face inwards."""
    corner = (vertices - vertices.mean(axis=0))[faces]
    return float(np.einsum("fd,fd->", np.cross(corner[:, 0], corner[:, 1]), corner[:, 2]) / 6)
