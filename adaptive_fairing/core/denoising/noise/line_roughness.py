"""Roughness along the smoothest line through each vertex, which creases do not raise.

A mesh full of creases (a thread, a grating, steps) is rough nearly everywhere across them, but
smooth along them; noise is rough along every line.
"""

from __future__ import annotations

import numpy as np

from ...mesh.normals import dots
from ...runtime.arrays import FloatArray
from ..parameters import parameters
from ..triangle_surface import TriangleSurface


class OppositeLines:
    """Straight lines between opposite neighbours of every vertex.

    Parameters
    ----------
    frame : TriangleSurface
    """

    def __init__(self, frame: TriangleSurface) -> None:
        topology = frame.topology
        self._sizes = sizes = topology.ring_size
        self._middle = np.repeat(np.arange(topology.n_vertices), sizes)
        first = np.repeat(topology.ring_start[:-1], sizes)
        place = np.arange(len(self._middle)) - first
        size = sizes[self._middle]
        self._start = topology.ring
        self._end = topology.ring[first + (place + size // 2) % size]
        self._frame = frame

    def passing(self, positions: FloatArray) -> FloatArray:
        """Place of each vertex of `positions` (n, 3) along its lines, 0 to 1."""
        normal = self._frame.normals[self._middle]
        along = positions[self._end] - positions[self._start]
        along -= dots(along, normal)[:, None] * normal
        margin = parameters().line_margin
        reach = dots(positions[self._middle] - positions[self._start], along)
        place = reach / np.maximum(dots(along, along), 1e-300)
        return np.clip(place, margin, 1 - margin)

    def least_deviation(self, positions: FloatArray, passing: FloatArray) -> FloatArray:
        """Height of each vertex over the line that it deviates least from, (n,).

        Along the normals, in local edge lengths; 0 at vertices without neighbours.
        """
        line = positions[self._start]
        line = line + passing[:, None] * (positions[self._end] - line)
        deviation = np.einsum(
            "ed,ed->e", positions[self._middle] - line, self._frame.normals[self._middle]
        )
        magnitude, least = np.abs(deviation), np.zeros(len(positions))
        used = np.flatnonzero(self._sizes)
        first = np.cumsum(self._sizes)[used] - self._sizes[used]
        if len(used):
            smallest = np.repeat(np.minimum.reduceat(magnitude, first), self._sizes[used])
            candidates = np.where(magnitude == smallest, deviation, np.inf)
            least[used] = np.minimum.reduceat(candidates, first)
        return least / self._frame.spacing


class LineRoughness:
    """Deviations from the straight lines between opposite neighbours, the least at each vertex.

    Parameters
    ----------
    positions : (n, 3)
    frame : TriangleSurface
    noise : (n,)
        White noise of unit variance along the normals, to compare with.

    Attributes
    ----------
    least, least_of_noise : (n,)
        Magnitudes of the least deviations of the positions and of the noise, in local edge lengths.
    """

    def __init__(self, positions: FloatArray, frame: TriangleSurface, noise: FloatArray) -> None:
        lines = OppositeLines(frame)
        passing = lines.passing(positions)
        self.least = np.abs(lines.least_deviation(positions, passing))
        self.least_of_noise = np.abs(lines.least_deviation(frame.raised(noise), passing))
