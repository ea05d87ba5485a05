"""Filters in a Krylov space: all diffusions in one metric from one small space.

Every diffusion in a metric is a function of the same M and L: it multiplies each
eigenvector of M⁻¹L, of eigenvalue λ, by 1 - r(λ), and so removes the fraction r(λ) of it.

One solve with M + t L gives what a step of time t removes, (M + t L)⁻¹ t L x.  What a step removes
of that, and of that again, spans a space.  In this space the Rayleigh-Ritz method finds what all
diffusions remove.  About eight solves give an accuracy of a hundredth; the steps of six diffusions
would take seventy-two, one by one.

Source: shift-and-invert Krylov spaces for functions of matrices, J. van den Eshof and M. Hochbruck,
Preconditioning Lanczos approximations to the matrix exponential, 2006; I. Moret and P. Novati,
RD-rational approximations of the matrix exponential, 2004.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ..runtime.arrays import BoolArray, FloatArray, RealArray
from ..runtime.precision import Precision
from ..runtime.threads import chunks, for_each, ordered_map
from .conjugate_gradients import SolveReport, conjugate_gradients
from .edge_matrix import EdgeMatrix

# Time t of the solves that span the space, in squared edge lengths; between those of the filters.
COMMON_TIME = 1.0

# The first solve is more accurate by this factor: all results inherit its error.  With 0.1 one
# iteration more or less shows in the result of a mesh with tiny edges: its residual is that of the
# large ones.
FIRST_FACTOR = 0.04
MAX_ITERATIONS = 5000
MOST_DIRECTIONS = 24

# Numbers of a vector that one thread works on in one go.
NUMBERS_PER_CHUNK = 65536

# Eigenvalues count as at least this: at 0 nothing is removed, and a ratio would be 0 / 0.
LEAST_EIGENVALUE = 1e-9

# A vector lies in the space, up to rounding, if the length of its part outside is at most this
# fraction of the part inside.
LEAST_OUTSIDE = {np.float64: 1e-9, np.float32: 1e-5}


class Diffusion(NamedTuple):
    """A filter (1 - (1 - S)ᵖ)ᵏ with S = (M + t L)⁻¹ M.

    Attributes
    ----------
    time : float
        t of S, in squared edge lengths.
    order : int
        p.
    steps : int
        k.
    """

    time: float
    order: int
    steps: int

    def removed(self, eigenvalues: FloatArray) -> FloatArray:
        """Fraction of the eigenvectors of M⁻¹L that is removed, for eigenvalues > 0."""
        missing = (self.time * eigenvalues / (1 + self.time * eigenvalues)) ** self.order
        # 1 - (1 - missing)ᵏ without loss of digits where little is missing.
        fraction: FloatArray = -np.expm1(self.steps * np.log1p(-missing))
        return fraction


def removed_by(
    diffusions: Sequence[Diffusion],
    mass: EdgeMatrix,
    stiffness: EdgeMatrix,
    bending: FloatArray,
    is_loose: BoolArray,
    on_solve: Callable[[SolveReport], None],
    tolerance: float = 1e-2,
    precision: Precision = np.float64,
) -> list[RealArray]:
    """Compute what each diffusion removes of x, from L x.

    Parameters
    ----------
    diffusions : sequence of Diffusion
    mass, stiffness : EdgeMatrix, (n, n)
        M and L.
    bending : (n, 3)
        L x.
    is_loose : (n,) bool
        Vertices without a triangle, of which nothing is removed.
    on_solve : callable
        Called after each linear solve with its report.
    tolerance : float
        Relative residual of the solves; and what the last direction of the space may add to the
        results, relative to their size.  Both end in between: results are continuous.
    precision : numpy float type
        Of the space and the results.

    Returns
    -------
    list of (n, 3)
    """
    columns = np.ascontiguousarray(bending.T, dtype=precision)
    mass, stiffness = mass.in_precision(precision), stiffness.in_precision(precision)
    system = mass.plus(COMMON_TIME, stiffness)

    def removed_of(bent: RealArray, residual: float, mass_of: RealArray) -> RealArray:
        """Compute what a step removes of v, (3, n), from L v; the residual is relative to M v."""
        result, report = conjugate_gradients(
            system,
            COMMON_TIME * bent.T,
            is_held=is_loose,
            tolerance=residual,
            max_iterations=MAX_ITERATIONS,
            relative_to=mass_of.T,
        )
        on_solve(report)
        return result.T

    space = _Space(mass, stiffness, precision)
    direction = removed_of(columns, FIRST_FACTOR * tolerance, COMMON_TIME * columns)
    left_before, coefficients_before = 1.0, np.zeros((0, len(diffusions)))
    while space.add(direction):
        coefficients = space.coefficients(diffusions)
        size = np.linalg.norm(coefficients, axis=0)
        left = float((np.abs(coefficients[-1]) / np.maximum(size, np.finfo(float).tiny)).max())
        if left <= tolerance:
            # Only as far as the results have to change, so that one direction more is no leap.
            part = (left_before - tolerance) / (left_before - left)
            coefficients *= part
            coefficients[:-1] += (1 - part) * coefficients_before
            break
        if space.n_directions == MOST_DIRECTIONS:
            break
        left_before, coefficients_before = left, coefficients
        direction = removed_of(space.last_bent, tolerance, space.last_image)
    if not space.n_directions:
        return [np.zeros_like(bending) for _ in diffusions]
    return [combined.T for combined in space.combined(coefficients)]


class _Space:
    """Directions with VᵀMV = I, and what L does to them.

    All coordinates of all vertices are one vector, so that the result does not depend on the choice
    of the coordinate axes.

    Attributes
    ----------
    n_directions : int
    last_bent : (3, n)
        L v for the newest direction v.
    """

    def __init__(self, mass: EdgeMatrix, stiffness: EdgeMatrix, precision: Precision) -> None:
        self._mass, self._stiffness = mass, stiffness
        shape = MOST_DIRECTIONS, 3 * mass.n
        # Only what is used of these becomes memory.
        self._directions, self._images = np.empty(shape, precision), np.empty(shape, precision)
        self._least_outside = LEAST_OUTSIDE[precision]
        self._bending = np.zeros((MOST_DIRECTIONS, MOST_DIRECTIONS))
        self._first_length = 0.0
        self.last_bent: RealArray = np.zeros((3, mass.n), precision)
        self.n_directions = 0

    @property
    def last_image(self) -> RealArray:
        """M v, (3, n), for the newest direction v."""
        newest: RealArray = self._images[self.n_directions - 1].reshape(3, -1)
        return newest

    def add(self, vector: RealArray) -> bool:
        """Add the component of a vector (3, n) outside the space; False if it is negligible."""
        done = self.n_directions
        rest = vector.reshape(1, -1).copy()
        within = 0.0
        for _ in range(2):  # once would let rounding grow tenfold with every direction
            overlaps = _products(self._images[:done], rest[0])
            _add_combined(rest, -overlaps[None], self._directions[:done])
            within += float(overlaps @ overlaps)
        image = self._mass.product(rest.reshape(vector.shape)).reshape(-1)
        square = float(_products(rest, image)[0])
        if not square > self._least_outside**2 * within:
            return False
        length = float(np.sqrt(square))
        np.divide(rest[0], length, out=self._directions[done])
        np.divide(image, length, out=self._images[done])
        if done == 0:
            self._first_length = length
        self.n_directions += 1
        self.last_bent = self._stiffness.product(self._directions[done].reshape(3, -1))
        entries = _products(self._directions[: done + 1], self.last_bent.reshape(-1))
        self._bending[done, : done + 1] = self._bending[: done + 1, done] = entries
        return True

    def coefficients(self, diffusions: Sequence[Diffusion]) -> FloatArray:
        """Coefficients of the directions in what each diffusion removes, (n_directions, k)."""
        n = self.n_directions
        eigenvalues, vectors = np.linalg.eigh(self._bending[:n, :n])
        eigenvalues = np.maximum(eigenvalues, LEAST_EIGENVALUE)
        # The first direction is what one solve with the common time removes.
        already = Diffusion(COMMON_TIME, 1, 1).removed(eigenvalues)
        ratios = np.stack([d.removed(eigenvalues) / already for d in diffusions], axis=1)
        coefficients: FloatArray = self._first_length * (vectors @ (vectors[0][:, None] * ratios))
        return coefficients

    def combined(self, coefficients: FloatArray) -> RealArray:
        """Combine the directions with coefficients (n_directions, k), to (k, 3, n)."""
        directions = self._directions[: self.n_directions]
        result = np.zeros((coefficients.shape[1], directions.shape[1]), directions.dtype)
        _add_combined(result, coefficients.T, directions)
        return result.reshape(len(result), 3, -1)


# Not with matrix products: for vectors of this length OpenBLAS starts threads of its own, which
# compete with those of `ordered_map`, and spin when they have nothing to do.


def _products(rows: RealArray, vector: RealArray) -> FloatArray:
    """Scalar products of `rows` (k, n) with a vector (n,); summed up in double over the chunks."""

    def of_chunk(chunk: slice) -> RealArray:
        products: RealArray = np.einsum("kn,n->k", rows[:, chunk], vector[chunk])
        return products

    parts = ordered_map(of_chunk, chunks(len(vector), NUMBERS_PER_CHUNK))
    return sum(parts, np.zeros(len(rows)))


def _add_combined(result: RealArray, coefficients: FloatArray, rows: RealArray) -> None:
    """Add combinations of `rows` (k, n), with coefficients (j, k), to `result` (j, n)."""
    factors = coefficients.astype(rows.dtype)

    def of_chunk(chunk: slice) -> None:
        result[:, chunk] += np.einsum("jk,kn->jn", factors, rows[:, chunk])

    for_each(of_chunk, chunks(rows.shape[1], NUMBERS_PER_CHUNK))
