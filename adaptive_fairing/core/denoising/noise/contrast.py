"""Contrasts: differences of positions in which noise and shape show differently.

A contrast is a linear difference of a few positions over the standard deviation that white noise of
size 1 gives it on this mesh.  So noise of size σ makes every contrast, of whatever kind, look like
σ times a half-normal distribution.  Shape only adds to that, and to one kind more than to another:
differences of high order hardly see slow bends, and two triangles of one flat face have no hinge
between them, however the face is triangulated.  So each kind gives an upper bound of the noise.

Two kinds tell what sort of roughness it is.  Deviations from straight lines are small along creases
and not along spikes.  Differences of higher and higher order keep white noise, while shape fades,
faster if it is smoother; so do the staircases of contoured volumes, like white noise that was mixed
with the mean of the neighbours' noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.special import ndtri

from ...mesh.normals import dots
from ...mesh.topology import following
from ...runtime.arrays import BoolArray, FloatArray, IntArray
from ...runtime.lazy import cached_property
from ...runtime.threads import chunks, for_each
from ..noise_model import WHITE, NoiseCorrelation
from ..parameters import parameters
from ..triangle_surface import TriangleSurface

# Orders of the differences whose fading is judged.
LOW, HIGH = 2, 5

VERTICES_PER_CHUNK, EDGES_PER_CHUNK = 8192, 16384


class Contrast(NamedTuple):
    """Contrasts of one kind, k of them.

    Attributes
    ----------
    value : (k,)
        Magnitudes, in local edge lengths along the normals.
    fineness : (k,)
        Variance in `value` of noise of one unit of length everywhere, in 1 / length²: about 1 / h².
    size : (k,)
        Logarithm of the length of the edges around, up to a constant: a measure of the density.
    vertices : (k, c) int
        Vertices whose positions count most.
    quantile : float
        Quantile of the magnitudes from which the noise is read.
    """

    value: FloatArray
    fineness: FloatArray
    size: FloatArray
    vertices: IntArray
    quantile: float

    def among(self, is_counted: BoolArray) -> Contrast:
        """Return the contrasts whose vertices are all among the counted ones, (n,) bool."""
        inside = np.flatnonzero(is_counted[self.vertices].all(axis=1))
        return self._replace(
            value=self.value[inside],
            fineness=self.fineness[inside],
            size=self.size[inside],
            vertices=self.vertices[inside],
        )

    def deviation(self, value: FloatArray) -> float:
        """Measure the standard deviation of the noise that explains some values."""
        return float(np.quantile(value, self.quantile)) / half_normal(self.quantile)


def half_normal(quantile: float) -> float:
    """Quantile of |x| for a normal distribution of unit variance."""
    return float(ndtri(0.5 + quantile / 2))


def roughness(positions: FloatArray, frame: TriangleSurface) -> Contrast:
    """Two differences with the mean of the neighbours: one contrast for every vertex.

    Parameters
    ----------
    positions : (n, 3)
    frame : TriangleSurface
        The same surface, slightly smoothed.
    """
    n, normals = len(positions), frame.normals
    difference = sparse.csr_array(sparse.identity(n, format="csr") - frame.mean)
    # Squares of factors and of cosines between normals, summed up over each row: the square of
    # m · n is n' N n with N = m m'.
    outer = (normals[:, :, None] * normals[:, None]).reshape(n, 9)
    lengths = np.square(frame.spacing)[:, None]
    outer_lengths = lengths * outer
    magnitude, per_length, per_edge = np.empty((3, n))

    def of_chunk(own: slice) -> None:
        twice = sparse.csr_array(difference[own] @ difference)
        magnitude[own] = np.abs(dots(twice @ positions, normals[own]) / frame.spacing[own])
        np.square(twice.data, out=twice.data)
        for result, each in ((per_length, outer), (per_edge, outer_lengths)):
            result[own] = np.einsum("ni,ni->n", outer[own], twice @ each) / lengths[own, 0]

    for_each(of_chunk, chunks(n, VERTICES_PER_CHUNK))
    edge_variance = np.maximum(per_edge, 1e-12)
    fineness = np.maximum(per_length / edge_variance, 1e-12)
    return Contrast(
        magnitude / np.sqrt(edge_variance),
        fineness,
        -frame.spread(np.log(fineness), parameters().averaging_passes) / 2,
        np.arange(n)[:, None],
        0.5,
    )


def hinges(positions: FloatArray, frame: TriangleSurface) -> Contrast:
    """Volumes between the two triangles of every inner edge, relative to those of white noise.

    Only the hinges across a crease see it, so the noise is read from the smaller hinges.

    Parameters
    ----------
    positions : (n, 3)
    frame : TriangleSurface
        The same surface, slightly smoothed.
    """
    topology, normals = frame.topology, frame.normals
    corners, lengths = topology.triangles.ravel(), np.square(frame.spacing)
    sides = topology.inner_edges
    ends = np.empty((len(sides), 2), corners.dtype)
    volume, per_edge, per_length = np.empty((3, len(sides)))

    def of_chunk(own: slice) -> None:
        side, other = sides[own], topology.twin[sides[own]]
        start, end, apex = (corners[following(side, step)] for step in range(3))
        beyond = corners[following(other, 2)]
        ends[own, 0], ends[own, 1] = start, end
        along, first, second = (positions[each] - positions[start] for each in (end, apex, beyond))
        # The volume is linear in each position; its derivatives are these normals.
        slopes = [np.cross(first, second), np.cross(second, along), np.cross(along, first)]
        volume[own] = np.abs(dots(second, slopes[2]))
        slopes.append(-(slopes[0] + slopes[1] + slopes[2]))
        vertices = end, apex, beyond, start
        squares = [
            np.square(dots(slope, normals[vertex]))
            for vertex, slope in zip(vertices, slopes, strict=True)
        ]
        per_length[own] = sum(squares)
        per_edge[own] = sum(
            part * lengths[vertex] for vertex, part in zip(vertices, squares, strict=True)
        )

    for_each(of_chunk, chunks(len(sides), EDGES_PER_CHUNK))
    # Triangles without an area see nothing.
    seen = np.flatnonzero(per_edge > 0)
    size = frame.spread(np.log(frame.spacing), parameters().averaging_passes)
    return Contrast(
        volume[seen] / np.sqrt(per_edge[seen]),
        per_length[seen] / per_edge[seen],
        size[ends[seen]].mean(axis=1),
        ends[seen],
        parameters().low_quantile,
    )


class OppositeLines:
    """Straight lines between opposite neighbours of every vertex.

    Parameters
    ----------
    frame : TriangleSurface
    """

    def __init__(self, frame: TriangleSurface) -> None:
        self._frame, self._ring_start = frame, frame.topology.ring_start
        self._chunks = chunks(frame.topology.n_vertices, VERTICES_PER_CHUNK)

    def passing(self, positions: FloatArray) -> FloatArray:
        """Place of each vertex of `positions` (n, 3) along its lines, 0 to 1."""
        place = np.empty(self._ring_start[-1])

        def of_chunk(own: slice) -> None:
            lines, middle, start, end = self._of(own)
            normal = self._frame.normals[middle]
            along = positions[end] - positions[start]
            along -= dots(along, normal)[:, None] * normal
            reach = dots(positions[middle] - positions[start], along)
            place[lines] = reach / np.maximum(dots(along, along), 1e-300)

        for_each(of_chunk, self._chunks)
        return np.clip(place, 0, 1, out=place)

    def least_deviation(
        self, positions: FloatArray, passing: FloatArray | None = None
    ) -> FloatArray:
        """Height of each vertex over the line that it deviates least from, (n,).

        Along the normals, in local edge lengths; 0 at vertices without neighbours.  Without
        `passing`, vertices are at the places of `positions`.
        """
        passing = self.passing(positions) if passing is None else passing
        least = np.zeros(len(positions))

        def of_chunk(own: slice) -> None:
            lines, middle, start, end = self._of(own)
            line = positions[start]
            line += passing[lines, None] * (positions[end] - line)
            deviation = dots(positions[middle] - line, self._frame.normals[middle])
            used = own.start + np.flatnonzero(np.diff(self._ring_start[own.start : own.stop + 1]))
            if len(used):
                first = self._ring_start[used] - lines.start
                above = np.minimum.reduceat(np.where(deviation >= 0, deviation, np.inf), first)
                below = np.maximum.reduceat(np.where(deviation < 0, deviation, -np.inf), first)
                least[used] = np.where(above < -below, above, below)

        for_each(of_chunk, self._chunks)
        least /= self._frame.spacing
        return least

    def _of(self, own: slice) -> tuple[slice, IntArray, IntArray, IntArray]:
        """Lines through some vertices: their slice, and the vertices of each (k,) along it."""
        topology = self._frame.topology
        sizes = topology.ring_size[own]
        lines = slice(*self._ring_start[[own.start, own.stop]])
        middle = np.repeat(np.arange(own.start, own.stop), sizes)
        first, size = self._ring_start[middle], np.repeat(sizes, sizes)
        place = np.arange(lines.start, lines.stop) - first
        opposite = first + (place + size // 2) % size
        return lines, middle, topology.ring[lines], topology.ring[opposite]


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


class Fading:
    """Differences of a mesh and of white noise on it.

    Parameters
    ----------
    positions : (n, 3)
    frame : TriangleSurface
    noises : sequence of (n,)
        White noises of unit variance along the normals, in local edge lengths.
    """

    def __init__(
        self, positions: FloatArray, frame: TriangleSurface, noises: Sequence[FloatArray]
    ) -> None:
        self._noises = noises
        self._positions, self._frame = positions, frame

    def fades(self, is_counted: BoolArray) -> bool:
        """Whether the roughness of vertices, (n,) bool, fades more than that of white noise."""
        tuned = parameters()
        _, kept = self.of_mesh(is_counted)
        chance = tuned.clear_deviations / np.sqrt(np.count_nonzero(is_counted))
        return kept < min(tuned.clearly_less, 1 - chance)

    def of_mesh(self, is_counted: BoolArray) -> tuple[float, float]:
        """Roughness in low order relative to white noise, and the fraction left in high order."""
        return _compared(self._of_mesh, self._of_noises, is_counted)

    def correlation(self, is_counted: BoolArray) -> NoiseCorrelation:
        """Return the correlation of noise that fades like the roughness of the mesh.

        From vertices, (n,) bool, at least one.  Noise that fades is that of staircases.
        """
        tuned = parameters()
        rough, _ = self.of_mesh(is_counted)
        if rough < tuned.least_roughness or not self.fades(is_counted):
            return WHITE
        correlation = NoiseCorrelation(tuned.correlation_of_staircases)
        noise = correlation.applied(self._noises[0], self._frame)
        differences = _differences(self._frame.raised(noise), self._frame)
        seen, _ = _compared(differences, self._of_noises[:1], is_counted)
        return correlation._replace(seen=seen, deviation=float(np.std(noise[is_counted])))

    # Not needed for a mesh that is clean at first sight.
    @cached_property
    def _of_mesh(self) -> FloatArray:
        return _differences(self._positions, self._frame)

    @cached_property
    def _of_noises(self) -> FloatArray:
        return np.stack(
            [_differences(self._frame.raised(each), self._frame) for each in self._noises]
        )


def _compared(
    differences: FloatArray, of_noises: FloatArray, is_counted: BoolArray
) -> tuple[float, float]:
    """Low order of differences (2, n) over that of noises, (k, 2, n), and the same of what is kept.

    What is kept is the high order over the low one.
    """
    low, high = np.median(differences[:, is_counted], axis=1)
    low_of_noise, high_of_noise = np.median(of_noises[..., is_counted], axis=2).mean(axis=0)
    # A surface without roughness does not fade.
    kept = (high / low) / (high_of_noise / low_of_noise) if low > 0 else 1.0
    return float(low / low_of_noise), float(kept)


def _differences(values: FloatArray, frame: TriangleSurface) -> FloatArray:
    """Magnitudes of the normal parts of differences of low and high order, (2, n)."""
    found = []
    for order in range(1, HIGH + 1):
        values = values - frame.mean @ values
        if order in (LOW, HIGH):
            found.append(np.abs(frame.along_normal(values)))
    return np.stack(found)
