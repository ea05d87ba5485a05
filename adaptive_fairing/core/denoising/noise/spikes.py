"""Impulsive noise: single vertices that stand far out of what is around them.

Filters spread a spike over its neighbours, so spikes are put back first.  A vertex is a spike if it
lies far from every straight line between opposite neighbours, and further than its neighbours do.
It moves onto the nearest of those lines.  Where the surface bends, its neighbours stand out too,
and it keeps as much height as they have.  A vertex on a crease lies on the line along the crease,
so it is not a spike.  Beside a spike it stands out, but if it moved, the others of the crease would
stand out in turn: it stays.

A vertex near a limit is a spike in part, and goes that part of the way.  What rounding decides
should change nothing.

Spikes occur side by side, so the first position of one depends on neighbours that are still spikes.
In the end all vertices that were moved settle together.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq
from scipy.special import ndtr

from ...runtime.arrays import BoolArray, FloatArray
from ..parameters import parameters
from .contrast import OppositeLines
from .noisy_surface import NoisySurface
from .own_numbers import LINE_NOISE, PROBE

# Around a limit, relative to it, a vertex is put back in part.  With 0.3 a clean model moved.
DOUBT = 0.15

# So is a vertex that stands out at least this part as far as the neighbour that does most.  With
# 0.85 more of many spikes was left.
HIGHEST = 0.95

# With so many spikes, a law is corrected by the root of the factor by which it is wrong about known
# ones: few tell little.  The factor is at least this.
FEW = 200
LEAST_TOLD = 0.5


def is_impulsive(surface: NoisySurface, level: FloatArray, is_counted: BoolArray) -> bool:
    """Whether the noise is impulsive or has heavy tails.

    It compares the ratio of the largest to the median deviation from the smoothest lines with that
    of normal noise on this mesh.  A spike hardly changes this measure at its neighbours, and
    creases do not raise it.

    Parameters
    ----------
    surface : NoisySurface
    level : (n,)
        Level of the noise, in local edge lengths.
    is_counted : (n,) bool
        Vertices to judge from.
    """
    tuned, lines = parameters(), surface.lines
    if not is_counted.any():
        return False
    size = (lines.least / np.maximum(level, 1e-9))[is_counted]
    ratio = _tail(size) / max(_tail(lines.least_of_noise[is_counted]), 1e-9)
    chance = tuned.clear_deviations / np.sqrt(len(size))
    return ratio > tuned.normal_ratio + chance


def _tail(size: FloatArray) -> float:
    median, tail = np.quantile(size, (0.5, parameters().tail_quantile))
    return float(tail / median) if median > 0 else 0.0


def without_spikes(
    surface: NoisySurface, is_counted: BoolArray, may_move: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Put spikes back onto the lines through their neighbours.

    Parameters
    ----------
    surface : NoisySurface
    is_counted : (n,) bool
        Vertices from which the usual deviation is judged.
    may_move : (n,) bool
        Vertices that may be spikes, on boundaries too.

    Returns
    -------
    positions : (n, 3)
    spikes : (n,)
        How far each vertex is a spike, 0 to 1.
    """
    return _put_back(surface, surface.positions, is_counted, may_move)


def _put_back(
    surface: NoisySurface, positions: FloatArray, is_counted: BoolArray, may_move: BoolArray
) -> tuple[FloatArray, FloatArray]:
    tuned = parameters()
    topology, frame = surface.topology, surface.frame
    lines = OppositeLines(frame)
    unit = np.median(surface.lines.least_of_noise[is_counted])
    result = positions.copy()
    centre = np.repeat(np.arange(topology.n_vertices), topology.ring_size)
    spikes, tiny = np.zeros(len(result)), np.finfo(float).tiny
    for _ in range(tuned.rounds):
        height = lines.least_deviation(result)
        size = np.where(may_move, np.abs(height), 0)
        level = max(float(np.median(size[is_counted])), tuned.clean_roughness * unit)
        limit = tuned.clear_deviations * level / unit
        around = np.zeros(len(result))
        np.maximum.at(around, centre, size[topology.ring])
        stands_out = np.interp(size / limit, (1 - DOUBT, 1 + DOUBT), (0, 1))
        is_highest = np.interp(size / np.maximum(around, tiny), (HIGHEST, 1), (0, 1))
        part = stands_out * is_highest
        calm = 1 - stands_out
        above = height - frame.mean @ (height * calm) / np.maximum(frame.mean @ calm, 1e-9)
        # What disturbs its neighbours more than it helps is no spike, but part of a crease.
        trial = result - frame.raised(part * above)
        change = np.abs(lines.least_deviation(trial)) - np.abs(height)
        disturbed = topology.ring_size * (frame.mean @ change) / np.maximum(-change, 1e-9)
        part *= np.interp(disturbed / tuned.most_disturbed, (1 - DOUBT, 1 + DOUBT), (1, 0))
        if not part.any():
            break
        result -= frame.raised(part * above)
        spikes = np.maximum(spikes, part)
    for _ in range(tuned.rounds):
        height = lines.least_deviation(result)
        # Half of the way: neighbours move at the same time.
        result -= frame.raised(spikes * (height - frame.mean @ height) / 2)
    return result, spikes


