"""Symmetric matrices with an entry for every edge of a mesh, and their diagonal."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from ..mesh.topology import TriangleTopology
from ..runtime.arrays import FloatArray, IndexArray, RealArray
from ..runtime.lazy import cached_property
from ..runtime.threads import chunks, for_each
from .symmetric_pattern import adopt_entries

# Rows of a product that one thread computes at a time.
ROWS_PER_CHUNK = 16384


class EdgePattern:
    """Pattern of the entries of edges: row by row, in the order of the one-rings.

    Attributes
    ----------
    topology : TriangleTopology
    """

    def __init__(self, topology: TriangleTopology) -> None:
        self.topology = topology
        place = topology.ring_start[topology.origins] + topology.ring_position
        # The way back is the twin's; on the boundary there is none: the last place of the ring.
        targets = topology.triangles[:, [1, 2, 0]].reshape(-1)
        last = topology.ring_start[targets + 1] - 1
        back = np.where(topology.twin >= 0, place[topology.twin], last)
        # Numbers of the one or two half-edges of each place, corner by corner; then that of none.
        half_edges = np.arange(len(place)).reshape(3, -1).T.reshape(-1)
        self._sources: IndexArray = np.full((2, len(topology.ring)), len(place))
        for own, places in zip(self._sources, (place, back), strict=True):
            own[places] = half_edges

    def summed(self, entries: RealArray) -> EdgeMatrix:
        """Add up the entries (3, n_triangles) that triangles give their edges; no diagonal yet.

        Row k has those of the edges from corner k to the next.
        """
        topology = self.topology
        with_none = np.append(entries.reshape(-1), entries.dtype.type(0))
        # All numbers are in range, and mode "wrap" saves the time of checking them.
        values, others = (with_none.take(each, mode="wrap") for each in self._sources)
        values += others
        structure = values, topology.ring, topology.ring_start
        shape = topology.n_vertices, topology.n_vertices
        return EdgeMatrix(
            sparse.csr_array(structure, shape=shape), np.zeros(shape[0], values.dtype)
        )


class EdgeMatrix:
    """A diagonal matrix plus one with an entry for every edge.

    Parameters
    ----------
    edges : (n, n) csr_array
        Symmetric, without a diagonal.
    diagonal : (n,)
        In the precision of `edges`.
    """

    def __init__(self, edges: sparse.csr_array, diagonal: RealArray) -> None:
        self._edges, self._diagonal = edges, diagonal

    @property
    def n(self) -> int:
        """Number of rows."""
        return len(self._diagonal)

    @property
    def is_single(self) -> bool:
        """Whether the entries are in single precision."""
        return self._diagonal.dtype == np.float32

    def in_precision(self, precision: type) -> EdgeMatrix:
        """Return the same entries in a precision."""
        if self._diagonal.dtype == precision:
            return self
        # Not the matrix's own astype, which would sort the entries of every row first.
        data = self._edges.data.astype(precision)
        return EdgeMatrix(self._like(data), self._diagonal.astype(precision))

    def doubled(self) -> EdgeMatrix:
        """Return the same entries in double precision."""
        return self.in_precision(np.float64)

    def row_sums(self) -> RealArray:
        """Sum of each row, (n,)."""
        sums: RealArray = self._edges @ np.ones_like(self._diagonal) + self._diagonal
        return sums

    def diagonal(self) -> RealArray:
        """Entries on the diagonal, (n,)."""
        return self._diagonal

    def with_diagonal(self, diagonal: RealArray) -> EdgeMatrix:
        """Return the matrix with another diagonal, (n,)."""
        return EdgeMatrix(self._edges, diagonal)

    def is_finite(self) -> bool:
        """Whether all entries are finite numbers."""
        return bool(np.isfinite(self._edges.data).all() and np.isfinite(self._diagonal).all())

    def plus(self, factor: float, other: EdgeMatrix) -> EdgeMatrix:
        """Add `factor` times another matrix of the same pattern."""
        data = self._edges.data + factor * other._edges.data
        return EdgeMatrix(self._like(data), self._diagonal + factor * other._diagonal)

    def weighted(self, weights: FloatArray) -> EdgeMatrix:
        """Return D½ A D½ for the diagonal matrix D of `weights` > 0, (n,)."""
        root = np.sqrt(weights)
        rows = np.repeat(root, np.diff(self._edges.indptr))
        data = self._edges.data * rows * root[self._edges.indices]
        return EdgeMatrix(self._like(data), self._diagonal * weights)

    def product(self, columns: RealArray) -> RealArray:
        """Multiply by k vectors, given as rows (k, n); return rows in the matrix's precision."""
        columns = np.ascontiguousarray(columns, dtype=self._diagonal.dtype)
        result = np.empty_like(columns)

        def of_chunk(chunk: tuple[slice, sparse.csr_array]) -> None:
            rows, edges = chunk
            np.multiply(columns[:, rows], self._diagonal[rows], out=result[:, rows])
            for own, column in zip(result[:, rows], columns, strict=True):
                own += edges @ column

        for_each(of_chunk, self._chunks)
        return result

    @cached_property
    def _chunks(self) -> list[tuple[slice, sparse.csr_array]]:
        """Rows with their part of the edges, which is not copied."""
        parts, starts = chunks(self.n, ROWS_PER_CHUNK), self._edges.indptr
        cut = []
        for rows in parts:
            first, last = starts[[rows.start, rows.stop]]
            edges = sparse.csr_array((rows.stop - rows.start, self.n), dtype=self._edges.dtype)
            entries = self._edges.data[first:last], self._edges.indices[first:last]
            adopt_entries(edges, *entries, starts[rows.start : rows.stop + 1] - first)
            cut.append((rows, edges))
        return cut

    def full(self) -> sparse.csr_array:
        """Return all entries, (n, n)."""
        return sparse.csr_array(self._edges + sparse.diags_array(self._diagonal))

    def _like(self, data: RealArray) -> sparse.csr_array:
        structure = data, self._edges.indices, self._edges.indptr
        return sparse.csr_array(structure, shape=self._edges.shape)
