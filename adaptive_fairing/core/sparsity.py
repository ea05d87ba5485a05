"""The fixed sparsity pattern of all matrices in the Loop space, and scattering into it.

Two basis functions meet on a triangle exactly if their vertices are at most three edges apart
(one step to a corner, one edge, one step out), so the pattern is that of (I + A)³ with the vertex
adjacency A: 37 entries a row on a regular mesh.  Only the upper triangle is accumulated.
"""

from __future__ import annotations

import threading
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from .parallel import ordered_map
from .topology import TriangleTopology

IntArray = NDArray[np.int32]

ENTRIES_PER_PIECE = 1 << 20

# Places in a table of ranks, two bytes each and as many tables as threads: where a strip of rows is
# wider, places are searched for in the pattern, which takes three times as long.
LARGEST_TABLE = 100_000_000


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
        near = topology.adjacency() + sparse.eye_array(self.n, dtype=np.int8, format="csr")
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
        self._tables = threading.local()

    def places(self, low: int, high: int) -> Places:
        """Prepare to look up entries among the vertices from `low` to `high` - 1."""
        upper = slice(self._upper_start[low], self._upper_start[high])
        sizes = np.diff(self._upper_start[low : high + 1])
        rows = np.repeat(np.arange(high - low, dtype=np.int32), sizes)
        columns = self._upper_columns[upper] - np.int32(low)
        start = self._upper_start[low:high]
        width = int((columns - rows).max()) + 1
        n_places = (high - low) * width + high - low
        if n_places > LARGEST_TABLE or sizes.max() > np.iinfo(np.uint16).max:
            return _SearchedPlaces(rows, columns, start)
        # One table per thread, for one chunk after the other: only places of entries are ever
        # read, so what is left of others does not matter.
        table = getattr(self._tables, "table", None)
        if table is None or len(table) < n_places:
            table = self._tables.table = np.empty(n_places, dtype=np.uint16)
        stride = np.int32(width - 1)
        table[rows * stride + columns] = np.arange(len(rows), dtype=np.int32) - (
            start - start[0]
        ).repeat(sizes)
        return _TabledPlaces(table, stride, start)

    def forget_tables(self) -> None:
        """Free the tables that looking up needed."""
        self._tables = threading.local()

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

    def numbers(self, first: IntArray, second: IntArray, out: IntArray) -> None:
        """Write the numbers of the entries (first, second) or (second, first) to `out`.

        Vertices count from the chunk's lowest one.
        """


class _TabledPlaces:
    """The rank of each upper entry in its row, at row · stride + column of a table."""

    def __init__(self, table: NDArray[np.uint16], stride: np.int32, start: IntArray) -> None:
        self._table, self._stride, self._start = table, stride, start

    def numbers(self, first: IntArray, second: IntArray, out: IntArray) -> None:
        row = np.minimum(first, second)
        place = np.maximum(first, second)
        np.take(self._start, row, out=out, mode="clip")
        row *= self._stride
        place += row
        out += np.take(self._table, place, mode="clip")


class _SearchedPlaces:
    """Entries are looked for in the sorted rows."""

    def __init__(self, rows: IntArray, columns: IntArray, start: IntArray) -> None:
        numbers = np.arange(start[0], start[0] + len(rows), dtype=np.int32)
        shape = (len(start), int(columns.max()) + 1)
        self._numbers = sparse.csr_array((numbers, (rows, columns)), shape=shape)

    def numbers(self, first: IntArray, second: IntArray, out: IntArray) -> None:
        row, column = np.minimum(first, second), np.maximum(first, second)
        found = self._numbers[row.reshape(-1), column.reshape(-1)]
        out[:] = np.asarray(found).reshape(out.shape)


def scattered(places: IntArray, values: NDArray[np.float64], size: int) -> NDArray[np.float64]:
    """Add up values by their places, (size,): half the time of ``numpy.bincount``."""
    column = sparse.csc_array(
        (values, places, np.array([0, len(values)], dtype=np.int32)), shape=(size, 1)
    )
    total: NDArray[np.float64] = column @ np.ones(1)
    return total
