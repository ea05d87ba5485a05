"""How strong the noise of a mesh is, told from the mesh alone."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.optimize import linprog
from scipy.special import expit

from ...runtime.arrays import BoolArray, FloatArray, IndexArray
from ..parameters import parameters
from ..triangle_surface import TriangleSurface
from .roughness import Roughness

# The median of |x| for a normal distribution of unit variance.
NORMAL_MEDIAN = 0.6744897501960817

# Entry k: how far an order statistic of k estimates lies below their mean, in standard errors. It
# is the lowest of two or three, the second lowest of four or five.
LEAST_OF = (0.0, 0.0, 0.564, 0.846, 0.297, 0.495)
# Relative standard error of the median absolute deviation of n values, times √n.
MEDIAN_ERROR = 1.167


class NoiseModel(NamedTuple):
    """Noise that grows with the edges, or has one amplitude, or both.

    Attributes
    ----------
    per_edge, per_length : float
        a ≥ 0 and b ≥ 0 of the variance a + b / h² in squared local edge lengths.
    """

    per_edge: float
    per_length: float

    def level(self, spacing: FloatArray) -> FloatArray:
        """Return the standard deviation in local edge lengths where the edges are h long, (n,)."""
        return np.sqrt(self.per_edge + self.per_length / np.square(spacing))

    def expected(self, rough: Roughness) -> FloatArray:
        """Return the standard deviation that the roughness has with this noise, (n,)."""
        return np.sqrt(self.per_edge + self.per_length * rough.fineness)


def noise_model(rough: Roughness, frame: TriangleSurface, is_counted: BoolArray) -> NoiseModel:
    """Estimate the noise along the normals from vertices (n,) bool.

    Medians do not see the features in the roughness.  Noise of neighbours that is alike (scanners,
    contoured volumes) is smooth in part and is under-estimated.

    Parameters
    ----------
    rough : Roughness
    frame : TriangleSurface
    is_counted : (n,) bool
        Vertices to judge from.

    Source: median absolute deviation, after D. Donoho and I. Johnstone, Ideal spatial adaptation
    by wavelet shrinkage, 1994; quantiles, R. Koenker and G. Bassett, Regression quantiles, 1978;
    the choice, G. Schwarz, Estimating the dimension of a model, 1978.
    """
    if not is_counted.any():
        return NoiseModel(0.0, 0.0)
    variance = _variances(rough, _bins(is_counted, frame, frame.spacing))
    (constant,) = _quantile_fit(np.ones((1, len(variance))), variance)
    least = float(variance.min())
    # Noise is everywhere: where a part is clean, the others have features.
    alone = least if least <= parameters().clean_roughness ** 2 else float(constant)
    bins = _bins(is_counted, frame, rough.fineness)
    fineness = np.exp([np.median(np.log(rough.fineness[members])) for members in bins])
    terms = np.stack([np.ones_like(fineness), fineness])
    both = NoiseModel(*_quantile_fit(terms, _variances(rough, bins)))
    certainty = _evidence(rough, bins, both)
    return NoiseModel(
        certainty * both.per_edge + (1 - certainty) * alone, certainty * both.per_length
    )


def scan_level(
    rough: Roughness, frame: TriangleSurface, is_counted: BoolArray, cosines: FloatArray
) -> FloatArray:
    """Estimate the noise of what was seen along a line of sight, in local edge lengths, (n,).

    Edges tell how steeply the surface was seen, but nothing of the noise.  That is as strong
    everywhere along the normals, as a laser's, whose errors grow where the surface is steep; or,
    where the likelihood says so clearly, as strong everywhere along the line of sight.

    Parameters
    ----------
    rough, frame, is_counted
        As for `noise_model`; at least one vertex is counted.
    cosines : (n,)
        Of the angles between normals and line of sight, more than 0.
    """
    tuned, value = parameters(), rough.value[is_counted]
    of_length = np.sqrt(rough.fineness[is_counted])
    of_sight = cosines[is_counted] * of_length
    gain = _unlikelihood(value, of_length) - _unlikelihood(value, of_sight)
    along_sight = gain > tuned.least_gain_of_sight * tuned.dependent_vertices
    expected = of_sight if along_sight else of_length
    size = float(np.median(value / expected)) / NORMAL_MEDIAN
    return size * (cosines if along_sight else 1) / frame.spacing


def _variances(rough: Roughness, bins: list[IndexArray]) -> FloatArray:
    """Variance of the noise in each bin, as its median tells it, (k,)."""
    levels = np.array([np.median(rough.value[members]) for members in bins]) / NORMAL_MEDIAN
    levels *= 1 + LEAST_OF[len(bins)] * MEDIAN_ERROR / np.sqrt([len(each) for each in bins])
    return np.square(levels)


def _bins(is_counted: BoolArray, frame: TriangleSurface, values: FloatArray) -> list[IndexArray]:
    """Sort the counted vertices into bins of values that tell the density, (n,)."""
    tuned = parameters()
    size = frame.spread(np.log(values), tuned.density_passes)
    chosen = np.flatnonzero(is_counted)
    n_bins = int(np.clip(len(chosen) // tuned.vertices_per_bin, 1, len(LEAST_OF) - 1))
    return np.array_split(chosen[np.argsort(size[chosen], kind="stable")], n_bins)


def _evidence(rough: Roughness, bins: list[IndexArray], both: NoiseModel) -> float:
    """Probability, 0 to 1, that the noise has one amplitude in part, and not only grows with edges.

    It compares the likelihoods of both models, summed over the vertices.
    Features may be denser than the rest of a mesh and make the whole of it look so; but not within
    each bin as well, so both must agree.
    """
    tuned = parameters()
    everywhere = np.concatenate(bins)
    expected = both.expected(rough)
    if not expected[everywhere].all():
        return 0.0

    def gain(members: IndexArray) -> float:
        value = rough.value[members]
        per_edge = _unlikelihood(value, np.ones_like(value))
        return (per_edge - _unlikelihood(value, expected[members])) / tuned.dependent_vertices

    overall = gain(everywhere) - np.log(len(everywhere)) / 2
    within = sum(gain(members) for members in bins)
    return float(expit(min(overall, tuned.gain_factor * (within - tuned.least_gain))))


def _unlikelihood(value: FloatArray, expected: FloatArray) -> float:
    """Minus the logarithm of the likelihood, of the model with these deviations times the best."""
    tuned = parameters()
    ratio = value / expected
    scale = max(float(np.median(ratio)) / NORMAL_MEDIAN, tuned.clean_roughness**2)
    each = np.minimum(np.square(ratio / scale) / 2, tuned.most_unlikely) + np.log(scale * expected)
    return float(each.sum())


def _quantile_fit(terms: FloatArray, variance: FloatArray) -> FloatArray:
    """Factors ≥ 0 of terms (k, n) for which `fraction_below` of the values lie below, (k,)."""
    tuned = parameters()
    # Flat meshes have no variance at all, or that of rounding: no scale for a linear program.
    typical = max(float(np.median(variance)), tuned.clean_roughness**2)
    largest = terms.max(axis=1)
    n_terms, n = terms.shape
    above, below = np.full(n, tuned.fraction_below), np.full(n, 1 - tuned.fraction_below)
    solution = linprog(
        np.concatenate([np.zeros(n_terms), above, below]),
        A_eq=np.hstack([(terms / largest[:, None]).T, np.eye(n), -np.eye(n)]),
        b_eq=variance / typical,
    )
    factors: FloatArray = solution.x[:n_terms] / (largest / typical)
    return factors


def beyond_clean(level: FloatArray) -> FloatArray:
    """Take off what clean meshes have: what remains is to be removed."""
    return np.maximum(level**4 - parameters().clean_roughness ** 4, 0) ** 0.25
