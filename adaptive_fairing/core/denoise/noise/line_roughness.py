"""Roughness along the smoothest line through each vertex, which creases do not raise.

A mesh full of creases (a thread, a grating, steps) is rough nearly everywhere across them, but
smooth along them; noise is rough along every line.
"""

from __future__ import annotations

import numpy as np

from ...mesh.topology import TriangleTopology
from ...runtime.arrays import BoolArray, FloatArray
from ..local_frame import LocalFrame
from .own_numbers import LINE_NOISE, own_noise

# A line from one neighbour to the opposite one passes a vertex at a share between these.
SHARES = (0.2, 0.8)


class LineRoughness:
    """Deviations from the straight lines between opposite neighbours, the least at each vertex.

    Parameters
    ----------
    topology : TriangleTopology
    positions : (n, 3)
    frame : LocalFrame
    """

    def __init__(
        self, topology: TriangleTopology, positions: FloatArray, frame: LocalFrame
    ) -> None:
        sizes = topology.ring_size
        middle = np.repeat(np.arange(topology.n_vertices), sizes)
        first = np.repeat(topology.ring_start[:-1], sizes)
        place = np.arange(len(middle)) - first
        size = sizes[middle]
        start, end = topology.ring, topology.ring[first + (place + size // 2) % size]
        normal = frame.normals[middle]
        along = positions[end] - positions[start]
        along -= np.einsum("ed,ed->e", along, normal)[:, None] * normal
        reach = np.einsum("ed,ed->e", positions[middle] - positions[start], along)
        share = np.clip(reach / np.maximum(np.einsum("ed,ed->e", along, along), 1e-300), *SHARES)

        def least(points: FloatArray) -> FloatArray:
            line = points[start] + share[:, None] * (points[end] - points[start])
            deviation = np.abs(np.einsum("ed,ed->e", points[middle] - line, normal))
            result = np.full(topology.n_vertices, np.inf)
            np.minimum.at(result, middle, deviation)
            return result / frame.spacing

        noise = own_noise(positions, frame, LINE_NOISE)
        self._least = least(positions)
        self._least_of_noise = least(frame.raised(noise))

    def level(self, is_counted: BoolArray, quantile: float = 0.5) -> float:
        """Return the standard deviation of noise that is as rough, in local edge lengths.

        An upper bound of the noise, for at least one vertex of `is_counted`, (n,), inside the
        surface.  A higher `quantile` tells how rough the roughest part of the vertices is.
        """
        return float(
            np.quantile(self._least[is_counted], quantile)
            / np.median(self._least_of_noise[is_counted])
        )
