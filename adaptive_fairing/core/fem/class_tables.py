"""Dense tables of one patch class, and the local matrices of its triangles.

Source: the integrands of M and L in (3.4) and (3.9), written in parametric coordinates.
"""

from __future__ import annotations

from functools import cached_property, lru_cache

import numpy as np

from ..loop.basis import BasisTable
from ..runtime.arrays import IndexArray, RealArray
from ..runtime.precision import Precision

# A table of products is made up to this many numbers (32 MB) and this many for each triangle that
# uses it: poles of high valence have tens of thousands of pairs of control points, many points,
# and few triangles.
LARGEST_PRODUCT_TABLE = 4_000_000
NUMBERS_PER_TRIANGLE = 15_000

# Without such a table, so many triangles are integrated in one go.
TRIANGLES_AT_ONCE = 16

# Multiplications per matrix product.  Products of this size stay below the limit at which OpenBLAS
# starts threads of its own, which would compete with those that work on other chunks.
LARGEST_PRODUCT = 250_000


def product_table_pays(n_products: int, n_triangles: int) -> bool:
    """Whether so many triangles are worth a table of products of so many numbers."""
    return n_products <= min(LARGEST_PRODUCT_TABLE, NUMBERS_PER_TRIANGLE * n_triangles)


# Which factors of `ClassTables.local_matrices` count: of M alone, of L alone, of their sum.
MASS, STIFFNESS, SUM = slice(0, 1), slice(1, 4), slice(0, 4)


class ClassTables:
    """Tables of a patch class with K control points and q quadrature points.

    Parameters
    ----------
    table : BasisTable
    n_triangles : int
        How many triangles of the mesh are of this class.
    precision : float32 or float64
        Of all numbers.

    Attributes
    ----------
    basis : (6 q, K)
        Values, ∂1, ∂2, ∂11, ∂12, ∂22 of all basis functions at all points.
    weights : (q, 1)
    pairs : two arrays (p,)
        Pairs of control points a ≤ b, p = K (K + 1) / 2: the entries of a local matrix.
    """

    def __init__(
        self, table: BasisTable, n_triangles: int, precision: Precision = np.float64
    ) -> None:
        self._table, self._n_triangles = table, n_triangles
        self.n_points, self.n_control_points = table.values.shape[1:]
        basis = np.ascontiguousarray(table.values, dtype=precision)
        self.basis = basis.reshape(-1, self.n_control_points)
        self.weights = table.weights[:, None].astype(precision)
        self.pairs = upper_pairs(self.n_control_points)

    @cached_property
    def single(self) -> ClassTables:
        """The same in single precision."""
        return ClassTables(self._table, self._n_triangles, np.float32)

    def evaluate(self, control: RealArray, n_derivatives: int, out: RealArray) -> None:
        """Evaluate functions over n triangles, given by their control values.

        Parameters
        ----------
        control : (k, K, n)
            Control values of k functions.
        n_derivatives : int
            1 for values alone, 3 with the first derivatives, 6 with the second ones.
        out : (k, n_derivatives q, n)
        """
        _multiply(self.basis[: n_derivatives * self.n_points], control, out)

    def flux_sums(self, fluxes: RealArray, out: RealArray) -> None:
        """Integrate scalar products of fluxes with each basis function's gradient.

        Parameters
        ----------
        fluxes : (k, 2, q, n)
            Factors of ∂1 φ and of ∂2 φ.
        out : (k, K, n)
        """
        n_triangles = fluxes.shape[-1]
        _multiply(self._weighted_gradients, fluxes.reshape(len(fluxes), -1, n_triangles), out)

    @cached_property
    def _weighted_gradients(self) -> RealArray:
        """Transposed ∂1 and ∂2 of all basis functions times the weights, (K, 2 q)."""
        gradients = self.basis.reshape(6, self.n_points, -1)[1:3] * self.weights
        return np.ascontiguousarray(gradients.reshape(2 * self.n_points, -1).T)

    def local_matrices(self, coefficients: RealArray, terms: slice, out: RealArray) -> None:
        """Integrate products of basis functions over n triangles.

        Parameters
        ----------
        coefficients : (4, q, n)
            Factors of φa φb, ∂1φa ∂1φb, ∂1φa ∂2φb + ∂2φa ∂1φb and ∂2φa ∂2φb.
        terms : MASS, STIFFNESS or SUM
            Those of the products that are added up.
        out : (p, n)
            Entries (a, b) of the local matrices, see `pairs`.
        """
        if self._products is not None:
            own = slice(terms.start * self.n_points, terms.stop * self.n_points)
            factors = coefficients[terms].reshape(-1, coefficients.shape[2])
            _multiply(self._products[:, own], factors, out)
            return
        first_order = self.basis.reshape(1, 6, self.n_points, -1)[:, :3]
        sum_products(first_order, coefficients * self.weights, terms, self.pairs, out)

    @cached_property
    def _products(self) -> RealArray | None:
        """Weighted products of all pairs of basis functions at all points, (p, 4 q)."""
        a, b = self.pairs
        if not product_table_pays(4 * self.n_points * len(a), self._n_triangles):
            return None
        first_order = self.basis.reshape(6, self.n_points, -1)[:3].transpose(2, 0, 1)
        left = np.take(first_order * self.weights[:, 0], a, axis=0)
        right = np.take(first_order, b, axis=0)
        products = np.empty((len(a), 4, self.n_points), self.basis.dtype)
        np.multiply(left[:, :2], right[:, :2], out=products[:, :2])
        np.multiply(left[:, 1], right[:, 2], out=products[:, 2])
        np.multiply(left[:, 2], right[:, 2], out=products[:, 3])
        products[:, 2] += left[:, 2] * right[:, 1]
        return products.reshape(len(a), -1)


