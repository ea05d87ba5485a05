"""The fixed sparsity pattern of all matrices in the Loop space, and the places of entries in it.

Two basis functions meet on a triangle exactly if their vertices are at most three edges apart
(one step to a corner, one edge, one step out), so the pattern is that of (I + A)³ with the vertex
adjacency A: 37 entries a row on a regular mesh.  Only the upper triangle is kept.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import reverse_cuthill_mckee

from ..runtime.arrays import IndexArray, IntArray, RealArray
from ..runtime.threads import Workspace, ordered_map

Pairs = tuple[IndexArray, IndexArray]

# Rows of a chunk: its entries should stay in the cache while several columns are multiplied.  With
# fewer rows than two such chunks have, there are two, for two threads, but for so few rows that to
# hand them over takes longer.
MOST_ROWS, FEWEST_ROWS = 16384, 4096

# Places in a table of entries, mostly of a byte each, and as many tables as threads.  Where a pole
# of high valence needs more, entries are searched for in the pattern, which takes three times as
# long.
LARGEST_TABLE = 32_000_000

# Rows whose places are found together: few enough to stay in the cache.
ROWS_AT_ONCE = 1024

# Below this number of triangles the calls take longer than what they compute.
FEW_TRIANGLES = 256


class RowChunk(NamedTuple):
    """Consecutive rows of the upper triangle, with the columns that they reach.

    Attributes
    ----------
    rows : slice
    reach : slice
        The columns, from the first row's diagonal on.
    starts : (n_rows + 1,) int32, columns : (n_entries,) int32
        Row pointers, and ascending columns counted from the first one: the diagonal first.
    """

    rows: slice
    reach: slice
    starts: IntArray
    columns: IntArray


class SymmetricPattern:
    """Sparsity pattern of a symmetric matrix, with numbered entries of its upper triangle.

    Parameters
    ----------
    adjacency : (n, n) csr_array
        Which vertices are neighbours; symmetric, without the diagonal.

    Attributes
    ----------
    n : int
        Number of rows.
    n_upper : int
        Number of entries on and above the diagonal, which are numbered row by row.
    row_starts : (n + 1,) int32
        Number of the first entry of each row: the one on the diagonal.
    chunks : list of RowChunk
    """

    def __init__(self, adjacency: sparse.csr_array) -> None:
        self.n = adjacency.shape[0]
        self._near = _with_diagonal(adjacency)
        size = min(max(-(-self.n // 2), FEWEST_ROWS), MOST_ROWS)
        rows = [slice(k, min(k + size, self.n)) for k in range(0, self.n, size)]
        two_edges = _near_of_near(self._near, rows)
        self.chunks = list(ordered_map(lambda own: _row_chunk(self._near, two_edges, own), rows))
        self.row_starts = np.zeros(self.n + 1, dtype=np.int32)
        for chunk in self.chunks:
            first, last = chunk.rows.start, chunk.rows.stop
            self.row_starts[first + 1 : last + 1] = chunk.starts[1:] + self.row_starts[first]
        self.n_upper = int(self.row_starts[-1])

    def columns(self, low: int, high: int) -> IntArray:
        """Columns of the entries of rows `low` to `high` - 1."""
        parts = [np.empty(0, dtype=np.int32)]
        for rows, _, starts, columns in self.chunks:
            first, last = max(low, rows.start), min(high, rows.stop)
            if first < last:
                own = slice(starts[first - rows.start], starts[last - rows.start])
                parts.append(columns[own] + np.int32(rows.start))
        return np.concatenate(parts)

    def places(self, low: int, high: int, workspace: Workspace) -> Places:
        """Prepare to look up entries among the vertices from `low` to `high` - 1.

        What is returned serves until the thread uses the workspace for other places.
        """
        # In an order of small bandwidth a table with a place for every pair of near vertices is
        # not much larger than the entries.
        near = self._near[low:high, low:high]
        order = _narrow_order(near)
        last = _last_within_three(near, order)
        # Row r of the table has columns r to last[r], the first of them at base[r] + r.
        ends = np.cumsum(last - np.arange(-1, high - low - 1))
        if ends[-1] > LARGEST_TABLE:
            return self._searched_places(low, high)
        base = ends - last - 1
        # Only the place of an entry in its row is stored, which fits into a byte: a small table.
        row_sizes = np.diff(self.row_starts[low : high + 1])
        narrow = np.min_scalar_type(row_sizes.max()).type
        table = workspace.array("places", int(ends[-1]), dtype=narrow)
        # Vertices beyond the range get a number that no row reaches.
        in_order = np.append(order, np.int32(high - low))
        for first in range(low, high, ROWS_AT_ONCE):
            rows = slice(first, min(first + ROWS_AT_ONCE, high))
            sizes = row_sizes[rows.start - low : rows.stop - low]
            own = np.repeat(order[rows.start - low : rows.stop - low], sizes)
            columns = self.columns(rows.start, rows.stop)
            columns -= np.int32(low)
            other = np.take(in_order, columns, mode="clip")
            row, column = _ascending(own, other)
            place_in_row = np.arange(len(row)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
            # A path of three edges may leave the range of vertices: no triangle has both its ends.
            # All indices are in range, and mode "wrap" saves the time of checking them.
            is_within = column <= np.take(last, row, mode="wrap")
            if not is_within.all():
                row, column, place_in_row = (x[is_within] for x in (row, column, place_in_row))
            table[np.take(base, row, mode="wrap") + column] = place_in_row
        return _TabledPlaces(table, base, order.astype(np.intp), self.row_starts[low:high])

    def _searched_places(self, low: int, high: int) -> Places:
        sizes = np.diff(self.row_starts[low : high + 1])
        rows = np.repeat(np.arange(high - low, dtype=np.int32), sizes)
        columns = self.columns(low, high) - np.int32(low)
        is_within = columns < high - low
        numbers = np.flatnonzero(is_within).astype(np.int32) + self.row_starts[low]
        return _SearchedPlaces(rows[is_within], columns[is_within], numbers, high - low)


def _with_diagonal(adjacency: sparse.csr_array) -> sparse.csr_array:
    """Put the diagonal first in every row; int16 ones, the other columns in the order they had."""
    n = adjacency.shape[0]
    diagonal = np.arange(n, dtype=np.int32)
    starts = adjacency.indptr + np.arange(n + 1, dtype=np.int32)
    columns = np.empty(starts[-1], dtype=np.int32)
    is_neighbour = np.ones(len(columns), dtype=bool)
    is_neighbour[starts[:-1]] = False
    columns[starts[:-1]] = diagonal
    columns[is_neighbour] = adjacency.indices
    ones = np.ones(len(columns), dtype=np.int16)
    return sparse.csr_array((ones, columns, starts), shape=adjacency.shape)


def _near_of_near(near: sparse.csr_array, rows: list[slice]) -> sparse.csr_array:
    """Find the vertices that are at most two edges away."""
    parts = list(ordered_map(lambda own: near[own] @ near, rows))
    two_edges = sparse.csr_array(sparse.vstack(parts)) if parts else near
    # Entries count paths; without this a count might overflow to 0, and the entry be lost.
    two_edges.data[:] = 1
    return two_edges


def _row_chunk(near: sparse.csr_array, two_edges: sparse.csr_array, rows: slice) -> RowChunk:
    """Find the vertices that are at most three edges away, for a chunk of rows."""
    # Not two edges and then one: the long rows of the second factor are read in one go.
    reach = near[rows] @ two_edges
    first, n_rows = rows.start, rows.stop - rows.start
    row = np.repeat(np.arange(first, rows.stop, dtype=np.int32), np.diff(reach.indptr))
    is_upper = reach.indices >= row
    columns = reach.indices[is_upper] - np.int32(first)
    starts = np.zeros(n_rows + 1, dtype=np.int32)
    np.cumsum(np.add.reduceat(is_upper, reach.indptr[:-1], dtype=np.int32), out=starts[1:])
    width = int(columns.max()) + 1
    entries = (np.ones(len(columns), dtype=bool), columns, starts)
    upper = sparse.csr_array(entries, shape=(n_rows, width))
    # Transposing twice sorts the columns of every row in linear time.
    return RowChunk(rows, slice(first, first + width), starts, upper.tocsc().tocsr().indices)


class Places(Protocol):
    """Finds the upper entries of pairs of near vertices."""

    def numbers(self, vertices: IntArray, pairs: Pairs, first: int, out: IntArray) -> None:
        """Write the numbers of entries of local matrices.

        Parameters
        ----------
        vertices : (K, n) int32
            Control points, counted from the lowest vertex of the places.
        pairs : two arrays (p,)
            Pairs of control points (a, b), a ≤ b, in the order of ``numpy.triu_indices``.
        first : int
            The entry from which numbers are counted.
        out : (p, n) int32
        """


class _TabledPlaces:
    """The place of each upper entry in its row, at base[r] + c of a table; base never decreases.

    r ≤ c are the numbers of the entry's vertices in the order of the table.
    """

    def __init__(
        self, table: IntArray, base: IndexArray, order: IndexArray, row_starts: IntArray
    ) -> None:
        self._table, self._base, self._order = table, base, order
        self._row_starts = row_starts

    def numbers(self, vertices: IntArray, pairs: Pairs, first: int, out: IntArray) -> None:
        order = np.take(self._order, vertices, mode="wrap")
        base = np.take(self._base, order, mode="wrap")
        starts = np.take(self._row_starts, vertices, mode="wrap") - np.int32(first)
        a, b = pairs
        if vertices.shape[1] < FEW_TRIANGLES:
            place = np.maximum(np.take(order, a, axis=0), np.take(order, b, axis=0))
            place += np.minimum(np.take(base, a, axis=0), np.take(base, b, axis=0))
            # An entry is in the row of the lower one of its vertices, which starts first.
            np.minimum(np.take(starts, a, axis=0), np.take(starts, b, axis=0), out=out)
            out += np.take(self._table, place, mode="wrap")
            return
        # The same row by row, without copies.
        done = 0
        for k in range(len(vertices)):
            place = np.maximum(order[k], order[k:])
            place += np.minimum(base[k], base[k:])
            own = np.minimum(starts[k], starts[k:], out=out[done : done + len(place)])
            own += np.take(self._table, place, mode="wrap").astype(np.int32)
            done += len(place)


class _SearchedPlaces:
    """Entries are looked for in the sorted rows."""

    def __init__(self, rows: IntArray, columns: IntArray, numbers: IntArray, n: int) -> None:
        self._numbers = sparse.csr_array((numbers, (rows, columns)), shape=(n, n))

    def numbers(self, vertices: IntArray, pairs: Pairs, first: int, out: IntArray) -> None:
        a, b = pairs
        row, column = _ascending(vertices[a], vertices[b])
        found = self._numbers[row.reshape(-1), column.reshape(-1)]
        out[:] = np.asarray(found).reshape(out.shape)
        out -= np.int32(first)


def _narrow_order(near: sparse.csr_array) -> IntArray:
    """Renumber vertices so that neighbours have near numbers."""
    order = np.empty(near.shape[0], dtype=np.int32)
    order[reverse_cuthill_mckee(near, symmetric_mode=True)] = np.arange(len(order), dtype=np.int32)
    return order


def _last_within_three(near: sparse.csr_array, order: IntArray) -> IntArray:
    """Bound for the numbers of vertices at most three edges away, for each vertex in the new order.

    Two control points of a triangle have a path of three edges among its other control points.
    """
    last = np.empty_like(order)
    last[order] = np.maximum.reduceat(order[near.indices], near.indptr[:-1])
    # So far at most one edge away. It hardly ever decreases, and a bound that never does is bound
    # for the next edge where it ends.
    np.maximum.accumulate(last, out=last)
    return last[last[last]]


def _ascending(first: IntArray, second: IntArray) -> tuple[IntArray, IntArray]:
    return np.minimum(first, second), np.maximum(first, second)


def adopt_entries(
    matrix: sparse.csr_array | sparse.csc_array,
    values: RealArray,
    indices: IntArray,
    starts: IntArray,
) -> None:
    """Give an empty matrix its entries without a copy: the constructor copies parts of arrays."""
    matrix.data, matrix.indices, matrix.indptr = values, indices, starts


def scattered(places: IntArray, values: RealArray, size: int) -> RealArray:
    """Add up values by their places, (size,): half the time of ``numpy.bincount``."""
    column = sparse.csc_array((size, 1))
    adopt_entries(column, values, places, np.array([0, len(values)], dtype=np.int32))
    total: RealArray = column @ np.ones(1, values.dtype)
    return total
