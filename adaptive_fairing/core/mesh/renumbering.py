"""Renumbering of vertices and triangles so that neighbours lie close together in memory."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import sparse

from ..runtime.arrays import FloatArray, IndexArray, IntArray, LongArray
from .input_checks import bounding_box

# Vertices of one section of the sweep.  Within it, those with as many triangles stand together: a
# loop over matrix rows is three times as fast where the length of the rows hardly changes, because
# the processor foresees where each ends.
SECTION = 1024

# Positions along the sweep are told apart in so many steps.  Numbers of 16 bits are sorted by
# counting, in linear time, and these have two of them.
STEPS = 2**32 - 1


class LocalOrder(NamedTuple):
    """A renumbered mesh.

    Attributes
    ----------
    vertices : (n,) int
        Old index of each new vertex: ``new = old[vertices]`` and ``old[vertices] = new``.
    triangles : (m, 3) int32
        The triangles in new numbers and new order.
    """

    vertices: IndexArray
    triangles: IntArray


def sweep_order(positions: FloatArray, triangles: IntArray | LongArray) -> LocalOrder:
    """Renumber vertices in a sweep along the longest axis, and sort triangles to match.

    Matrix bandwidth and cache use come close to those of reverse Cuthill-McKee (the fronts are
    plane sections), at the cost of a sort.  Within a `SECTION` of the sweep vertices are sorted by
    how many triangles they have.
    """
    n_vertices = len(positions)
    low, high = bounding_box(positions)
    axis = int((high - low).argmax())
    vertices = _ascending_order(positions[:, axis].astype(np.float64))
    n_around = np.bincount(triangles.reshape(-1), minlength=n_vertices)[vertices]
    section = np.arange(n_vertices) // SECTION
    vertices = vertices[np.lexsort((n_around.astype(np.uint16), section.astype(np.uint16)))]
    new_number = np.empty(n_vertices, dtype=np.int32)
    new_number[vertices] = np.arange(n_vertices, dtype=np.int32)
    renumbered = new_number[triangles]
    front = np.minimum(np.minimum(renumbered[:, 0], renumbered[:, 1]), renumbered[:, 2])
    # Counting, as turning rows into columns does, beats comparing: a stable sort in linear time.
    n_triangles = len(front)
    ends = np.arange(n_triangles + 1, dtype=np.int32)
    rows = sparse.csr_array(
        (np.ones(n_triangles, dtype=np.int8), front, ends), shape=(n_triangles, n_vertices)
    )
    return LocalOrder(vertices, np.take(renumbered, rows.tocsc().indices, axis=0))


def _ascending_order(values: FloatArray) -> IndexArray:
    """Order of values rounded to steps; values of the same step keep their order."""
    low, high = values.min(), values.max()
    if low == high:
        return np.arange(len(values))
    step = ((values - low) * (STEPS / (high - low))).astype(np.uint32)
    order: IndexArray = np.lexsort((step.astype(np.uint16), (step >> 16).astype(np.uint16)))
    return order
