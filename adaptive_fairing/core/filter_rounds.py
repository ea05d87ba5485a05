"""The filters of `auto`, round by round, and which of them may be used."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .filter_bank import GENTLE, STEEP, FilterFamily
from .lifted_metric import LiftedMetric

FloatArray = NDArray[np.float64]

# Filters of each round, in metrics of the mixture of the rounds before it.  The angles are for
# noise of `COARSE_NOISE` or more; with less noise the normals are less disturbed, and smaller
# angles tell creases from it.
ROUNDS = (
    (
        FilterFamily(LiftedMetric(0), STEEP),
        FilterFamily(LiftedMetric(1), STEEP),
        FilterFamily(LiftedMetric(1, 0.3), GENTLE),
    ),
    (
        FilterFamily(LiftedMetric(0, 0.07), GENTLE),
        FilterFamily(LiftedMetric(0, 0.3), STEEP),
        FilterFamily(LiftedMetric(1, 0.3), STEEP),
    ),
    (FilterFamily(LiftedMetric(0, 0.035), GENTLE),),
)
FAMILIES = tuple(family for families in ROUNDS for family in families)
COARSE_NOISE = 0.2
LEAST_ANGLE_FACTOR = 0.1

# Angle of each filter.  With at most `SHARP_ANGLE` it keeps creases, without one (inf) it rounds
# them; those between keep what stands out of the noise.
ANGLES = np.repeat(
    [np.inf if f.metric.angle is None else f.metric.angle for f in FAMILIES],
    [len(f.diffusions) for f in FAMILIES],
)
SHARP_ANGLE = 0.1
KEEPS_CREASES = ANGLES <= SHARP_ANGLE
USABLE = {"auto": ANGLES > 0, "sharp": KEEPS_CREASES, "smooth": np.isinf(ANGLES)}


def rounds_for(noise: FloatArray) -> list[list[FilterFamily]]:
    """Scale the angles of all rounds' metrics to the noise, (n,), of the vertices judged."""
    typical = float(np.median(noise[noise > 0])) if noise.any() else 0.0
    factor = float(np.clip(typical / COARSE_NOISE, LEAST_ANGLE_FACTOR, 1))

    def scaled(metric: LiftedMetric) -> LiftedMetric:
        return metric if metric.angle is None else metric._replace(angle=factor * metric.angle)

    return [
        [family._replace(metric=scaled(family.metric)) for family in families]
        for families in ROUNDS
    ]
