"""The fixed sparsity pattern of all matrices in the Loop space, and scattering into it.

Two basis functions meet on a triangle exactly if their vertices are at most three edges apart
(one step to a corner, one edge, one step out), so the pattern is that of (I + A)³ with the vertex
adjacency A: 37 entries a row on a regular mesh.  Only the upper triangle is accumulated.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import reverse_cuthill_mckee

from .parallel import ordered_map
from .topology import TriangleTopology

IntArray = NDArray[np.int32]

ENTRIES_PER_PIECE = 1 << 20

# Places in a table of entries, four bytes each and as many tables as threads.  Where a pole of high
# valence needs more, entries are searched for in the pattern, which takes three times as long.
LARGEST_TABLE = 32_000_000


class SymmetricPattern:
    """Sparsity pattern of a symmetric matrix, with numbered entries of its upper triangle.

    Attributes
    ----------
    n : int
        Number of rows.
    n_upper : int
        Number of entries on and above the diagonal, which are numbered row by row.
    """

    def __init__(self, topology: TriangleTopology) -> None:
        self.n = topology.n_vertices
        self._adjacency = topology.adjacency()
        near = self._adjacency + sparse.eye_array(self.n, dtype=np.int8, format="csr")
        reach = near @ near @ near
        reach = reach.T.tocsr()  # transposing a symmetric pattern sorts its rows in linear time
        self._indptr, self._indices = reach.indptr, reach.indices
        del near, reach
        rows = np.repeat(np.arange(self.n, dtype=np.int32), np.diff(self._indptr))
        is_upper = self._indices >= rows
        self._upper_columns = self._indices[is_upper]
        self.n_upper = len(self._upper_columns)
        self._upper_start = np.zeros(self.n + 1, dtype=np.int32)
        np.cumsum(np.bincount(rows[is_upper], minlength=self.n), out=self._upper_start[1:])
        del rows
        # Below the diagonal an entry has the number of its mirror image, diagonal ones twice.
        numbers = np.arange(self.n_upper, dtype=np.int32)
        upper = sparse.csr_array(
            (numbers, self._upper_columns, self._upper_start), shape=(self.n, self.n)
        )
        lower = upper.T.tocsr()
        self._upper_of = np.empty(len(self._indices), dtype=np.int32)
        self._upper_of[is_upper] = numbers
        below = np.ones(self.n_upper, dtype=bool)
        below[lower.indptr[1:] - 1] = False
        self._upper_of[~is_upper] = lower.data[below]

    def places(self, low: int, high: int) -> Places:
        """Prepare to look up entries among the vertices from `low` to `high` - 1."""
        first, last = self._upper_start[low], self._upper_start[high]
        sizes = np.diff(self._upper_start[low : high + 1])
        rows = np.repeat(np.arange(high - low, dtype=np.int32), sizes)
        columns = self._upper_columns[first:last] - np.int32(low)
        numbers = np.arange(first, last, dtype=np.int32)
        if columns.max() >= high - low:
            within = columns < high - low
            rows, columns, numbers = rows[within], columns[within], numbers[within]
        # In an order of small bandwidth a table with a place for every pair of near vertices is
        # not much larger than the entries.
        order = _narrow_order(self._adjacency[low:high, low:high])
        row, column = _ascending(order[rows], order[columns])
        stride = np.int32((column - row).max())
        if (high - low) * int(stride + 1) > LARGEST_TABLE:
            return _SearchedPlaces(rows, columns, numbers, high - low)
        table = np.empty((high - low) * int(stride + 1), dtype=np.int32)
        row *= stride
        row += column
        table[row] = numbers
        return _TabledPlaces(table, stride, order)

    def matrix(self, upper: NDArray[np.float64]) -> sparse.csr_array:
        """Return the full symmetric matrix with upper entries `upper`, (n_upper,)."""
        data = np.empty(len(self._indices))

        def fill(start: int) -> None:
            piece = slice(start, start + ENTRIES_PER_PIECE)
            np.take(upper, self._upper_of[piece], out=data[piece], mode="clip")

        for _ in ordered_map(fill, range(0, len(data), ENTRIES_PER_PIECE)):
            pass
        matrix = sparse.csr_array((data, self._indices, self._indptr), shape=(self.n, self.n))
        matrix.has_canonical_format = True
        return matrix


class Places(Protocol):
    """Finds the upper entries of pairs of vertices of one chunk."""

    def numbers(
        self, vertices: IntArray, pairs: tuple[NDArray[np.intp], NDArray[np.intp]], out: IntArray
    ) -> None:
        """Write the numbers of entries of local matrices.

        Parameters
        ----------
        vertices : (K, n) int32
            Control points, counted from the chunk's lowest vertex.
        pairs : two arrays (p,)
            Pairs of control points.
        out : (p, n) int32
        """


class _TabledPlaces:
    """The number of each upper entry, at row · stride + column of a table."""

    def __init__(self, table: IntArray, stride: np.int32, order: IntArray) -> None:
        self._table, self._stride, self._order = table, stride, order

    def numbers(
        self, vertices: IntArray, pairs: tuple[NDArray[np.intp], NDArray[np.intp]], out: IntArray
    ) -> None:
        ordered = self._order[vertices]
        place, column = _ascending(ordered[pairs[0]], ordered[pairs[1]])
        place *= self._stride
        place += column
        np.take(self._table, place, out=out, mode="clip")


class _SearchedPlaces:
    """Entries are looked for in the sorted rows."""

    def __init__(self, rows: IntArray, columns: IntArray, numbers: IntArray, n: int) -> None:
        self._numbers = sparse.csr_array((numbers, (rows, columns)), shape=(n, n))

    def numbers(
        self, vertices: IntArray, pairs: tuple[NDArray[np.intp], NDArray[np.intp]], out: IntArray
    ) -> None:
        row, column = _ascending(vertices[pairs[0]], vertices[pairs[1]])
        found = self._numbers[row.reshape(-1), column.reshape(-1)]
        out[:] = np.asarray(found).reshape(out.shape)


def _narrow_order(adjacency: sparse.csr_array) -> IntArray:
    """Renumber vertices so that neighbours have near numbers."""
    order = np.empty(adjacency.shape[0], dtype=np.int32)
    order[reverse_cuthill_mckee(adjacency, symmetric_mode=True)] = np.arange(
        len(order), dtype=np.int32
    )
    return order


def _ascending(first: IntArray, second: IntArray) -> tuple[IntArray, IntArray]:
    return np.minimum(first, second), np.maximum(first, second)


def scattered(places: IntArray, values: NDArray[np.float64], size: int) -> NDArray[np.float64]:
    """Add up values by their places, (size,): half the time of ``numpy.bincount``."""
    column = sparse.csc_array(
        (values, places, np.array([0, len(values)], dtype=np.int32)), shape=(size, 1)
    )
    total: NDArray[np.float64] = column @ np.ones(1)
    return total
