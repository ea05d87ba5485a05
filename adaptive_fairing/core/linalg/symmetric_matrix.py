"""Symmetric sparse matrices of which only the upper triangle is stored."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from ..runtime.arrays import FloatArray, RealArray
from ..runtime.threads import ordered_map
from .symmetric_pattern import RowChunk, SymmetricPattern, adopt_entries


class SymmetricMatrix:
    """A = H + Hᵀ with H the upper triangle, half the diagonal in it.

    Products read half as much memory as with all entries, and a chunk of rows at a time, which
    serves all columns while it is in the cache.

    Parameters
    ----------
    pattern : SymmetricPattern
    halves : (n_upper,)
        Entries of H, in the order of the pattern, in single or double precision.
    """

    def __init__(self, pattern: SymmetricPattern, halves: RealArray) -> None:
        self.pattern = pattern
        self._halves = halves
        self._chunks = [
            _ChunkProduct(chunk, halves[pattern.row_starts[chunk.rows.start] :])
            for chunk in pattern.chunks
        ]

    @classmethod
    def from_upper(cls, pattern: SymmetricPattern, upper: RealArray) -> SymmetricMatrix:
        """Make the matrix with the upper entries `upper`, (n_upper,), which are changed."""
        upper[pattern.row_starts[:-1]] /= 2
        return cls(pattern, upper)

    @property
    def is_single(self) -> bool:
        """Whether the entries are in single precision."""
        return self._halves.dtype == np.float32

    def doubled(self) -> SymmetricMatrix:
        """Return the same entries in double precision."""
        return SymmetricMatrix(self.pattern, self._halves.astype(np.float64))

    def diagonal(self) -> RealArray:
        """Entries on the diagonal, (n,)."""
        diagonal: RealArray = 2 * self._halves[self.pattern.row_starts[:-1]]
        return diagonal

    def is_finite(self) -> bool:
        """Whether all entries are finite numbers."""
        return bool(np.isfinite(self._halves).all())

    def plus(self, factor: float, other: SymmetricMatrix) -> SymmetricMatrix:
        """Add `factor` times another matrix of the same pattern."""
        return SymmetricMatrix(self.pattern, self._halves + factor * other._halves)

    def weighted(self, weights: FloatArray) -> SymmetricMatrix:
        """Return D½ A D½ for the diagonal matrix D of `weights` > 0, (n,)."""
        pattern, root = self.pattern, np.sqrt(weights)
        rows = np.repeat(root, np.diff(pattern.row_starts))
        return SymmetricMatrix(pattern, self._halves * rows * root[pattern.columns(0, pattern.n)])

    def product(self, columns: RealArray) -> RealArray:
        """Multiply by k vectors, given as rows (k, n); return rows in the matrix's precision."""
        columns = np.ascontiguousarray(columns, dtype=self._halves.dtype)
        result = np.zeros_like(columns)
        products = ordered_map(lambda chunk: chunk.product(columns), self._chunks)
        for chunk, own in zip(self._chunks, products, strict=True):
            result[:, chunk.reach] += own
        return result

    def full(self) -> sparse.csr_array:
        """Return all entries, (n, n), in ascending columns."""
        pattern = self.pattern
        entries = (self._halves, pattern.columns(0, pattern.n), pattern.row_starts)
        upper = sparse.csr_array(entries, shape=(pattern.n, pattern.n))
        return (upper + upper.T).tocsr()


class _ChunkProduct:
    """Products with a chunk of rows of H, and with its transpose."""

    def __init__(self, chunk: RowChunk, halves: RealArray) -> None:
        self.reach = chunk.reach
        shape = chunk.rows.stop - chunk.rows.start, chunk.reach.stop - chunk.reach.start
        self._upper, self._lower = sparse.csr_array(shape), sparse.csc_array(shape[::-1])
        for matrix in (self._upper, self._lower):
            adopt_entries(matrix, halves[: len(chunk.columns)], chunk.columns, chunk.starts)

    def product(self, columns: RealArray) -> RealArray:
        """Return what these rows contribute to a product, within their reach."""
        n_rows = self._upper.shape[0]
        products = []
        for column in columns[:, self.reach]:
            product = self._lower @ column[:n_rows]
            product[:n_rows] += self._upper @ column
            products.append(product)
        return np.stack(products)
