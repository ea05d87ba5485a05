"""The fixed sparsity pattern of all matrices in the Loop space, and scattering into it.

Two basis functions meet on a triangle exactly if their vertices are at most three edges apart
(one step to a corner, one edge, one step out), so the pattern is that of (I + A)³ with the vertex
adjacency A: 37 entries a row on a regular mesh.  Only the upper triangle is accumulated.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from .topology import TriangleTopology


class SymmetricPattern:
    """Sparsity pattern of a symmetric matrix, with numbered entries of its upper triangle.

    Attributes
    ----------
    n : int
        Number of rows.
    n_upper : int
        Number of entries on and above the diagonal.
    """

    def __init__(self, topology: TriangleTopology) -> None:
        self.n = topology.n_vertices
        adjacency = topology.adjacency().astype(bool)
        near = adjacency + sparse.eye_array(self.n, dtype=bool, format="csr")
        reach = near @ near @ near
        reach = reach.T.tocsr()  # transposing a symmetric pattern sorts its rows in linear time
        self.indptr, self.indices = reach.indptr, reach.indices
        rows = np.repeat(np.arange(self.n, dtype=np.int32), np.diff(self.indptr))
        is_upper = self.indices >= rows
        self.n_upper = int(np.count_nonzero(is_upper))
        upper_of = np.cumsum(is_upper, dtype=np.int32) - np.int32(1)
        numbers = sparse.csr_array(
            (np.where(is_upper, upper_of, np.int32(0)), self.indices, self.indptr),
            shape=(self.n, self.n),
        )
        self._diagonal = upper_of[is_upper & (self.indices == rows)]
        # Below the diagonal an entry has the number of its mirror image.
        mirrored = numbers.T.tocsr().data
        self._upper_of = np.where(is_upper, upper_of, mirrored)
        numbers.data = self._upper_of
        numbers.has_canonical_format = True
        self._numbers = numbers

    def entries(self, rows: NDArray[np.int32], columns: NDArray[np.int32]) -> NDArray[np.int32]:
        """Return the upper-triangle numbers of the entries (rows, columns), in either order."""
        return np.asarray(self._numbers[rows, columns]).reshape(-1)

    def diagonal(self, upper: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the diagonal, (n,), of the matrix with upper entries `upper`."""
        return upper[self._diagonal]

    def matrix(self, upper: NDArray[np.float64]) -> sparse.csr_array:
        """Return the full symmetric matrix with upper entries `upper`, (n_upper,)."""
        return sparse.csr_array(
            (upper[self._upper_of], self.indices, self.indptr), shape=(self.n, self.n), copy=False
        )
