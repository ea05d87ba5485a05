"""Conjugate gradients with diagonal preconditioning, for the three coordinates at once."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from .errors import SolverError
from .parallel import n_threads, ordered_map

FloatArray = NDArray[np.float64]

# Rounding alone leaves a residual of some machine epsilons of the terms that cancel in A x; asking
# for less would never end.
ATTAINABLE = 64 * np.finfo(np.float64).eps

# Below this number of entries starting threads costs more than it saves.
SMALLEST_SHARED_PRODUCT = 500_000


@dataclass(frozen=True)
class SolveReport:
    """How a linear solve ended.

    Attributes
    ----------
    iterations : int
    residual : float
        |b - A x| / |b| in the norm of the inverse diagonal, over all coordinates together.
    converged : bool
        Whether the residual is below the tolerance, or as small as rounding lets it be.
    """

    iterations: int
    residual: float
    converged: bool


def conjugate_gradients(
    matrix: sparse.csr_array,
    right_side: FloatArray,
    start: FloatArray,
    *,
    is_held: NDArray[np.bool_],
    tolerance: float,
    max_iterations: int,
) -> tuple[FloatArray, SolveReport]:
    """Solve matrix @ x = right_side with x = start on the held rows.

    The columns are one system with the block diagonal matrix (A, A, A), so the result does not
    depend on the choice of the coordinate axes.

    Parameters
    ----------
    matrix : (n, n) csr_array
        Symmetric, positive definite on the rows that are not held.
    right_side, start : (n, k)
    is_held : (n,) bool
        Rows whose unknowns keep their start value exactly; their equations are dropped.
    tolerance : float
        Bound for the residual of the report.
    max_iterations : int

    Returns
    -------
    x : (n, k), SolveReport

    Raises
    ------
    SolverError
        If the system has entries that are not finite, or proves not to be positive definite.

    Source: the paper, after (3.4): conjugate gradients with a diagonal preconditioning.
    """
    if not (np.isfinite(right_side).all() and np.isfinite(matrix.data).all()):
        raise SolverError("the linear system has entries that are not finite numbers")
    diagonal = matrix.diagonal()
    free = ~is_held
    bad = int(np.count_nonzero(diagonal[free] <= 0))
    if bad:
        raise SolverError(f"the linear system is not positive definite: {bad} diagonal entries ≤ 0")
    # Zero on the held rows: the search directions never leave the free ones.
    inverse = np.zeros(len(diagonal))
    inverse[free] = 1 / diagonal[free]

    blocks = _RowBlocks(matrix)
    columns = np.ascontiguousarray(start.T)
    residual = np.ascontiguousarray(right_side.T) - blocks.product(columns)
    reference = np.sqrt(np.sum(inverse * np.square(right_side.T)))
    floor = ATTAINABLE * np.sqrt(np.sum(diagonal * free * np.square(columns)))
    target = max(tolerance * reference, floor)

    update, scratch = np.zeros_like(columns), np.empty_like(columns)
    preconditioned = inverse * residual
    direction = preconditioned.copy()
    square = float(np.vdot(residual, preconditioned))
    # pᵀDp with the diagonal D: the size of the terms that may cancel in pᵀAp.
    direction_size = square
    is_exhausted = False
    iterations = 0
    while np.sqrt(square) > target and iterations < max_iterations:
        image = blocks.product(direction)
        curvature = float(np.vdot(direction, image))
        if abs(curvature) <= ATTAINABLE * direction_size:
            # What is left are motions that the matrix does not see at this precision.
            is_exhausted = True
            break
        if not curvature > 0:
            raise SolverError(
                f"the linear system is not positive definite: pᵀAp = {curvature:g} in iteration "
                f"{iterations + 1}, residual {np.sqrt(square) / reference:.3g}"
            )
        step = square / curvature
        update += np.multiply(direction, step, out=scratch)
        residual -= np.multiply(image, step, out=scratch)
        np.multiply(inverse, residual, out=preconditioned)
        square, previous = float(np.vdot(residual, preconditioned)), square
        direction *= square / previous
        direction += preconditioned
        # Preconditioned residual and last direction are orthogonal with respect to D.
        direction_size = square + (square / previous) ** 2 * direction_size
        iterations += 1
    if not np.isfinite(square):
        raise SolverError(
            f"conjugate gradients diverged after {iterations} iterations: residual {square:g}"
        )
    size = np.sqrt(square)
    report = SolveReport(
        iterations=iterations,
        residual=float(size / reference) if reference > 0 else 0.0,
        converged=bool(size <= target) or is_exhausted,
    )
    return start + update.T, report


class _RowBlocks:
    """A matrix as horizontal strips of equal numbers of entries, multiplied by several threads."""

    def __init__(self, matrix: sparse.csr_array) -> None:
        n_rows, n_columns = matrix.shape
        n_strips = n_threads() if matrix.nnz >= SMALLEST_SHARED_PRODUCT else 1
        shares = np.linspace(0, matrix.nnz, n_strips + 1)
        bounds = np.searchsorted(matrix.indptr, shares)
        bounds[0], bounds[-1] = 0, n_rows
        self._strips = []
        for first, last in pairwise(bounds.tolist()):
            begin, end = matrix.indptr[first], matrix.indptr[last]
            pointers = matrix.indptr[first : last + 1] - begin
            entries = (matrix.data[begin:end], matrix.indices[begin:end], pointers)
            strip = sparse.csr_array(entries, shape=(last - first, n_columns))
            self._strips.append((slice(first, last), strip))

    def product(self, columns: FloatArray) -> FloatArray:
        """Multiply by (k, n) columns, one after the other: faster than scipy's block product."""
        result = np.empty_like(columns)

        def fill(rows_and_strip: tuple[slice, sparse.csr_array]) -> None:
            rows, strip = rows_and_strip
            for column, out in zip(columns, result, strict=True):
                out[rows] = strip @ column

        for _ in ordered_map(fill, self._strips):
            pass
        return result
