"""Impulsive noise: single vertices that stand far out of what is around them.

Filters spread a spike over its neighbours.  It is taken off first: a vertex that lies far from
every straight line through it, further than its neighbours do, moves onto the nearest of those
lines, but for as much as its neighbours stand out, where the surface bends.  Vertices on creases
lie on the line along the crease and are no spikes.

Spikes stand beside spikes, so the first place of one goes by neighbours that were not all in
theirs.  In the end all that were moved settle together.
"""

from __future__ import annotations

import numpy as np
from scipy.special import ndtri

from ...mesh.topology import TriangleTopology
from ...runtime.arrays import BoolArray, FloatArray
from ..local_frame import LocalFrame
from ..parameters import parameters
from .line_roughness import OppositeLines
from .own_numbers import LINE_NOISE, own_noise


def impulsive_certainty(rough: FloatArray, frame: LocalFrame, is_counted: BoolArray) -> float:
    """Tell how surely noise is impulsive, from 0 to 1.

    Parameters
    ----------
    rough : (n,)
        Roughness over the deviation that it has with the noise that was found.
    frame : LocalFrame
    is_counted : (n,) bool
        Vertices to judge from.
    """
    tuned = parameters()
    if not is_counted.any():
        return 0.0
    root = frame.spread(np.where(is_counted, np.sqrt(rough), 0), tuned.calm_passes)
    around = root / np.maximum(frame.spread(is_counted.astype(float), tuned.calm_passes), 1e-9)
    is_quiet = is_counted & (around <= np.quantile(around[is_counted], tuned.calm_fraction))
    median, tail = np.quantile(rough[is_quiet], (0.5, tuned.tail_quantile))
    if median <= 0:
        return 0.0
    ratio = tail / median * ndtri(0.75) / ndtri((1 + tuned.tail_quantile) / 2)
    least = tuned.normal_ratio + tuned.ratio_chance / np.sqrt(np.count_nonzero(is_quiet))
    return float(np.clip((ratio - least) / (tuned.impulsive_ratio - tuned.normal_ratio), 0, 1))


def without_spikes(
    topology: TriangleTopology,
    positions: FloatArray,
    frame: LocalFrame,
    is_counted: BoolArray,
    may_move: BoolArray,
) -> FloatArray:
    """Return positions (n, 3) whose spikes lie on the lines through their neighbours.

    Parameters
    ----------
    topology : TriangleTopology
    positions : (n, 3)
    frame : LocalFrame
    is_counted : (n,) bool
        Vertices that tell how far others stand out.
    may_move : (n,) bool
        Vertices that may be spikes: rims too.
    """
    tuned = parameters()
    lines = OppositeLines(topology, frame)
    noise = frame.raised(own_noise(positions, frame, LINE_NOISE))
    unit = np.median(np.abs(lines.least_deviation(noise, lines.passing(positions)))[is_counted])
    result = positions.copy()
    centre = np.repeat(np.arange(topology.n_vertices), topology.ring_size)
    was_moved = np.zeros(len(result), dtype=bool)
    for _ in range(tuned.most_spike_rounds):
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
    for _ in range(tuned.settling_rounds):
        height = lines.least_deviation(result, lines.passing(result))
        # Half of the way: neighbours move at the same time.
        result -= frame.raised(np.where(was_moved, (height - frame.mean @ height) / 2, 0))
    return result