class KnownNoise(NamedTuple):
    """Vertices of known heights over the slightly smoothed surface, which were put back.

    Attributes
    ----------
    heights, moved : (n,)
        Their heights and how far they were put back, along the normals, in local edge lengths.
    spikes : (n,)
        How far each vertex was taken for a spike, 0 to 1.
    """

    heights: FloatArray
    moved: FloatArray
    spikes: FloatArray

    def variance_left(self, is_counted: BoolArray) -> float:
        """Mean square of what is left at vertices, (n,) bool."""
        return float(np.mean(np.square(self.heights - self.moved)[is_counted]))


def put_back_of(
    heights: FloatArray, calm: NoisySurface, is_counted: BoolArray, may_move: BoolArray
) -> KnownNoise:
    """Put vertices of known heights (n,) back; other parameters are those of `left_of_spikes`."""
    frame = calm.frame
    noisy = frame.positions + frame.raised(heights)
    positions, spikes = _put_back(calm, noisy, is_counted, may_move)
    return KnownNoise(heights, frame.along_normal(noisy - positions), spikes)


def left_of_spikes(
    calm: NoisySurface,
    moved: FloatArray,
    spikes: FloatArray,
    other: KnownNoise,
    is_counted: BoolArray,
    may_move: BoolArray,
) -> tuple[FloatArray, float]:
    """Tell what spikes leave behind when they are put back, by doing it to spikes that are known.

    Low spikes do not stand out, and those that do come to lie on lines through noisy neighbours.
    So noise and spikes like those that were found are laid on the slightly smoothed surface.

    Parameters
    ----------
    calm : NoisySurface
        After spikes were put back.
    moved : (n,)
        How far they were, along the normals, in local edge lengths.
    spikes : (n,)
        How far each vertex was a spike, 0 to 1.
    other : KnownNoise
        Noise like that which is left besides.
    is_counted, may_move : (n,) bool
        As of `without_spikes`.

    Returns
    -------
    noise : (n,)
        Heights of all known noise in local edge lengths.
    more : float
        By how much its spikes, put back, make the variance of the noise larger.
    """
    size, part = spike_law(np.abs(moved[is_counted]), spikes[is_counted])
    is_hit = may_move & (calm.own.phases(PROBE) < part)
    noise = other.heights + np.where(is_hit, size * calm.own.noise(LINE_NOISE), 0)
    known = put_back_of(noise, calm, is_counted, may_move)
    more = max(known.variance_left(is_counted) - other.variance_left(is_counted), 0.0)
    if not part > 0:
        return noise, more
    # What the law tells of spikes that are known tells how far it is wrong, if they are not few.
    size_told, part_told = spike_law(np.abs(known.moved[is_counted]), known.spikes[is_counted])
    wrong = size_told**2 * part_told / (size**2 * part)
    n_spikes = spikes[is_counted].sum()
    return noise, more / max(wrong, LEAST_TOLD) ** (n_spikes / (n_spikes + FEW))


def spike_law(moved: FloatArray, spikes: FloatArray) -> tuple[float, float]:
    """Fit normal-distributed spikes to those that were found, the low ones of which are missing.

    Parameters
    ----------
    moved, spikes : (n,)
        How far they were, and how far each vertex was one, 0 to 1.

    Returns
    -------
    size, part
        Standard deviation of all spikes, and the part of the vertices that they hit.  The mean of
        the higher half of what was found tells the one, their number the other.
    """
    order = np.argsort(-moved)
    # What is less than half a spike may be noise.
    found, weights = moved[order], np.clip(2 * spikes[order] - 1, 0, 1)
    half = weights.sum() / 2
    before = np.cumsum(weights) - weights
    least = float(np.interp(half, before + weights / 2, found))
    if not least > 0:
        return 0.0, 0.0
    # One half exactly: a vertex more or less is no leap.
    mean = float(np.clip(half - before, 0, weights) @ found / half)

    def mean_beyond(x: float) -> float:
        """Mean of the normal deviates beyond x, over x: their density over their probability."""
        return float(np.exp(-(x**2) / 2) / np.sqrt(2 * np.pi) / (x * ndtr(-x)))

    # Spikes of one size have no such law: the nearest one is bounded.
    low, high = 1e-6, 10.0
    excess = float(np.clip(mean / least, mean_beyond(high), mean_beyond(low)))
    at = brentq(lambda x: mean_beyond(x) - excess, low, high)
    part = half / len(moved) / (2 * float(ndtr(-at)))
    return least / at, min(part, 1.0)
