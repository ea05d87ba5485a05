"""Noise that is stronger in one place than in another, beyond what the edges explain.

A scanner's noise grows with the distance, or a part of a mesh was denoised before.  Such noise is
white everywhere: around each vertex all kinds of contrasts tell the same strength, and the least of
them counts, as it does for the whole mesh.  A shape that is as rough as noise differs from place to
place as well.  So small differences are chance, noise is not raised where it is as weak as the
detail of clean meshes, and what is removed must look the more like noise: else it counts as even.
"""

from __future__ import annotations

import numpy as np
from scipy.special import ndtri

from ...runtime.arrays import BoolArray, FloatArray
from ..parameters import parameters
from .contrast import Contrast
from .level import NORMAL_MEDIAN
from .noisy_surface import NoisySurface

# Averages over the neighbours, with a look in between: what is even then is even after all of them.
# About three hundred vertices tell the noise around each.
PASSES = 10, 30

# Least and largest part of the contrasts that is below what the noise would leave half of.
LEAST_BELOW, MOST_BELOW = 0.1, 0.98


def unevenness(
    surface: NoisySurface, level: FloatArray, is_counted: BoolArray
) -> FloatArray | None:
    """Compare the contrasts around every vertex with those that a level of noise leaves.

    Parameters
    ----------
    surface : NoisySurface
    level : (n,)
        Standard deviation in local edge lengths; 0 where there is none.
    is_counted : (n,) bool
        Vertices to judge from.

    Returns
    -------
    (n,) or None
        Factor by which the noise is stronger at each vertex, 1 where none was judged; None if it
        is even.
    """
    tuned, judged = parameters(), is_counted & (level > 0)
    if np.count_nonzero(judged) < tuned.fewest_to_tell:
        return None
    kinds = [surface.roughness]
    # Noise that turns triangles over leaves nothing in their hinges.
    if np.median(level[judged]) <= tuned.coarse_noise:
        kinds.append(surface.hinges)
    counts = np.concatenate([_counts(each, level, judged) for each in kinds], axis=1)
    for passes in PASSES:
        for _ in range(passes):
            counts = surface.frame.mean @ counts
        below, total = counts[judged, ::2], counts[judged, 1::2]
        part = np.clip(below / np.maximum(total, np.finfo(float).tiny), LEAST_BELOW, MOST_BELOW)
        changes = np.log(NORMAL_MEDIAN / ndtri((1 + part) / 2)).min(axis=1)
        spread = float(np.var(changes))
        if spread <= tuned.even_spread:
            return None
    changes *= 1 - (tuned.even_spread / spread) ** 2
    above_detail = np.log(level[judged] / tuned.least_roughness) + changes
    changes = np.minimum(changes, np.maximum(above_detail, 0))
    factors = np.ones(len(level))
    factors[judged] = np.exp(changes)
    return factors


def _counts(contrast: Contrast, level: FloatArray, judged: BoolArray) -> FloatArray:
    """Count at each vertex the contrasts below the median of noise, and all of them, (n, 2)."""
    contrast = contrast.among(judged)
    below = contrast.value < NORMAL_MEDIAN * level[contrast.vertices].mean(axis=1)
    counts = np.zeros((len(level), 2))
    for vertices in contrast.vertices.T:
        counts[:, 0] += np.bincount(vertices, below, len(level))
        counts[:, 1] += np.bincount(vertices, minlength=len(level))
    return counts
