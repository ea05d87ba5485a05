"""From control points to points on Loop's limit surface, and nearly back."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from ..runtime.arrays import FloatArray
from .loop_masks import limit_weight
from .topology import TriangleTopology

# Terms of the Neumann series below.  Loop's limit mask P damps the finest waves of a regular mesh
# to a quarter, so 3 terms leave (3/4)³ = 42 % of them out, and 0.1 % of waves 8 edges long.
INVERSE_TERMS = 3


def limit_weights(topology: TriangleTopology) -> FloatArray:
    """Weights (n_vertices,) of each neighbour in limit positions inside; 0 for other vertices."""
    # One cosine per valence, not per vertex.
    valences = np.arange(1, topology.ring_size.max(initial=0) + 1)
    weights: FloatArray = np.append(0.0, limit_weight(valences))[topology.ring_size]
    weights[topology.on_boundary] = 0
    return weights


def limit_matrix(topology: TriangleTopology) -> sparse.csr_array:
    """Assemble P: rows of weights whose product with control points are limit positions.

    Returns
    -------
    (n_vertices, n_vertices) csr_array
        Rows are not negative and add up to 1; loose vertices stay.

    Source: (3.6) of the paper inside; the cubic B-spline curve's (1/6, 2/3, 1/6) on the boundary.
    """
    n = topology.n_vertices
    weight = limit_weights(topology)
    keep = 1 - topology.ring_size * weight
    border = topology.boundary_vertices
    keep[border] = 2 / 3
    before = topology.ring[topology.ring_start[border]]
    after = topology.ring[topology.ring_start[border + 1] - 1]
    rows = np.concatenate([np.arange(n), np.repeat(np.arange(n), topology.ring_size)])
    columns = np.concatenate([np.arange(n), topology.ring])
    values = np.concatenate([keep, np.repeat(weight, topology.ring_size)])
    along = np.full(2 * len(border), 1 / 6)
    rows = np.concatenate([rows, border, border])
    columns = np.concatenate([columns, before, after])
    matrix = sparse.coo_array((np.concatenate([values, along]), (rows, columns)), shape=(n, n))
    return sparse.csr_array(matrix)


def near_control_points(limit: sparse.csr_array, positions: FloatArray) -> FloatArray:
    """Control points of a limit surface that runs close by the positions, (n, k).

    The exact ones, P⁻¹ x, would follow the noise of the finest waves and amplify it fourfold; the
    first terms of P⁻¹ = Σ (I - P)^k are exact for waves longer than a few edges.
    """
    control = positions
    for _ in range(INVERSE_TERMS - 1):
        control = control + (positions - limit @ control)
    return control
