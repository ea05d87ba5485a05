"""Curvature of the limit surface at vertices, from exact second derivatives.

At a regular vertex the surface is a quartic box spline.  Its second derivative along an edge is
the second difference of the control points there, x_0 - 2 x_v + x_3; on a regular boundary or
crease the missing neighbours are those that the boundary rules imply.
"""

from __future__ import annotations

import numpy as np

from ..runtime.arrays import FloatArray
from .refined_topology import CREASE, SMOOTH, RefinedTopology
from .sectors import counted, sectors_of

REGULAR_VALENCE = 6
REGULAR_SECTOR = 3  # triangles on one side of a regular boundary vertex


def regular_curvature(mesh: RefinedTopology, control: FloatArray) -> FloatArray:
    """Compute mean and Gaussian curvature where the surface is regular, (2, n_vertices).

    Returns
    -------
    (2, n_vertices) array
        In 1 / length and 1 / length²; the mean curvature is positive where the surface bulges
        outward.  On a crease the mean of both sides.  NaN elsewhere and where the surface has no
        tangent plane.
    """
    n = mesh.n_vertices
    is_inside = (mesh.kind == SMOOTH) & (mesh.ring_size == REGULAR_VALENCE) & ~mesh.on_boundary
    inside = np.flatnonzero(is_inside)
    rings = mesh.ring[mesh.ring_start[inside][:, None] + np.arange(REGULAR_VALENCE)]
    result = np.full((2, n), np.nan)
    result[:, inside] = _curvature(control[inside], control[rings])

    sectors = sectors_of(mesh)
    is_regular = (mesh.kind[sectors.vertex] == CREASE) & (sectors.size == REGULAR_SECTOR)
    n_sectors = np.bincount(sectors.vertex, minlength=n)
    n_regular = np.bincount(sectors.vertex[is_regular], minlength=n)
    is_whole = is_regular & (n_regular == n_sectors)[sectors.vertex]
    at = sectors.vertex[is_whole]
    own = control[at]
    there = control[sectors.neighbour[sectors.start[is_whole][:, None] + np.arange(4)]]
    beyond = np.stack([own + there[:, 3] - there[:, 2], own + there[:, 0] - there[:, 1]], axis=1)
    values = _curvature(own, np.concatenate([there, beyond], axis=1))
    for row, of_sectors in zip(result, values, strict=True):
        sums = np.bincount(at, of_sectors, n)
        row[at] = sums[at] / n_sectors[at]
    return result


def curvature(mesh: RefinedTopology, control: FloatArray, finer_control: FloatArray) -> FloatArray:
    """Compute mean and Gaussian curvature at all vertices, (2, n_vertices).

    The curvature of Loop's surface has no value at a vertex of another valence than 6: towards it,
    it tends to 0 or grows without bound in some directions.  Such vertices, darts and corners get
    the mean of the exact values at the points of the surface half-way to their neighbours.

    Returns
    -------
    (2, n_vertices) array
        As `regular_curvature`; NaN at loose vertices.
    """
    result = regular_curvature(mesh, control)
    rest = np.flatnonzero(np.isnan(result[0]) & (mesh.ring_size > 0))
    if len(rest):
        finer = regular_curvature(mesh.finer, finer_control)
        size = mesh.ring_size[rest]
        owner, offset = counted(size.astype(np.intp))
        half_way = mesh.n_vertices + mesh.ring_edges[mesh.ring_start[rest][owner] + offset]
        for row, values in zip(result, finer, strict=True):
            row[rest] = np.bincount(owner, values[half_way], len(rest)) / size
    return result


def refined_curvature(mesh: RefinedTopology, control: FloatArray) -> FloatArray:
    """Compute the same on a mesh that was refined at least once, (2, n_vertices).

    There all neighbours of a vertex without a value have one; the vertex gets their mean.
    """
    result = regular_curvature(mesh, control)
    rest = np.flatnonzero(np.isnan(result[0]) & (mesh.ring_size > 0))
    size = mesh.ring_size[rest]
    owner, offset = counted(size.astype(np.intp))
    neighbours = mesh.ring[mesh.ring_start[rest][owner] + offset]
    for row in result:
        row[rest] = np.bincount(owner, row[neighbours], len(rest)) / size
    return result


def _curvature(own: FloatArray, ring: FloatArray) -> FloatArray:
    """Mean and Gaussian curvature of regular vertices (k, 3) with their rings (k, 6, 3), (2, k)."""
    turn = np.pi / 3 * np.arange(6)
    along = np.einsum("j,kjd->kd", np.cos(turn) / 3, ring)
    other = np.einsum("j,kjd->kd", np.cos(turn - np.pi / 3) / 3, ring)
    second = ring[:, :3] + ring[:, 3:] - 2 * own[:, None]
    normal = np.cross(along, other)
    squared = np.einsum("kd,kd->k", normal, normal)  # the determinant of the metric
    squared[squared == 0] = np.nan
    bend = np.einsum("kjd,kd->kj", second, normal) / np.sqrt(squared)[:, None]
    # The third direction is the second minus the first, hence the mixed derivative.
    b11, b12, b22 = bend[:, 0], (bend[:, 0] + bend[:, 1] - bend[:, 2]) / 2, bend[:, 1]
    pairs = (along, along), (along, other), (other, other)
    g11, g12, g22 = (np.einsum("kd,kd->k", a, b) for a, b in pairs)
    mean = -(g11 * b22 - 2 * g12 * b12 + g22 * b11) / (2 * squared)
    return np.stack([mean, (b11 * b22 - b12 * b12) / squared])
