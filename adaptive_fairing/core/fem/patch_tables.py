"""Basis functions at quadrature points, and the local matrices of the triangles that use them.

Source: the integrands of M and L in (3.4) and (3.9), written in parametric coordinates.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from ..loop.basis import BasisTable
from ..runtime.arrays import IndexArray, RealArray
from ..runtime.lazy import cached_property
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


# Basis functions that differ by less than this part of the largest number, by rounding, are one.
SAME = 1e-13


# Which factors of `PatchTables.local_matrices` count: of M alone, of L alone, of their sum.
MASS, STIFFNESS, SUM = slice(0, 1), slice(1, 4), slice(0, 4)


class PatchTables:
    """Tables of n triangles with q quadrature points and K control points each.

    Parameters
    ----------
    tables : sequence of k BasisTable
        One table of a patch class for all triangles, or one for each triangle, k = n, all with q
        points.  K is the largest number of control points; surplus control points of a triangle
        have the basis function 0.
    n_triangles : int
        How many triangles of the mesh share the table: decides whether a table of products pays.
    precision : float32 or float64
        Of all numbers.

    Attributes
    ----------
    weights : (2, q, k)
        Of the quadrature: for M and the measures, and for L.
    pairs : two arrays (p,)
        Pairs of control points a ≤ b, p = K (K + 1) / 2: the entries of a local matrix.
    """

    def __init__(
        self,
        tables: Sequence[BasisTable],
        n_triangles: int = 0,
        precision: Precision = np.float64,
    ) -> None:
        self._tables, self._n_triangles, self._precision = tables, n_triangles, precision
        self.n_points = tables[0].weights.shape[1]
        self.n_control_points = max(table.values.shape[2] for table in tables)
        self.pairs = upper_pairs(self.n_control_points)
        self.weights = np.stack([table.weights for table in tables], axis=2).astype(precision)

    @property
    def is_shared(self) -> bool:
        """Whether one table serves all triangles."""
        return len(self._tables) == 1

    @cached_property
    def single(self) -> PatchTables:
        """Tables in single precision."""
        return PatchTables(self._tables, self._n_triangles, np.float32)

    @cached_property
    def _basis(self) -> RealArray:
        """Value, ∂1, ∂2, ∂11, ∂12, ∂22 of all basis functions, (k, 6, q, K): made when used."""
        shape = len(self._tables), 6, self.n_points, self.n_control_points
        basis = np.zeros(shape, self._precision)
        for own, table in zip(basis, self._tables, strict=True):
            own[..., : table.values.shape[2]] = table.values
        return basis

    @cached_property
    def _distinct(self) -> tuple[RealArray, IndexArray]:
        """Distinct functions of a shared table, (1, 3, q, u), and which one each of the K is.

        Far around a pole of high valence the neighbours differ in no quadrature point: they move
        the pole, and nothing else of the patch.
        """
        basis = self._basis[:, :3]
        digits = -np.floor(np.log10(SAME * np.abs(basis).max())).astype(int)
        # 0 added, -0 is 0. As bytes, because numpy's unique columns take many times as long.
        rounded = np.round(basis[0], digits).reshape(-1, self.n_control_points) + 0.0
        numbers: dict[bytes, int] = {}
        number = np.array([numbers.setdefault(each.tobytes(), len(numbers)) for each in rounded.T])
        _, first = np.unique(number, return_index=True)
        return np.ascontiguousarray(basis[..., first]), number

    @cached_property
    def _weighted_gradients(self) -> RealArray:
        """∂1 and ∂2 of all basis functions times the weights, transposed: (k, K, 2 q)."""
        gradients = self._basis[:, 1:3] * self.weights[1].T[:, None, :, None]
        by_point = gradients.reshape(len(gradients), 2 * self.n_points, -1)
        return np.ascontiguousarray(by_point.swapaxes(1, 2))

    @cached_property
    def _products(self) -> RealArray | None:
        """Weighted products of all pairs of basis functions at all points, (1, p, 4 q)."""
        a, b = self.pairs
        n_products = 4 * self.n_points * len(a)
        if not (self.is_shared and product_table_pays(n_products, self._n_triangles)):
            return None
        first_order = self._basis[0, :3].transpose(2, 0, 1)
        left = np.take(first_order * self.weights[[0, 1, 1], :, 0], a, axis=0)
        right = np.take(first_order, b, axis=0)
        products = np.empty((len(a), 4, self.n_points), self._precision)
        np.multiply(left[:, :2], right[:, :2], out=products[:, :2])
        np.multiply(left[:, 1], right[:, 2], out=products[:, 2])
        np.multiply(left[:, 2], right[:, 2], out=products[:, 3])
        products[:, 2] += left[:, 2] * right[:, 1]
        return products.reshape(1, len(a), -1)

    def evaluate(self, control: RealArray, n_derivatives: int, out: RealArray) -> None:
        """Evaluate functions, given by their control values.

        Parameters
        ----------
        control : (c, K, n)
            Control values of c functions.
        n_derivatives : int
            1 for values alone, 3 with the first derivatives, 6 with the second ones.
        out : (c, n_derivatives q, n)
        """
        n_rows = n_derivatives * self.n_points
        basis = self._basis[:, :n_derivatives].reshape(-1, n_rows, self.n_control_points)
        _multiply(basis, control, out)

    def flux_sums(self, fluxes: RealArray, out: RealArray) -> None:
        """Integrate scalar products of fluxes with each basis function's gradient.

        Parameters
        ----------
        fluxes : (c, 2, q, n)
            Factors of ∂1 φ and of ∂2 φ.
        out : (c, K, n)
        """
        by_point = fluxes.reshape(len(fluxes), 2 * self.n_points, -1)
        _multiply(self._weighted_gradients, by_point, out)

    def local_matrices(self, coefficients: RealArray, terms: slice, out: RealArray) -> None:
        """Integrate products of basis functions.

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
            _multiply(self._products[..., own], factors[None], out[None])
            return
        weighted = coefficients * self.weights[[0, 1, 1, 1]]
        basis, number = self._distinct if self.is_shared else (self._basis[:, :3], None)
        a, b = self.pairs if number is None else (number[each] for each in self.pairs)
        for low in range(0, coefficients.shape[2], TRIANGLES_AT_ONCE):
            own = slice(low, low + TRIANGLES_AT_ONCE)
            phi, d1, d2 = (basis if self.is_shared else basis[own]).swapaxes(0, 1)
            mass, first, mixed, second = weighted[..., own].swapaxes(1, 2)[..., None]
            # Not one product of all three: it might be so large that OpenBLAS starts threads.
            local = np.zeros((len(mass), phi.shape[2], phi.shape[2]), out.dtype)
            if terms != STIFFNESS:
                local += phi.swapaxes(1, 2) @ (mass * phi)
            if terms != MASS:
                local += d1.swapaxes(1, 2) @ (first * d1 + mixed * d2)
                local += d2.swapaxes(1, 2) @ (mixed * d1 + second * d2)
            out[:, own] = local[:, a, b].T


