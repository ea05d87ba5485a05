"""Dense tables of triangles whose classes are too rare for matrix products of their own.

A product for each of hundreds of classes with one or two triangles takes longer to call than to
compute.  Such triangles are stacked, each with a table of its own, and numpy loops over the stack.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from ..loop.basis import BasisTable
from ..runtime.arrays import RealArray
from ..runtime.precision import Precision
from .class_tables import sum_products, upper_pairs


class RareTables:
    """Tables of n triangles with q quadrature points each, filled up with zeros to K columns.

    The same methods as `ClassTables`.

    Parameters
    ----------
    tables : sequence of BasisTable
        Of each triangle, all with equally many points.
    n_control_points : int
        K; surplus control points of a triangle have the basis function 0.
    precision : float32 or float64
        Of all numbers.

    Attributes
    ----------
    weights : (q, n)
    pairs : two arrays (p,)
        Pairs of control points a ≤ b, p = K (K + 1) / 2: the entries of a local matrix.
    """

    def __init__(
        self,
        tables: Sequence[BasisTable],
        n_control_points: int,
        precision: Precision = np.float64,
    ) -> None:
        self._tables, self._precision = tables, precision
        self.n_points, self.n_control_points = len(tables[0].weights), n_control_points
        self.pairs = upper_pairs(n_control_points)
        self.weights = np.stack([table.weights for table in tables], axis=1).astype(precision)

    @cached_property
    def single(self) -> RareTables:
        """The same in single precision."""
        return RareTables(self._tables, self.n_control_points, np.float32)

    @cached_property
    def _basis(self) -> RealArray:
        """Values and derivatives of all basis functions, (n, 6, q, K): made when used."""
        shape = len(self._tables), 6, self.n_points, self.n_control_points
        basis = np.zeros(shape, self._precision)
        for own, table in zip(basis, self._tables, strict=True):
            own[..., : table.values.shape[2]] = table.values
        return basis

    def evaluate(self, control: RealArray, n_derivatives: int, out: RealArray) -> None:
        """Evaluate functions; shapes as in `ClassTables.evaluate`."""
        basis = self._basis[:, :n_derivatives].reshape(
            len(self._basis), n_derivatives * self.n_points, -1
        )
        out[:] = (basis @ np.ascontiguousarray(control.T)).T

    def flux_sums(self, fluxes: RealArray, out: RealArray) -> None:
        """Integrate fluxes along gradients; shapes as in `ClassTables.flux_sums`."""
        n_triangles = len(self._basis)
        weighted = (fluxes * self.weights).reshape(len(fluxes), -1, n_triangles)
        gradients = self._basis[:, 1:3].reshape(n_triangles, 2 * self.n_points, -1)
        out[:] = (gradients.swapaxes(1, 2) @ np.ascontiguousarray(weighted.T)).T

    def local_matrices(self, coefficients: RealArray, terms: slice, out: RealArray) -> None:
        """Integrate products; as `ClassTables.local_matrices`."""
        sum_products(self._basis[:, :3], coefficients * self.weights, terms, self.pairs, out)
