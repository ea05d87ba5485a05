"""Impulsive noise: single vertices that stand far out of what is around them.

Filters spread a spike over its neighbours, so spikes are put back first.  A vertex is a spike if it
lies far from every straight line between opposite neighbours, and further than its neighbours do.
It moves onto the nearest of those lines.  Where the surface bends, its neighbours stand out too,
and it keeps as much height as they have.  A vertex on a crease lies on the line along the crease,
so it is not a spike.

Spikes occur side by side, so the first position of one depends on neighbours that are still spikes.
In the end all vertices that were moved settle together.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq
from scipy.special import ndtr

from ...runtime.arrays import BoolArray, FloatArray
from ..parameters import parameters
from .contrast import OppositeLines
from .noisy_surface import NoisySurface
from .own_numbers import LINE_NOISE, SEEDS, WHITE_NOISE


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
    chance = tuned.chance / np.sqrt(len(size))
    return ratio > tuned.normal_ratio + chance


def _tail(size: FloatArray) -> float:
    median, tail = np.quantile(size, (0.5, parameters().tail_quantile))
    return float(tail / median) if median > 0 else 0.0


def without_spikes(surface: NoisySurface, is_counted: BoolArray, may_move: BoolArray) -> FloatArray:
    """Return positions (n, 3) whose spikes lie on the lines through their neighbours.

    Parameters
    ----------
    surface : NoisySurface
    is_counted : (n,) bool
        Vertices from which the usual deviation is judged.
    may_move : (n,) bool
        Vertices that may be spikes, on boundaries too.
    """
    return _put_back(surface, surface.positions, is_counted, may_move)


def _put_back(
    surface: NoisySurface, positions: FloatArray, is_counted: BoolArray, may_move: BoolArray
) -> FloatArray:
    tuned = parameters()
    topology, frame = surface.topology, surface.frame
    lines = OppositeLines(frame)
    unit = np.median(surface.lines.least_of_noise[is_counted])
    result = positions.copy()
    centre = np.repeat(np.arange(topology.n_vertices), topology.ring_size)
    was_moved = np.zeros(len(result), dtype=bool)
    for _ in range(tuned.rounds):
        height = lines.least_deviation(result, lines.passing(result))
        size = np.where(may_move, np.abs(height), 0)
        level = max(float(np.median(size[is_counted])), tuned.clean_roughness * unit)
        limit = tuned.spike_factor * level / unit
        around = np.zeros(len(result))
        np.maximum.at(around, centre, size[topology.ring])
        is_spike = (size > limit) & (size >= around)
        if not is_spike.any():
            break
        is_calm = (size <= limit).astype(float)
        usual = frame.mean @ (height * is_calm) / np.maximum(frame.mean @ is_calm, 1e-9)
        result -= frame.raised(np.where(is_spike, height - usual, 0))
        was_moved |= is_spike
    for _ in range(tuned.rounds):
        height = lines.least_deviation(result, lines.passing(result))
        # Half of the way: neighbours move at the same time.
        result -= frame.raised(np.where(was_moved, (height - frame.mean @ height) / 2, 0))
    return result


def put_back_of(
    heights: FloatArray, calm: NoisySurface, is_counted: BoolArray, may_move: BoolArray
) -> FloatArray:
    """How far vertices of known heights (n,) over the slightly smoothed surface are put back, (n,).

    In local edge lengths; the other parameters are those of `left_of_spikes`.
    """
    frame = calm.frame
    noisy = frame.positions + frame.raised(heights)
    return frame.along_normal(noisy - _put_back(calm, noisy, is_counted, may_move))


def left_of_spikes(
    calm: NoisySurface,
    moved: FloatArray,
    level: FloatArray,
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
        How far they were, along the normals, in local edge lengths; 0 where no spike was.
    level : (n,)
        Standard deviation of the other noise in local edge lengths.
    is_counted, may_move : (n,) bool
        As of `without_spikes`.

    Returns
    -------
    noise : (n,)
        Heights of all known noise in local edge lengths.
    more : float
        By how much its spikes, put back, make the variance of the noise larger.
    """
    size, part = spike_law(np.abs(moved[is_counted]))
    other = level * calm.own.noise(WHITE_NOISE)
    is_hit = may_move & (calm.own.phases(SEEDS) < part)
    noise = other + np.where(is_hit, size * calm.own.noise(LINE_NOISE), 0)

    def left(heights: FloatArray) -> float:
        rest = heights - put_back_of(heights, calm, is_counted, may_move)
        return float(np.mean(np.square(rest[is_counted])))

    return noise, max(left(noise) - left(other), 0.0)


def spike_law(moved: FloatArray) -> tuple[float, float]:
    """Fit normal-distributed spikes to those that were found, the low ones of which are missing.

    Parameters
    ----------
    moved : (n,)
        How far they were; 0 where no spike was.

    Returns
    -------
    size, part
        Standard deviation of all spikes, and the part of the vertices that they hit.  The mean of
        those beyond the median of what was found tells the one, their number the other.
    """
    found = moved[moved > 0]
    if not len(found):
        return 0.0, 0.0
    least = float(np.median(found))
    beyond = found[found >= least]

    def mean_beyond(x: float) -> float:
        """Mean of the normal deviates beyond x, over x: their density over their probability."""
        return float(np.exp(-(x**2) / 2) / np.sqrt(2 * np.pi) / (x * ndtr(-x)))

    # Spikes of one size have no such law: the nearest one is bounded.
    low, high = 1e-6, 10.0
    excess = float(np.clip(beyond.mean() / least, mean_beyond(high), mean_beyond(low)))
    at = brentq(lambda x: mean_beyond(x) - excess, low, high)
    part = len(beyond) / len(moved) / (2 * float(ndtr(-at)))
    return least / at, min(part, 1.0)
