"""Dense tables of one patch class, and the local matrices of its triangles.

Source: the integrands of M and L in (3.4) and (3.9), written in parametric coordinates.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .loop_basis import BasisTable

FloatArray = NDArray[np.float64]

# Above this many numbers the table of products (32 MB) costs more than it saves: poles of very
# high valence have tens of thousands of pairs of control points, and few triangles.
LARGEST_PRODUCT_TABLE = 4_000_000

# Multiplications per matrix product.  Products of this size stay below the limit at which OpenBLAS
# starts threads of its own, which would compete with those that work on other chunks.
LARGEST_PRODUCT = 250_000


class ClassTables:
    """Tables of a patch class with K control points and q quadrature points.

    Attributes
    ----------
    values : (q, K), gradients : (2, 1, q, K), second_derivatives : (3, 1, q, K)
    weights : (q,)
    weighted_values : (K, q)
        Transposed values times the weights.
    pairs : two arrays (p,)
        Pairs of control points a ≤ b, p = K (K + 1) / 2: the entries of a local matrix.
    """

    def __init__(self, table: BasisTable) -> None:
        basis, self.weights = table
        self.n_points, self.n_control_points = basis.shape[1:]
        self.values = np.ascontiguousarray(basis[0])
        self.gradients = np.ascontiguousarray(basis[1:3, None])
        self.second_derivatives = np.ascontiguousarray(basis[3:6, None])
        self.weighted_values = np.ascontiguousarray(basis[0].T * self.weights)
        self.pairs = np.triu_indices(self.n_control_points)
        self._products: FloatArray | None = None
        if 4 * self.n_points * len(self.pairs[0]) <= LARGEST_PRODUCT_TABLE:
            self._products = self._product_table()

    def local_matrices(self, coefficients: FloatArray, out: FloatArray) -> None:
        """Integrate products of basis functions over n triangles.

        Parameters
        ----------
        coefficients : (4, q, n)
            Factors of φa φb, ∂1φa ∂1φb, ∂1φa ∂2φb + ∂2φa ∂1φb and ∂2φa ∂2φb.
        out : (p, n)
            Entries (a, b) of the local matrices, see `pairs`.
        """
        n_triangles = coefficients.shape[2]
        if self._products is not None:
            stacked = coefficients.reshape(-1, n_triangles)
            # Never one column alone: OpenBLAS starts threads for much smaller vectors.
            if n_triangles == 1:
                out[:] = (self._products @ np.repeat(stacked, 2, axis=1))[:, :1]
                return
            width = max(LARGEST_PRODUCT // self._products.size, 2)
            whole = n_triangles - n_triangles % width
            if whole:
                slabs = _slabs(stacked[:, :whole], width)
                np.matmul(self._products, slabs, out=_slabs(out[:, :whole], width))
            if whole < n_triangles:
                rest = slice(min(whole, n_triangles - 2), None)
                np.matmul(self._products, stacked[:, rest], out=out[:, rest])
            return
        phi, d1, d2 = self.values, self.gradients[0, 0], self.gradients[1, 0]
        for triangle in range(n_triangles):
            mass, first, mixed, second = (coefficients[..., triangle] * self.weights)[..., None]
            local = phi.T @ (mass * phi)
            local += d1.T @ (first * d1 + mixed * d2)
            local += d2.T @ (mixed * d1 + second * d2)
            out[:, triangle] = local[self.pairs]

    def _product_table(self) -> FloatArray:
        """Weighted products of all pairs of basis functions at all points, (p, 4 q)."""
        a, b = self.pairs
        phi, d1, d2 = self.values, self.gradients[0, 0], self.gradients[1, 0]
        products = np.stack(
            [
                phi[:, a] * phi[:, b],
                d1[:, a] * d1[:, b],
                d1[:, a] * d2[:, b] + d2[:, a] * d1[:, b],
                d2[:, a] * d2[:, b],
            ]
        )
        products *= self.weights[:, None]
        return np.ascontiguousarray(products.reshape(-1, len(a)).T)


def _slabs(matrix: FloatArray, width: int) -> FloatArray:
    """View a matrix as a stack of slabs of `width` columns each."""
    return matrix.reshape(len(matrix), -1, width).transpose(1, 0, 2)
