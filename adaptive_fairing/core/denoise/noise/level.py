"""How strong the noise of a mesh is, told from the mesh alone."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linprog

from ...runtime.arrays import BoolArray, FloatArray

# Roughness of this size, in local edge lengths, is what clean meshes have.
CLEAN_ROUGHNESS = 0.04

# The median of |x| for a normal distribution of unit variance.
NORMAL_MEDIAN = 0.6744897501960817

MOST_BINS = 5
VERTICES_PER_BIN = 400

# Features raise the level of some bins, and a flat part or a rim may lower one: the noise is taken
# to be above this share of the bins.
SHARE_BELOW = 0.3

# The lowest of up to three estimates with a standard error of 1, and the second lowest of four or
# five, is on average so much too low; and the standard error of the median absolute deviation of n
# values, times √n and relative.
LEAST_OF = (0.0, 0.0, 0.564, 0.846, 0.297, 0.495)
MEDIAN_ERROR = 1.167

# How much nearer to each bin, relative to the median variance, the second kind of noise must come
# to be told from chance.
WORTHWHILE = 0.06


def noise_level(rough: FloatArray, size: FloatArray, is_counted: BoolArray) -> FloatArray:
    """Estimate the standard deviation of the noise along the normals, in local edge lengths.

    Medians do not see the features in the roughness.  Noise of neighbours that is alike (scanners,
    contoured volumes) is smooth in part and is under-estimated.

    Parameters
    ----------
    rough : (n,)
        See `roughness`.
    size : (n,)
        Logarithm of the local edge length, smooth.
    is_counted : (n,) bool
        Vertices to judge from; the level is given for them, as a function of the spacing.

    Returns
    -------
    (n,)
        0 where it is not counted.

    Source: median absolute deviation, after D. Donoho and I. Johnstone, Ideal spatial adaptation
    by wavelet shrinkage, 1994.
    """
    level = np.zeros(len(rough))
    chosen = np.flatnonzero(is_counted)
    if len(chosen) == 0:
        return level
    size = size[chosen]
    n_bins = int(np.clip(len(chosen) // VERTICES_PER_BIN, 1, MOST_BINS))
    order = np.array_split(np.argsort(size, kind="stable"), n_bins)
    centres = np.array([np.median(size[members]) for members in order])
    levels = np.array([np.median(rough[chosen[members]]) for members in order]) / NORMAL_MEDIAN
    levels *= 1 + LEAST_OF[n_bins] * MEDIAN_ERROR / np.sqrt([len(members) for members in order])
    constant, uniform = _low_fit(np.exp(-2 * centres), np.square(levels))
    level[chosen] = np.sqrt(constant + uniform * np.exp(-2 * size))
    return level


def _low_fit(inverse_square: FloatArray, variance: FloatArray) -> FloatArray:
    """Fit variance = a + b / h² with a, b ≥ 0 at a low quantile, (2,).

    Noise grows with the edges (a) or has one amplitude for the whole mesh (b); features make parts
    of a mesh look noisier than they are.

    Source: R. Koenker and G. Bassett, Regression quantiles, 1978.
    """
    both, distance = _quantile_fit(np.stack([np.ones_like(variance), inverse_square]), variance)
    (constant,), constant_distance = _quantile_fit(np.ones((1, len(variance))), variance)
    if constant_distance - distance > WORTHWHILE * len(variance):
        return both
    least = float(variance.min())
    # Noise is everywhere: where a part is clean, the others have features.
    return np.array([least if least <= CLEAN_ROUGHNESS**2 else constant, 0.0])


def _quantile_fit(terms: FloatArray, variance: FloatArray) -> tuple[FloatArray, float]:
    """Factors ≥ 0 of terms (k, n) for which `SHARE_BELOW` of the values lie below, and the loss."""
    # Flat meshes have no variance at all, or that of rounding: no scale for a linear program.
    typical = max(float(np.median(variance)), CLEAN_ROUGHNESS**2)
    largest = terms.max(axis=1)
    n_terms, n = terms.shape
    above, below = np.full(n, SHARE_BELOW), np.full(n, 1 - SHARE_BELOW)
    solution = linprog(
        np.concatenate([np.zeros(n_terms), above, below]),
        A_eq=np.hstack([(terms / largest[:, None]).T, np.eye(n), -np.eye(n)]),
        b_eq=variance / typical,
    )
    factors: FloatArray = solution.x[:n_terms] / (largest / typical)
    return factors, float(solution.fun)


def beyond_clean(level: FloatArray) -> FloatArray:
    """Take off what clean meshes have: what remains is to be removed."""
    return np.maximum(level**4 - CLEAN_ROUGHNESS**4, 0) ** 0.25