@lru_cache(maxsize=256)
def upper_pairs(n: int) -> tuple[IndexArray, IndexArray]:
    """Pairs (a, b), a ≤ b < n, row by row."""
    pairs = np.triu_indices(n)
    for numbers in pairs:
        numbers.setflags(write=False)
    return pairs[0], pairs[1]


def _multiply(tables: RealArray, columns: RealArray, out: RealArray) -> None:
    """Multiply columns (c, s, n) by one table (1, r, s), or each by its own (n, r, s).

    With one table, so many columns at a time that OpenBLAS starts no threads.
    """
    n_columns = columns.shape[-1]
    if len(tables) > 1:
        out[:] = (tables @ np.ascontiguousarray(columns.T)).T
        return
    table = tables[0]
    width = max(LARGEST_PRODUCT // table.size, 2)
    if n_columns == 1:
        # Never one column alone: OpenBLAS starts threads for much smaller vectors.
        out[:] = np.matmul(table, np.repeat(columns, 2, axis=-1))[..., :1]
    elif n_columns <= width:
        np.matmul(table, columns, out=out)
    else:
        whole = n_columns - n_columns % width
        np.matmul(
            table, _grouped(columns[..., :whole], width), out=_grouped(out[..., :whole], width)
        )
        if whole < n_columns:
            rest = min(whole, n_columns - 2)
            np.matmul(table, columns[..., rest:], out=out[..., rest:])


def _grouped(matrices: RealArray, width: int) -> RealArray:
    """View matrices (c, r, n) as (c, n / width, r, width): `width` columns at a time."""
    return matrices.reshape(*matrices.shape[:-1], -1, width).swapaxes(-3, -2)
