"""The density d_i of a mesh around its vertices, and its smoothing (3.6)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from ..errors import SettingsError
from ..runtime.arrays import FloatArray
from ..runtime.threads import chunks, ordered_map
from .loop_masks import limit_weight
from .normals import dots, triangle_normals
from .topology import TriangleTopology, require_topology

DENSITY_KINDS = ("edge_length", "area")

# Vertices that one thread works on in one go.
VERTICES_PER_CHUNK = 16384


def mesh_density(
    topology: TriangleTopology,
    positions: ArrayLike,
    kind: str = "edge_length",
    smoothing_passes: int = 3,
) -> FloatArray:
    """Measure how coarse the mesh is around each vertex.

    Parameters
    ----------
    topology : TriangleTopology
    positions : (n_vertices, 3)
        For the paper's numbers, scaled into [-3, 3]³.
    kind : "edge_length" or "area"
        Mean distance to the neighbours, or sum of the areas of the triangles around a vertex.
    smoothing_passes : int
        How often (3.6) is applied; the paper takes three.

    Returns
    -------
    (n_vertices,)
        d_i, a length or an area in the units of `positions`; 0 at loose vertices.

    Raises
    ------
    SettingsError
        If `kind` is not one of the two.

    Source: section 3.2 of the paper.

    Examples
    --------
    >>> from adaptive_fairing.core import TriangleTopology, mesh_density
    >>> corners = [(0, 0, 0), (3, 0, 0), (0, 4, 0)]
    >>> triangle = TriangleTopology([(0, 1, 2)], n_vertices=3)
    >>> mesh_density(triangle, corners, smoothing_passes=0).tolist()  # edges of 3, 4 and 5
    [3.5, 4.0, 4.5]
    >>> mesh_density(triangle, corners, kind="area", smoothing_passes=0).tolist()
    [6.0, 6.0, 6.0]
    """
    require_topology(topology)
    points = np.asarray(positions, dtype=np.float64)
    if kind == "edge_length":
        density = _mean_edge_length(topology, points)
    elif kind == "area":
        density = _ring_area(topology, points)
    else:
        raise SettingsError(f"density must be one of {', '.join(DENSITY_KINDS)}, not {kind!r}")
    if smoothing_passes:
        density = smoothed(topology, density, smoothing_passes)
    return density


def smoothed(topology: TriangleTopology, values: FloatArray, passes: int) -> FloatArray:
    """Replace control values by their limit values, `passes` times: (3.6).

    The paper has no rule for the boundary. There the limit mask is (1/6, 2/3, 1/6), that of the
    cubic B-spline curve to which Loop's boundary rules converge.
    """
    weight = _limit_weights(topology)
    keep = 1 - topology.ring_size * weight
    adjacency = topology.adjacency(np.float64)
    border = topology.boundary_vertices
    following, preceding = topology.boundary_neighbours
    for _ in range(passes):
        limits = keep * values + weight * (adjacency @ values)
        limits[border] = 2 / 3 * values[border] + (values[following] + values[preceding]) / 6
        values = limits
    return values


def _limit_weights(topology: TriangleTopology) -> FloatArray:
    """Weight of each neighbour in the limit position, (n_vertices,); 0 on the boundary."""
    # One cosine per valence, not per vertex.
    valences = np.arange(1, topology.ring_size.max(initial=0) + 1)
    weights: FloatArray = np.append(0.0, limit_weight(valences))[topology.ring_size]
    weights[topology.on_boundary] = 0
    return weights


def _mean_edge_length(topology: TriangleTopology, points: FloatArray) -> FloatArray:
    columns = np.ascontiguousarray(points.T)

    def of_chunk(own: slice) -> FloatArray:
        starts = topology.ring_start[own.start : own.stop + 1]
        ring, ring_size = topology.ring[starts[0] : starts[-1]], topology.ring_size[own]
        neighbours = ring.astype(np.intp)  # once, not for every column
        squared = np.zeros(len(ring))
        for column in columns:
            difference = np.repeat(column[own], ring_size)
            # All indices are in range, and mode "wrap" saves the time of checking them.
            difference -= np.take(column, neighbours, mode="wrap")
            difference *= difference
            squared += difference
        lengths = sparse.csr_array(
            (np.sqrt(squared, out=squared), ring, starts - starts[0]),
            shape=(len(ring_size), topology.n_vertices),
        )
        sums: FloatArray = lengths @ ones
        return sums / np.maximum(ring_size, 1)

    ones = np.ones(topology.n_vertices)
    parts = chunks(topology.n_vertices, VERTICES_PER_CHUNK)
    return np.concatenate(list(ordered_map(of_chunk, parts)))


def _ring_area(topology: TriangleTopology, points: FloatArray) -> FloatArray:
    normals = triangle_normals(points, topology.triangles)
    area = np.sqrt(dots(normals, normals)) / 2
    around = np.bincount(topology.origins, np.repeat(area, 3), minlength=topology.n_vertices)
    return around.astype(np.float64)  # integer zeros if there is no triangle at all
