"""Normals of triangles and of vertices."""

from __future__ import annotations

import numpy as np

from ..runtime.arrays import FloatArray, IntArray
from ..runtime.threads import chunks, for_each
from .topology import TriangleTopology

TRIANGLES_PER_CHUNK = 16384


def triangle_normals(positions: FloatArray, triangles: IntArray) -> FloatArray:
    """Compute normals (m, 3) of triangles, whose length is twice the area."""
    columns = np.ascontiguousarray(positions.T)
    normals = np.empty((len(triangles), 3))

    def of_chunk(own: slice) -> None:
        first, second, third = triangles[own].T

        def edges(column: FloatArray) -> tuple[FloatArray, FloatArray]:
            start = column[first]
            return column[second] - start, column[third] - start

        # A coordinate at a time: a third of the time that numpy.cross of all corners takes.
        (a, u), (b, v), (c, w) = map(edges, columns)
        np.stack([b * w - c * v, c * u - a * w, a * v - b * u], axis=1, out=normals[own])

    for_each(of_chunk, chunks(len(triangles), TRIANGLES_PER_CHUNK))
    return normals


def vertex_normals(topology: TriangleTopology, positions: FloatArray) -> FloatArray:
    """Average the normals of the triangles around, by area: unit vectors (n, 3), 0 if loose."""
    return vertex_normals_of(topology.triangles, positions)


def vertex_normals_of(triangles: IntArray, positions: FloatArray) -> FloatArray:
    """Average normals as `vertex_normals` does; triangles (m, 3) need not form a manifold."""
    by_area = triangle_normals(positions, triangles)
    corners = triangles.T.reshape(-1)
    sums = [np.bincount(corners, np.tile(x, 3), len(positions)) for x in by_area.T]
    return unit_vectors(np.stack(sums, axis=1))


def dots(first: FloatArray, second: FloatArray) -> FloatArray:
    """Scalar products (n,) of vectors (n, 3) with vectors (n, 3)."""
    products: FloatArray = np.einsum("nd,nd->n", first, second)
    return products


def unit_vectors(vectors: FloatArray) -> FloatArray:
    """Divide vectors (n, 3) by their lengths; those of length 0 stay."""
    lengths = np.sqrt(dots(vectors, vectors))
    units: FloatArray = vectors / np.where(lengths > 0, lengths, 1)[:, None]
    return units
