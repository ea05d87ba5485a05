"""The filters of `auto`, round by round, and which of them may be used."""

from __future__ import annotations

import math

import numpy as np

from ..runtime.arrays import FloatArray
from .filter_bank import GENTLE, MESH_FAMILY, STEEP, FilterFamily, NormalFamily
from .lifted_metric import LiftedMetric
from .normal_filter import Smoothing

# Filters of each round besides those of the mesh, in metrics of the mixture of the rounds before
# it, at first in those of the slightly smoothed surface.  The angles of the
# metrics are for noise of `COARSE_NOISE` or more; with less noise the normals are less disturbed,
# and smaller angles tell creases from it.
ROUNDS: tuple[tuple[FilterFamily | NormalFamily, ...], ...] = (
    (FilterFamily(LiftedMetric(1), STEEP),),
    (
        FilterFamily(LiftedMetric(0, 0.3), STEEP),
        FilterFamily(LiftedMetric(1, 0.3), STEEP),
    ),
    (FilterFamily(LiftedMetric(0, 0.035), GENTLE),),
    (
        NormalFamily(
            (Smoothing(math.radians(30), (2, 8)), Smoothing(math.radians(60), (1, 3, 8, 20)))
        ),
    ),
)
FAMILIES = (MESH_FAMILY, *(family for families in ROUNDS for family in families))
COARSE_NOISE = 0.2
LEAST_ANGLE_FACTOR = 0.1

N_FILTERS = [family.n_filters for family in FAMILIES]
KEEPS_CREASES = np.repeat([family.keeps_creases for family in FAMILIES], N_FILTERS)
USABLE = {
    "auto": np.ones(sum(N_FILTERS), dtype=bool),
    "sharp": KEEPS_CREASES,
    "smooth": np.repeat([family.rounds_creases for family in FAMILIES], N_FILTERS),
}


def rounds_for(noise: FloatArray) -> list[list[FilterFamily | NormalFamily]]:
    """Scale the angles of all rounds' metrics to the noise, (n,), of the vertices judged."""
    typical = float(np.median(noise[noise > 0])) if noise.any() else 0.0
    factor = float(np.clip(typical / COARSE_NOISE, LEAST_ANGLE_FACTOR, 1))
    return [[family.scaled(factor) for family in families] for families in ROUNDS]
