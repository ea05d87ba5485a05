"""Limit positions and normals of the vertices that a step of refinement adds.

They are most of a refined mesh, and all regular: no matrix is needed, only the six neighbours.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..mesh.normals import unit_vectors
from ..runtime.arrays import FloatArray
from .refined_mesh import RefinedMesh

CACHED_ROWS = 4096
"""Rows worked on at a time, so that all intermediate arrays stay in the cache."""


def edge_limit_points(mesh: RefinedMesh, control: FloatArray) -> FloatArray:
    """Compute the points of the limit surface at the new vertices, (e, 3).

    Parameters
    ----------
    mesh : RefinedMesh
        Before the step.
    control : (n_vertices + e, 3)
        Control points after it.
    """
    result = control[mesh.n_vertices :] / 2
    for rows, p in _neighbours(mesh, control):
        result[rows] += (p[0] + p[1] + p[2] + p[3] + p[4] + p[5]) / 12
    if mesh.has_sharp_edges:
        sharp = np.flatnonzero(mesh.is_sharp)
        ends = control[mesh.edges[sharp]].sum(axis=1)
        result[sharp] = (4 * control[mesh.n_vertices + sharp] + ends) / 6
    return result


def edge_normals(mesh: RefinedMesh, control: FloatArray) -> FloatArray:
    """Compute the unit normals there, (e, 3); on sharp edges they mean nothing.

    Parameters: as in `edge_limit_points`.  The tangents are Σ cos(jπ/3) x_j and Σ sin(jπ/3) x_j.
    """
    result = np.empty((len(mesh.edges), 3))
    for rows, p in _neighbours(mesh, control):
        first = 2 * (p[0] - p[3]) + p[1] - p[2] - p[4] + p[5]
        second = p[1] + p[2] - p[4] - p[5]
        result[rows] = unit_cross(first, second)
    return result


def _neighbours(mesh: RefinedMesh, control: FloatArray) -> Iterator[tuple[slice, list[FloatArray]]]:
    """Give parts of the new vertices, and the positions of their six neighbours, (k, 3) each."""
    for begin in range(0, len(mesh.edges), CACHED_ROWS):
        rows = slice(begin, begin + CACHED_ROWS)
        ring = mesh.edge_point_rings[rows].astype(np.intp)
        yield rows, [np.take(control, column, axis=0) for column in ring.T]


def unit_cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Compute unit vectors along a × b, (n, 3), 0 where there is none."""
    # By columns: four times as fast as np.cross.
    x, y = np.ascontiguousarray(a.T), np.ascontiguousarray(b.T)
    cross = np.stack([x[i - 2] * y[i - 1] - x[i - 1] * y[i - 2] for i in range(3)], axis=1)
    return unit_vectors(cross)
