"""Mixture of filters for which the unbiased risk estimate (Stein) is least.

Filter k removes e_k from the noisy positions x = x₀ + σ n.  Of the mixtures x - Σ a_k e_k the one
with the least distance to the unknown x₀ minimises

    |Σ a_k e_k|² - 2 Σ a_k σ² div e_k,

whose expectation is the squared distance up to a constant, for normally distributed noise.  The
divergence measures how much of the noise each filter removes.

It has no formula for filters that are not linear, so it is measured by filtering again, with a
little noise added.

The coefficients differ from one density class to another as far as the risk is sure of it.  Few
vertices tell little, and so do many with strong or smooth noise: there the classes have nearly the
same coefficients.

Source: C. Stein, Estimation of the mean of a multivariate normal distribution, 1981; mixtures of
filters after T. Blu and F. Luisier, The SURE-LET approach to image denoising, 2007; coefficients
with a normal distribution, D. V. Lindley and A. F. M. Smith, Bayes estimates for the linear model,
1972.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import nnls

from ..runtime.arrays import FloatArray, IndexArray, IntArray, RealArray
from ..runtime.threads import ordered_map
from .parameters import parameters

# Sums over the vertices are taken over this many at once, which bounds the memory.
VERTICES_AT_ONCE = 16384

# And matrix products over this many: for larger ones OpenBLAS starts threads, for 40 filters or for
# one, and they spin for longer than all of this takes.
VERTICES_PER_PRODUCT = 128

# Relative weights of two terms of the least squares: the first keeps them definite, the second
# keeps the sum of the coefficients at most 1.
RIDGE = 1e-6
CONSTRAINT = 100.0


class Mixture(NamedTuple):
    """Coefficients of k filters, which follow the density classes of each connected part.

    All coefficients at all vertices would be among the largest arrays of a run.

    Attributes
    ----------
    by_class : (p, c, k)
        Coefficients in each class of each part.
    weights : (c, n)
        Weights of the classes at the vertices, with the sum 1.
    part : (n,) int
        Part of each vertex.
    """

    by_class: FloatArray
    weights: RealArray
    part: IntArray

    @property
    def used(self) -> IndexArray:
        """Whether each filter has a coefficient other than 0 anywhere, (k,)."""
        return np.flatnonzero(self.by_class.any(axis=(0, 1)))

    def coefficients(self, index: int) -> RealArray:
        """Coefficients of one filter at the vertices, (n,)."""
        classes = self.by_class[:, :, index].astype(self.weights.dtype)
        # Most meshes are one part, whose classes need no copy for every vertex.
        of_vertex = classes.take(self.part, axis=0) if len(classes) > 1 else classes
        coefficients: RealArray = np.einsum("cn,nc->n", self.weights, of_vertex)
        return coefficients

    def at(self, vertices: IndexArray) -> Mixture:
        """Return the same mixture for some of the vertices, by index."""
        return self._replace(weights=self.weights[:, vertices], part=self.part[vertices])

    def weighted(self, parts: FloatArray) -> Mixture:
        """Return the mixture that removes so much of what this one does in each part, (p,)."""
        return self._replace(by_class=self.by_class * parts[:, None, None])

    def spread(self, is_one: Sequence[bool]) -> Mixture:
        """Return the same mixture among k' filters; (k',) bool says which of them are its own."""
        by_class = np.zeros((*self.by_class.shape[:2], len(is_one)))
        by_class[..., is_one] = self.by_class
        return self._replace(by_class=by_class)


def filter_divergence(
    removed: FloatArray, shadow: FloatArray, probe: FloatArray, size: float
) -> FloatArray:
    """Fraction (n,) of a vertex's own noise that a filter removes; 0 to 1 for white noise.

    It follows from the parts (n,) that the filter removes without and with a probe (n,) added, the
    numbers of which have a root mean square of `size`.  The neighbours' numbers contribute too, but
    cancel in sums over many vertices.

    Source: S. Ramani, T. Blu and M. Unser, Monte-Carlo SURE, 2008.
    """
    relative = probe / size
    divergence = shadow - removed
    divergence *= relative / size
    # Large numbers would count for more than small ones, mostly with the number itself.
    divergence -= np.square(relative) - np.mean(np.square(relative))
    return divergence


def least_risk_coefficients(
    removed: Sequence[RealArray],
    divergence: Sequence[RealArray],
    variances: FloatArray,
    classes: RealArray,
) -> FloatArray:
    """Find the coefficients of the filters in the best mixture.

    Parameters
    ----------
    removed : k of (n,)
        Normal component of the part that each filter removes.
    divergence : k of (n,)
        Its derivative with respect to the noise of the same vertex: 1 if all noise is removed, 0 if
        none is.
    variances : (s, n)
        Variances of the noise, in the squared unit of `removed`; there is a mixture for each.  The
        first is that of the noise as it is, white before it was averaged.
    classes : (c, n)
        Weights of the vertices in each density class, with the sum 1; 0 for vertices that do not
        count.  The coefficients at a vertex are the mean over the classes with these weights.

    Returns
    -------
    (s, c, k)
        Coefficients a ≥ 0 with a sum of at most 1 in each class; the rest is not filtered.
    """
    square, gains = _normal_equations(removed, divergence, variances, classes)
    n_classes, n_filters = len(classes), len(removed)
    n = n_classes * n_filters
    size = float(np.trace(square)) / n
    result = np.zeros((len(variances), n_classes, n_filters))
    if not size > 0:
        return result
    square[np.diag_indices(n)] += RIDGE * size
    square += np.kron(_alikeness(variances[0], classes), np.eye(n_filters))
    # Not numpy's: its OpenBLAS starts threads for matrices as small as this.
    factor = cholesky(square, lower=True)
    # The sum of a class and a slack is 1, as further equations of great weight.
    system = np.zeros((n + n_classes, n + n_classes))
    system[:n, :n] = factor.T
    weight = CONSTRAINT * np.sqrt(size)
    for index in range(n_classes):
        system[n + index, index * n_filters : (index + 1) * n_filters] = weight
        system[n + index, n + index] = weight
    for coefficients, gain in zip(result, gains, strict=True):
        if gain.any():
            seen = solve_triangular(factor, gain, lower=True)
            target = np.concatenate([seen, np.full(n_classes, weight)])
            found, _ = nnls(system, target, maxiter=100 * len(target))
            coefficients[:] = found[:n].reshape(n_classes, n_filters)
    return result


def _alikeness(variance: FloatArray, classes: RealArray) -> FloatArray:
    """Quadratic form (c, c) that draws the coefficients of a filter to their mean over the classes.

    It is that of differences with a normal distribution, if what a mixture leaves has the variance
    of the noise, (n,).
    """
    n_classes = len(classes)
    of_class = classes @ variance / classes.sum(axis=1)
    from_mean = np.eye(n_classes) - 1 / n_classes
    alikeness: FloatArray = from_mean @ (of_class[:, None] * from_mean)
    return alikeness / parameters().class_deviation ** 2


def _normal_equations(
    removed: Sequence[RealArray],
    divergence: Sequence[RealArray],
    variances: FloatArray,
    classes: RealArray,
) -> tuple[FloatArray, FloatArray]:
    """Sum up ⟨e_i, e_j⟩ and σ² div e_i over the vertices, by class: (c k, c k) and (s, c k)."""
    n_classes, n_filters = len(classes), len(removed)
    n = n_classes * n_filters
    pairs = [(i, j) for i in range(n_classes) for j in range(i + 1)]

    def of_some(first: int) -> tuple[FloatArray, FloatArray]:
        square = np.zeros((n_classes, n_filters, n_classes, n_filters))
        gains = np.zeros((n_classes, len(variances), n_filters))
        some = slice(first, first + VERTICES_AT_ONCE)
        weights = classes[:, some].astype(np.float64)
        rows = np.stack([row[some] for row in removed], dtype=np.float64)
        for i, j in pairs:
            weight = weights[i] * weights[j]
            if weight.any():
                square[i, :, j] = _products(weight * rows, rows)
        gain_rows = np.stack([row[some] for row in divergence], dtype=np.float64)
        # The weights go to the variances, which are fewer than the filters.
        for index, weight in enumerate(weights):
            gains[index] = _products(weight * variances[:, some], gain_rows)
        return square, gains

    firsts = range(0, classes.shape[1], VERTICES_AT_ONCE)
    # Not `sum`, which would make a copy for each.
    square = np.zeros((n_classes, n_filters, n_classes, n_filters))
    gains = np.zeros((n_classes, len(variances), n_filters))
    for more_square, more_gains in ordered_map(of_some, firsts):
        square += more_square
        gains += more_gains
    for i, j in pairs:
        square[j, :, i] = square[i, :, j]
    return square.reshape(n, n), gains.swapaxes(0, 1).reshape(-1, n)


def _products(first: FloatArray, second: FloatArray) -> FloatArray:
    """Scalar products of rows (j, n) with others (k, n), added up over small matrix products."""
    whole = first.shape[1] // VERTICES_PER_PRODUCT * VERTICES_PER_PRODUCT
    parts = (r[:, :whole].reshape(len(r), -1, VERTICES_PER_PRODUCT) for r in (first, second))
    left, right = (part.swapaxes(0, 1) for part in parts)
    products: FloatArray = np.matmul(left, right.swapaxes(1, 2)).sum(axis=0)
    return products + first[:, whole:] @ second[:, whole:].T
