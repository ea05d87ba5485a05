"""Counts of a mesh: its connected parts, its boundaries, its edges of more than two triangles."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ..runtime.arrays import IntArray


class MeshCounts(NamedTuple):
    """Parts, boundaries and crowded edges of a mesh.

    Attributes
    ----------
    n_parts : int
        Connected parts: of triangles that share a vertex.
    largest_part : float
        Fraction of the triangles that lies in the largest part.
    n_boundaries : int
        Connected boundaries: holes and outer boundaries.
    n_crowded_edges : int
        Edges of more than two triangles.
    """

    n_parts: int
    largest_part: float
    n_boundaries: int
    n_crowded_edges: int


def mesh_counts(triangles: IntArray) -> MeshCounts:
    """Count the parts, boundaries and crowded edges of triangles (m, 3), m ≥ 1."""
    n = int(triangles.max()) + 1
    ends = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1).astype(np.int64)
    # One number per edge sorts much faster than pairs do.
    keys, uses = np.unique(ends[:, 0] * n + ends[:, 1], return_counts=True)
    part = _components(keys, n)[triangles[:, 0]]
    sizes = np.unique(part, return_counts=True)[1]
    border = keys[uses == 1]
    borders = np.unique(_components(border, n)[border // n])
    return MeshCounts(
        n_parts=len(sizes),
        largest_part=float(sizes.max() / len(part)),
        n_boundaries=len(borders),
        n_crowded_edges=int(np.count_nonzero(uses > 2)),
    )


def _components(keys: IntArray, n: int) -> IntArray:
    """Label the n vertices by connected component; edges are given as first · n + second."""
    ones = np.ones(len(keys), dtype=bool)
    graph = sparse.coo_array((ones, (keys // n, keys % n)), shape=(n, n))
    label: IntArray = csgraph.connected_components(graph, directed=False)[1]
    return label