@lru_cache(maxsize=256)
def upper_pairs(n: int) -> tuple[IndexArray, IndexArray]:
    """Pairs (a, b), a ≤ b < n, row by row."""
    pairs = np.triu_indices(n)
    for numbers in pairs:
        numbers.setflags(write=False)
    return pairs[0], pairs[1]


def sum_products(
    first_order: RealArray,
    coefficients: RealArray,
    terms: slice,
    pairs: tuple[IndexArray, IndexArray],
    out: RealArray,
) -> None:
    """Integrate products of basis functions over n triangles without a table of products.

    Parameters
    ----------
    first_order : (n or 1, 3, q, K)
        Values, ∂1, ∂2 of the basis functions of each triangle, or of all of them.
    coefficients : (4, q, n)
        As for `ClassTables.local_matrices`, times the weights.
    terms, pairs, out
        As there.
    """
    for low in range(0, coefficients.shape[2], TRIANGLES_AT_ONCE):
        own = slice(low, low + TRIANGLES_AT_ONCE)
        phi, d1, d2 = (first_order if len(first_order) == 1 else first_order[own]).swapaxes(0, 1)
        mass, first, mixed, second = coefficients[..., own].swapaxes(1, 2)[..., None]
        # Not one product of all three: it might be so large that OpenBLAS starts threads.
        local = np.zeros((len(mass), phi.shape[2], phi.shape[2]), out.dtype)
        if terms != STIFFNESS:
            local += phi.swapaxes(1, 2) @ (mass * phi)
        if terms != MASS:
            local += d1.swapaxes(1, 2) @ (first * d1 + mixed * d2)
            local += d2.swapaxes(1, 2) @ (mixed * d1 + second * d2)
        out[:, own] = local[:, pairs[0], pairs[1]].T


def _multiply(table: RealArray, columns: RealArray, out: RealArray) -> None:
    """Matrix product in slabs of columns, each below the size at which OpenBLAS starts threads."""
    n_columns = columns.shape[-1]
    width = max(LARGEST_PRODUCT // table.size, 2)
    if n_columns == 1:
        # Never one column alone: OpenBLAS starts threads for much smaller vectors.
        out[:] = np.matmul(table, np.repeat(columns, 2, axis=-1))[..., :1]
    elif n_columns <= width:
        np.matmul(table, columns, out=out)
    else:
        whole = n_columns - n_columns % width
        np.matmul(table, _slabs(columns[..., :whole], width), out=_slabs(out[..., :whole], width))
        if whole < n_columns:
            rest = min(whole, n_columns - 2)
            np.matmul(table, columns[..., rest:], out=out[..., rest:])


def _slabs(matrices: RealArray, width: int) -> RealArray:
    """View matrices (…, rows, columns) as stacks of slabs of `width` columns each."""
    return matrices.reshape(*matrices.shape[:-1], -1, width).swapaxes(-3, -2)
