"""Conjugate gradients with diagonal preconditioning, for the three coordinates at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ..errors import SolverError
from ..runtime.arrays import BoolArray, FloatArray, RealArray
from ..runtime.precision import SINGLE
from ..runtime.threads import chunks, for_each, ordered_map

# The terms of A x are rounded to some machine epsilons, so no residual gets smaller than that.
ATTAINABLE = 64  # machine epsilons

# Unknowns per column that one thread updates in one go.
UNKNOWNS_PER_CHUNK = 32768


class Operator(Protocol):
    """A symmetric matrix, as `SymmetricMatrix` and `EdgeMatrix`."""

    @property
    def is_single(self) -> bool:
        """Whether the entries are in single precision."""
        ...

    def doubled(self) -> Operator:
        """Return the same entries in double precision."""
        ...

    def diagonal(self) -> RealArray:
        """Entries on the diagonal, (n,)."""
        ...

    def is_finite(self) -> bool:
        """Whether all entries are finite numbers."""
        ...

    def product(self, columns: RealArray) -> RealArray:
        """Multiply by vectors (k, n)."""
        ...


@dataclass(frozen=True)
class SolveReport:
    """Report of a linear solve.

    Attributes
    ----------
    iterations : int
    residual : float
        |b - A x| / |b| in the norm of the inverse diagonal, over all coordinates together; for a
        step b is M X(0), the right side of (3.3), with the origin amid the vertices.
    converged : bool
        Whether the residual is below the tolerance, or as small as rounding lets it be.
    """

    iterations: int
    residual: float
    converged: bool


def conjugate_gradients(
    matrix: Operator,
    right_side: FloatArray,
    start: FloatArray | None = None,
    *,
    is_held: BoolArray,
    tolerance: float,
    max_iterations: int,
    relative_to: FloatArray | None = None,
) -> tuple[FloatArray, SolveReport]:
    """Solve matrix @ x = right_side with x = start, or 0, on the held rows.

    The columns are one system with the block diagonal matrix (A, A, A), so the result does not
    depend on the choice of the coordinate axes.  A matrix in single precision is solved with in
    single precision, unless the residual is to fall by more than that can tell.

    Parameters
    ----------
    matrix : Operator, (n, n)
        Positive definite on the rows that are not held.
    right_side, start : (n, k)
        Without a start, which large solves have no room for, it is 0.
    is_held : (n,) bool
        Rows whose unknowns keep their start value exactly; their equations are dropped.
    tolerance : float
        Bound for the residual of the report.  The last step goes only as far as that, so that the
        result follows the data continuously.
    max_iterations : int
    relative_to : (n, k), optional
        What the residual is measured by, instead of `right_side`.

    Returns
    -------
    x : (n, k), SolveReport

    Raises
    ------
    SolverError
        If the system has entries that are not finite, or proves not to be positive definite.

    Source: the paper, after (3.4): conjugate gradients with a diagonal preconditioning.
    """
    if not (np.isfinite(right_side).all() and matrix.is_finite()):
        raise SolverError("the linear system has entries that are not finite numbers")
    diagonal = matrix.diagonal()
    free = ~is_held
    bad = int(np.count_nonzero(diagonal[free] <= 0))
    if bad:
        raise SolverError(f"the linear system is not positive definite: {bad} diagonal entries ≤ 0")
    # Zero on the held rows: the search directions never leave the free ones.
    inverse = np.zeros_like(diagonal)
    inverse[free] = 1 / diagonal[free]

    # Most solves start at 0, whose product is known.
    columns = None if start is None or not start.any() else np.ascontiguousarray(start.T)
    right_columns = np.ascontiguousarray(right_side.T)
    reference = _size(right_columns if relative_to is None else relative_to.T, inverse)
    residual = right_columns.copy() if columns is None else right_columns - matrix.product(columns)
    first_size = _size(residual, inverse)
    if matrix.is_single and not SINGLE.serves_solve(first_size, tolerance * reference):
        matrix, inverse = matrix.doubled(), inverse.astype(np.float64)
        residual = (
            right_columns.copy() if columns is None else right_columns - matrix.product(columns)
        )
    attainable = ATTAINABLE * np.finfo(inverse.dtype).eps
    start_size = 0.0 if columns is None else _size(columns, diagonal * free)
    target = max(tolerance * reference, attainable * start_size)

    # The caller may not need the right side any more, either.
    del columns, right_columns, right_side  # as large as each of the vectors of the iteration
    state = _State(residual.astype(inverse.dtype, copy=False), inverse)
    square = state.square()
    # pᵀDp with the diagonal D: the size of the terms that may cancel in pᵀAp.
    direction_size = square
    has_converged = False
    iterations = 0
    while np.sqrt(square) > target and iterations < max_iterations:
        image = matrix.product(state.direction)
        curvature = state.along(image)
        if abs(curvature) <= attainable * direction_size:
            # The rest of the residual lies in the kernel of A, as far as this precision tells.
            has_converged = True
            break
        if not curvature > 0:
            raise SolverError(
                f"the linear system is not positive definite: pᵀAp = {curvature:g} in iteration "
                f"{iterations + 1}, residual {np.sqrt(square) / reference:.3g}"
            )
        step = square / curvature
        square, previous = state.advance(step, image), square
        iterations += 1
        before, after = np.sqrt(previous), np.sqrt(square)
        if after <= target:
            # Only as far as the residual has to fall: one iteration more or less is no leap.
            has_converged = True
            part = (before - target) / (before - after)
            state.retreat((1 - part) * step)
            # Residuals of successive iterations are orthogonal.
            square = part**2 * square + (1 - part) ** 2 * previous
            break
        state.turn(square / previous)
        # Preconditioned residual and last direction are orthogonal with respect to D.
        direction_size = square + (square / previous) ** 2 * direction_size
    if not np.isfinite(square):
        raise SolverError(
            f"conjugate gradients diverged after {iterations} iterations: residual {square:g}"
        )
    size = np.sqrt(square)
    report = SolveReport(
        iterations=iterations,
        residual=float(size / reference) if reference > 0 else 0.0,
        converged=bool(size <= target) or has_converged,
    )
    update = state.update.T
    return update if start is None else start + update, report


def _size(columns: FloatArray, weights: RealArray) -> float:
    """Norm of vectors (k, n) with a weight for every row of the system."""
    return float(np.sqrt(np.einsum("n,kn,kn->", weights, columns, columns)))


class _State:
    """The vectors of the iteration, changed chunk by chunk: each is read once while in the cache.

    Sums over a chunk are in the precision of the vectors, those over the chunks in double.

    Attributes
    ----------
    update, direction : (k, n)
        What to add to the start; and the search direction.
    """

    def __init__(self, residual: RealArray, inverse: RealArray) -> None:
        self._residual, self._inverse = residual, inverse
        self.update = np.zeros_like(residual)
        self.direction = inverse * residual
        self._chunks = chunks(len(inverse), UNKNOWNS_PER_CHUNK)

    def square(self) -> float:
        """Squared norm of the residual, in the first iteration."""
        return self.along(self._residual)

    def along(self, vectors: RealArray) -> float:
        """Scalar product of vectors (k, n) with the direction."""

        def of_chunk(chunk: slice) -> float:
            return float(np.einsum("kn,kn->", vectors[:, chunk], self.direction[:, chunk]))

        return sum(ordered_map(of_chunk, self._chunks))

    def advance(self, step: float, image: RealArray) -> float:
        """Go along the direction, whose image is A p; return the residual's squared norm."""

        def of_chunk(chunk: slice) -> float:
            residual, direction = self._residual[:, chunk], self.direction[:, chunk]
            scratch = step * direction
            self.update[:, chunk] += scratch
            residual -= np.multiply(image[:, chunk], step, out=scratch)
            np.multiply(self._inverse[chunk], residual, out=scratch)
            return float(np.einsum("kn,kn->", residual, scratch))

        return sum(ordered_map(of_chunk, self._chunks))

    def retreat(self, step: float) -> None:
        """Take back a part of the last step; the residual stays as it was."""

        def of_chunk(chunk: slice) -> None:
            self.update[:, chunk] -= step * self.direction[:, chunk]

        for_each(of_chunk, self._chunks)

    def turn(self, factor: float) -> None:
        """Make the next direction: the preconditioned residual and `factor` times the last one."""

        def of_chunk(chunk: slice) -> None:
            direction = self.direction[:, chunk]
            direction *= factor
            direction += self._inverse[chunk] * self._residual[:, chunk]

        for_each(of_chunk, self._chunks)
