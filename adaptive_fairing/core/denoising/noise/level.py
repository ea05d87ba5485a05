"""Level of the noise, estimated from the mesh alone."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linprog
from scipy.special import expit

from ...runtime.arrays import BoolArray, FloatArray, IndexArray
from ..noise_model import VarianceLaw
from ..parameters import parameters
from ..triangle_surface import TriangleSurface
from .contrast import Contrast, half_normal

NORMAL_MEDIAN = half_normal(0.5)

# Entry k: how far an order statistic of k estimates lies below their mean, in standard errors. It
# is the lowest of two or three, the second lowest of four or five.
LEAST_OF = (0.0, 0.0, 0.564, 0.846, 0.297, 0.495)
# Relative standard error of the median absolute deviation of n values, times √n.
MEDIAN_ERROR = 1.167

# Noise has one length if that is likelier by this logarithm per vertex.  Structured light had at
# least 0.020, noise along the sight at most 0.012.  More than this had 14 of 17 fused volumes, and
# 5 of 76 meshes whose noise goes with the edges.  0.0125 and 0.019 gave the same results.
LEAST_GAIN = 0.015

# Cosine of 45 degrees: what is seen more steeply does not tell that.  There a shape bends most, as
# if noise had one length.
FACING = 0.7


def variance_law(contrast: Contrast, is_counted: BoolArray) -> VarianceLaw:
    """Estimate the noise along the normals from the contrasts of vertices, (n,) bool.

    This is an upper bound: quantiles ignore isolated features, but not a shape that bends
    everywhere.  Noise that is correlated at neighbours (scanners, contoured volumes) is
    under-estimated.

    Parameters
    ----------
    contrast : Contrast
    is_counted : (n,) bool
        Vertices to judge from.

    Source: median absolute deviation, after D. Donoho and I. Johnstone, Ideal spatial adaptation
    by wavelet shrinkage, 1994; quantiles, R. Koenker and G. Bassett, Regression quantiles, 1978;
    the choice, G. Schwarz, Estimating the dimension of a model, 1978.
    """
    contrast = contrast.among(is_counted)
    if not len(contrast.value):
        return VarianceLaw(0.0, 0.0)
    bins = _bins(contrast)
    variance = _variances(contrast, bins)
    (constant,) = _quantile_fit(np.ones((1, len(variance))), variance)
    least = float(variance.min())
    # Noise is everywhere: where a part is clean, the others have features.
    alone = least if least <= parameters().clean_roughness ** 2 else float(constant)
    fineness = np.exp([np.median(np.log(contrast.fineness[members])) for members in bins])
    terms = np.stack([np.ones_like(fineness), fineness])
    both = VarianceLaw(*_quantile_fit(terms, variance))
    certainty = _evidence(contrast, bins, both)
    return VarianceLaw(
        certainty * both.per_edge + (1 - certainty) * alone,
        certainty * both.per_length,
    )


def scan_level(
    contrast: Contrast, frame: TriangleSurface, is_counted: BoolArray, cosines: FloatArray
) -> FloatArray:
    """Estimate the noise (n,) of a surface seen along a line of sight, in local edge lengths.

    The length of an edge depends on how steeply the surface was seen, not on the noise.  The noise
    is equally strong everywhere along the normals, like that of a laser, whose errors grow where
    the surface is steep, or along the line of sight: what is likelier.

    Parameters
    ----------
    contrast, frame, is_counted
        As for `variance_law`; at least one contrast is among the counted vertices.
    cosines : (n,)
        Cosines of the angles between normals and line of sight, above 0.
    """
    contrast = contrast.among(is_counted)
    of_length = np.sqrt(contrast.fineness)
    of_sight = cosines[contrast.vertices].mean(axis=1) * of_length
    along_sight = _gain(contrast, contrast.value, of_length, of_sight) > 0
    size = contrast.deviation(contrast.value / (of_sight if along_sight else of_length))
    return size * (cosines if along_sight else 1) / frame.spacing


def has_one_length(
    rough: Contrast, is_counted: BoolArray, cosines: FloatArray | None = None
) -> bool:
    """Whether noise has one length everywhere, instead of going with the edges.

    Or, where a camera saw the surface, instead of being even along the lines of sight.

    Parameters
    ----------
    rough : Contrast
        Roughness, one contrast for every vertex.
    is_counted, cosines
        As for `scan_level`.
    """
    judged = is_counted if cosines is None else is_counted & (cosines > FACING)
    if not judged.any():
        return False
    value, of_length = rough.value[judged], np.sqrt(rough.fineness[judged])
    other = np.ones_like(of_length) if cosines is None else cosines[judged] * of_length
    return _gain(rough, value, other, of_length) > LEAST_GAIN * len(value)


def _variances(contrast: Contrast, bins: list[IndexArray]) -> FloatArray:
    """Variance of the noise in each bin by the quantile, (b,)."""
    levels = np.array([contrast.deviation(contrast.value[members]) for members in bins])
    levels *= 1 + LEAST_OF[len(bins)] * MEDIAN_ERROR / np.sqrt([len(each) for each in bins])
    return np.square(levels)


def _bins(contrast: Contrast) -> list[IndexArray]:
    """Sort the contrasts into bins by the density around them."""
    order = np.argsort(contrast.size, kind="stable")
    n_bins = int(np.clip(len(order) // parameters().fewest_to_tell, 1, len(LEAST_OF) - 1))
    return np.array_split(order, n_bins)


def _evidence(contrast: Contrast, bins: list[IndexArray], both: VarianceLaw) -> float:
    """Probability, 0 to 1, that the noise has one amplitude in part, and not only grows with edges.

    It compares the likelihoods of both models, summed over the contrasts.
    Features may be denser than the rest of a mesh and make the whole of it look so; but not within
    each bin as well, so both must agree.
    """
    everywhere = np.concatenate(bins)
    expected = both.expected(contrast.fineness)
    if not expected[everywhere].all():
        return 0.0

    def gain(members: IndexArray) -> float:
        value = contrast.value[members]
        return _gain(contrast, value, np.ones_like(value), expected[members])

    overall = gain(everywhere) - np.log(len(everywhere)) / 2
    within = sum(gain(members) for members in bins)
    return float(expit(min(overall, within)))


def _gain(contrast: Contrast, value: FloatArray, first: FloatArray, second: FloatArray) -> float:
    """Logarithm by which the deviations `second` (k,) make the values likelier than `first` do."""
    return _unlikelihood(contrast, value, first) - _unlikelihood(contrast, value, second)


def _unlikelihood(contrast: Contrast, value: FloatArray, expected: FloatArray) -> float:
    """Negative log-likelihood of the model with these deviations times the best factor."""
    tuned = parameters()
    ratio = value / expected
    scale = max(contrast.deviation(ratio), tuned.clean_roughness**2)
    each = np.minimum(np.square(ratio / scale) / 2, tuned.most_unlikely) + np.log(scale * expected)
    return float(each.sum())


def _quantile_fit(terms: FloatArray, variance: FloatArray) -> FloatArray:
    """Factors ≥ 0 of terms (k, n) for which `low_quantile` of the values lie below, (k,)."""
    tuned = parameters()
    # Flat meshes have no variance at all, or that of rounding: no scale for a linear program.
    typical = max(float(np.median(variance)), tuned.clean_roughness**2)
    largest = terms.max(axis=1)
    n_terms, n = terms.shape
    above, below = np.full(n, tuned.low_quantile), np.full(n, 1 - tuned.low_quantile)
    solution = linprog(
        np.concatenate([np.zeros(n_terms), above, below]),
        A_eq=np.hstack([(terms / largest[:, None]).T, np.eye(n), -np.eye(n)]),
        b_eq=variance / typical,
    )
    factors: FloatArray = solution.x[:n_terms] / (largest / typical)
    return factors
