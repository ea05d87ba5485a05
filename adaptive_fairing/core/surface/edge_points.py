"""Edge points of a refinement: control points, limit positions and normals.

They are most vertices of a refined mesh, and all regular: no matrix is needed, only neighbours.
"""

from __future__ import annotations

import numpy as np

from ..mesh.normals import unit_vectors
from ..runtime.arrays import FloatArray, IntArray
from ..runtime.threads import chunks, for_each
from .refined_topology import RefinedTopology

CACHED_ROWS = 4096
"""Number of rows processed at a time, so that all intermediate arrays stay in the cache."""


def edge_control_points(mesh: RefinedTopology, control: FloatArray, result: FloatArray) -> None:
    """Compute the control points of the new vertices.

    Parameters
    ----------
    mesh : RefinedTopology
        Before the step.
    control : (n_vertices, 3)
        Control points before it.
    result : (e, 3)
        Receives the control points.
    """
    opposite = mesh.opposite

    def of_rows(rows: slice) -> None:
        a, b = _taken(control, mesh.edges[rows])
        c, d = _taken(control, opposite[rows])
        result[rows] = ((a + b) * 3 + (c + d)) / 8

    for_each(of_rows, chunks(len(result), CACHED_ROWS))
    if mesh.has_sharp_edges:
        result[mesh.is_sharp] = control[mesh.edges[mesh.is_sharp]].sum(axis=1) / 2


def edge_limits(
    mesh: RefinedTopology,
    control: FloatArray,
    points: FloatArray | None = None,
    normals: FloatArray | None = None,
) -> None:
    """Compute points and unit normals of the limit surface at the new vertices.

    Parameters
    ----------
    mesh : RefinedTopology
        Before the step.
    control : (n_vertices + e, 3)
        Control points after it.
    points, normals : (e, 3), optional
        Receive the results.  Normals on sharp edges are meaningless; elsewhere the tangents are
        Σ cos(jπ/3) x_j and Σ sin(jπ/3) x_j.
    """
    own, rings = control[mesh.n_vertices :], mesh.edge_point_rings

    def of_rows(rows: slice) -> None:
        p = _taken(control, rings[rows])
        if points is not None:
            points[rows] = own[rows] / 2 + (p[0] + p[1] + p[2] + p[3] + p[4] + p[5]) / 12
        if normals is not None:
            first = 2 * (p[0] - p[3]) + p[1] - p[2] - p[4] + p[5]
            second = p[1] + p[2] - p[4] - p[5]
            normals[rows] = unit_cross(first, second)

    for_each(of_rows, chunks(len(rings), CACHED_ROWS))
    if points is not None and mesh.has_sharp_edges:
        sharp = np.flatnonzero(mesh.is_sharp)
        ends = control[mesh.edges[sharp]].sum(axis=1)
        points[sharp] = (4 * own[sharp] + ends) / 6


def _taken(control: FloatArray, indices: IntArray) -> list[FloatArray]:
    """Take the points (k, 3) of each column of indices."""
    return [np.take(control, column, axis=0) for column in indices.astype(np.intp).T]


def unit_cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Compute unit vectors along a × b, (n, 3); 0 where a × b is 0."""
    # By columns: four times as fast as np.cross.
    x, y = np.ascontiguousarray(a.T), np.ascontiguousarray(b.T)
    cross = np.stack([x[i - 2] * y[i - 1] - x[i - 1] * y[i - 2] for i in range(3)], axis=1)
    return unit_vectors(cross)
