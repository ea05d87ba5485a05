"""The fixed sparsity pattern of all matrices in the Loop space, and scattering into it.

Two basis functions meet on a triangle exactly if their vertices are at most three edges apart
(one step to a corner, one edge, one step out), so the pattern is that of (I + A)³ with the vertex
adjacency A: 37 entries a row on a regular mesh.  Only the upper triangle is accumulated.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from .parallel import ordered_map
from .topology import TriangleTopology

ENTRIES_PER_PIECE = 1 << 20


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
        near = topology.adjacency().astype(bool) + sparse.eye_array(
            self.n, dtype=bool, format="csr"
        )
        reach = near @ near @ near
        reach = reach.T.tocsr()  # transposing a symmetric pattern sorts its rows in linear time
        self._indptr, self._indices = reach.indptr, reach.indices
        rows = np.repeat(np.arange(self.n, dtype=np.int32), np.diff(self._indptr))
        is_upper = self._indices >= rows
        self.n_upper = int(np.count_nonzero(is_upper))
        numbers = np.cumsum(is_upper, dtype=np.int32)
        numbers -= np.int32(1)
        # Below the diagonal an entry has the number of its mirror image.
        mirrored = self._with_pattern(numbers).T.tocsr().data
        self._upper_of = np.where(is_upper, numbers, mirrored)
        self._numbers = self._with_pattern(self._upper_of)

    def entries(self, rows: NDArray[np.int32], columns: NDArray[np.int32]) -> NDArray[np.int32]:
        """Return the upper-triangle numbers of the entries (rows, columns), in either order."""
        # Only the rows in question: scipy checks the whole matrix at every look-up.
        low, high = int(rows.min()), int(rows.max()) + 1
        numbers = self._numbers[low:high]
        return np.asarray(numbers[rows - np.int32(low), columns]).reshape(-1)

    def matrix(self, upper: NDArray[np.float64]) -> sparse.csr_array:
        """Return the full symmetric matrix with upper entries `upper`, (n_upper,)."""
        data = np.empty(len(self._indices))

        def fill(start: int) -> None:
            piece = slice(start, start + ENTRIES_PER_PIECE)
            np.take(upper, self._upper_of[piece], out=data[piece], mode="clip")

        for _ in ordered_map(fill, range(0, len(data), ENTRIES_PER_PIECE)):
            pass
        return self._with_pattern(data)

    def _with_pattern(self, data: NDArray[np.generic]) -> sparse.csr_array:
        matrix = sparse.csr_array((data, self._indices, self._indptr), shape=(self.n, self.n))
        matrix.has_canonical_format = True
        return matrix
