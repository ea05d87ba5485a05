"""Renumbering of vertices and triangles so that neighbours lie close together in memory."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import reverse_cuthill_mckee


class LocalOrder(NamedTuple):
    """A renumbered mesh.

    Attributes
    ----------
    vertices : (n,) int
        Old index of each new vertex: ``new = old[vertices]`` and ``old[vertices] = new``.
    triangles : (m, 3) int32
        The triangles in new numbers and new order.
    """

    vertices: NDArray[np.intp]
    triangles: NDArray[np.int32]


def local_order(triangles: NDArray[np.int32] | NDArray[np.int64], n_vertices: int) -> LocalOrder:
    """Renumber vertices along fronts (reverse Cuthill-McKee) and sort triangles to match."""
    edges = sparse.csr_array(
        sparse.coo_array(
            (
                np.ones(triangles.size, dtype=np.int8),
                (triangles.reshape(-1), triangles[:, [1, 2, 0]].reshape(-1)),
            ),
            shape=(n_vertices, n_vertices),
        )
    )
    # Boundary edges are stored in one direction only: not symmetric as it stands.
    vertices = reverse_cuthill_mckee(edges, symmetric_mode=False).astype(np.intp)
    new_number = np.empty(n_vertices, dtype=np.int32)
    new_number[vertices] = np.arange(n_vertices, dtype=np.int32)
    renumbered = new_number[triangles]
    by_front = np.argsort(renumbered.min(axis=1), kind="stable")
    return LocalOrder(vertices, renumbered[by_front])
