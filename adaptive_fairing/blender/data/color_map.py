"""Two colour maps for numbers: one from low to high, one for both sides of zero.

Equal steps of the value look like equal steps of colour, and colour-blind eyes can read both maps.
The first goes from dark violet over green to yellow, so that low values are dark in grey too. The
second goes from blue over near white to red, so that zero is bright. numpy only.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

# The map "viridis" by N. Smith, S. van der Walt and E. Firing (CC0), sampled at 0, 1/20, 2/20, … 1
# and rounded to three decimals; straight lines between the samples stay within 0.014 of it.
ANCHORS = np.array(
    [
        [0.267, 0.005, 0.329],
        [0.279, 0.074, 0.397],
        [0.283, 0.141, 0.458],
        [0.276, 0.201, 0.506],
        [0.254, 0.265, 0.530],
        [0.230, 0.322, 0.546],
        [0.207, 0.372, 0.553],
        [0.184, 0.422, 0.557],
        [0.164, 0.471, 0.558],
        [0.145, 0.519, 0.557],
        [0.128, 0.567, 0.551],
        [0.120, 0.618, 0.536],
        [0.135, 0.659, 0.518],
        [0.191, 0.708, 0.482],
        [0.267, 0.749, 0.441],
        [0.369, 0.789, 0.383],
        [0.478, 0.821, 0.318],
        [0.606, 0.851, 0.237],
        [0.741, 0.873, 0.150],
        [0.876, 0.891, 0.095],
        [0.993, 0.906, 0.144],
    ]
)
ANCHORS.setflags(write=False)

# Made for this program: in the colour space Oklab (B. Ottosson, 2020) the lightness falls evenly
# from 0.95 in the middle to 0.42 at both ends, at the hues 258° and 27°; sampled at -1, -0.8, … 1.
DIVERGING_ANCHORS = np.array(
    [
        [0.089, 0.292, 0.575],
        [0.133, 0.404, 0.782],
        [0.263, 0.533, 0.926],
        [0.453, 0.671, 0.994],
        [0.683, 0.807, 0.991],
        [0.934, 0.934, 0.934],
        [0.976, 0.729, 0.697],
        [0.952, 0.529, 0.485],
        [0.863, 0.350, 0.313],
        [0.716, 0.216, 0.193],
        [0.526, 0.151, 0.134],
    ]
)
DIVERGING_ANCHORS.setflags(write=False)

RANGE_PERCENTILES = (1.0, 99.0)
"""Ends of the colour range: a few extreme vertices must not leave the rest in one colour."""

CURVATURE_PERCENTILES = (5.0, 95.0)
"""The same for curvatures, which as second derivatives have more extremes where there is noise."""

CURVATURE_FIELDS = ("CURVATURE", "GAUSSIAN")
"""Curvatures in the order in which `LimitSurface.refined_curvature` returns them."""

SIGNED_FIELDS = ("REMOVED", *CURVATURE_FIELDS)
"""Fields whose zero matters: they get the map with zero in the middle."""

NO_VALUE = (0.5, 0.5, 0.5)
"""sRGB colour of a value that is not a number."""


def color_range(
    values: ArrayLike, percentiles: tuple[float, float] = RANGE_PERCENTILES
) -> tuple[float, float]:
    """Values of the darkest and the brightest colour; (0, 0) if no value is finite."""
    array = np.asarray(values, dtype=np.float64)
    finite = array[np.isfinite(array)]
    if not len(finite):
        return 0.0, 0.0
    low, high = np.percentile(finite, percentiles)
    return float(low), float(high)


def symmetric_range(
    values: ArrayLike, percentiles: tuple[float, float] = RANGE_PERCENTILES
) -> tuple[float, float]:
    """Values of the end colours with 0 in the middle; (0, 0) if no value is finite."""
    array = np.asarray(values, dtype=np.float64)
    return color_range(np.concatenate([array, -array]), percentiles)


def field_range(field: str, values: ArrayLike) -> tuple[float, float]:
    """Values of the end colours of a field."""
    percentiles = RANGE_PERCENTILES if field not in CURVATURE_FIELDS else CURVATURE_PERCENTILES
    choose = symmetric_range if field in SIGNED_FIELDS else color_range
    return choose(values, percentiles)


def normalized(
    values: ArrayLike, low: float | None = None, high: float | None = None
) -> NDArray[np.float64]:
    """Map values from [low, high] to [0, 1]; values outside take the nearer end.

    Parameters
    ----------
    values
        (n,) numbers; NaN stays NaN.
    low, high
        Ends of the range; None takes the smallest and the largest finite value.

    Returns
    -------
    (n,) array
        0.5 everywhere if the range is a single value.
    """
    values = np.asarray(values, dtype=np.float64)
    finite = values[np.isfinite(values)]
    if len(finite) == 0:
        return np.full(values.shape, np.nan)
    low = float(finite.min()) if low is None else float(low)
    high = float(finite.max()) if high is None else float(high)
    if not high > low:
        return np.where(np.isnan(values), np.nan, 0.5)
    # Halved first, because the difference of two huge values of opposite sign would overflow.
    return np.clip((values / 2 - low / 2) / (high / 2 - low / 2), 0.0, 1.0)


def colors_srgb(
    values: ArrayLike,
    low: float | None = None,
    high: float | None = None,
    anchors: NDArray[np.float64] = ANCHORS,
) -> NDArray[np.float64]:
    """Colour of every value, as shown on a screen.

    Parameters
    ----------
    values, low, high
        As in `normalized`.
    anchors
        (k, 3) sRGB colours of the map, evenly from the low end to the high one.

    Returns
    -------
    (n, 3) array
        sRGB in [0, 1]; `NO_VALUE` where the value is not a number.
    """
    fraction = normalized(values, low, high)
    at = np.linspace(0.0, 1.0, len(anchors))
    known = np.nan_to_num(fraction)
    colors = np.stack([np.interp(known, at, channel) for channel in anchors.T], axis=-1)
    colors[np.isnan(fraction)] = NO_VALUE
    return colors


def srgb_to_linear(colors: ArrayLike) -> NDArray[np.float64]:
    """Decode sRGB into scene-linear light, which is what Blender's float colours hold.

    Source: IEC 61966-2-1.
    """
    colors = np.asarray(colors, dtype=np.float64)
    return np.where(colors <= 0.04045, colors / 12.92, ((colors + 0.055) / 1.055) ** 2.4)
