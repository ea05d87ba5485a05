"""Contrasts: differences of positions in which noise and shape show differently.

A contrast is a linear difference of a few positions over the standard deviation that white noise of
size 1 gives it on this mesh.  So noise of size σ makes every contrast, of whatever kind, look like
σ times a half-normal distribution.  Shape only adds to that, and to one kind more than to another:
differences of high order hardly see slow bends, and two triangles of one flat face have no hinge
between them, however the face is triangulated.  So each kind gives an upper bound of the noise.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.special import ndtri

from ...mesh.normals import dots
from ...runtime.arrays import BoolArray, FloatArray, IntArray
from ..parameters import parameters
from ..triangle_surface import TriangleSurface


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
    difference = sparse.identity(len(positions), format="csr") - frame.mean
    twice = sparse.csr_array(difference @ difference)
    magnitude = np.abs(frame.along_normal(twice @ positions))
    # Squares of factors and of cosines between normals, summed up over each row: the square of
    # m · n is n' N n with N = m m'.
    np.square(twice.data, out=twice.data)
    n, normals = len(positions), frame.normals
    outer = (normals[:, :, None] * normals[:, None]).reshape(n, 9)
    lengths = np.square(frame.spacing)[:, None]
    per_length, per_edge = (
        np.einsum("ni,ni->n", outer, twice @ each) / lengths[:, 0]
        for each in (outer, lengths * outer)
    )
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
    topology = frame.topology
    side = np.flatnonzero(topology.twin > np.arange(len(topology.twin)))
    other, corners = topology.twin[side], topology.triangles.ravel()
    start, end, apex = (corners[side // 3 * 3 + (side + step) % 3] for step in range(3))
    beyond = corners[other // 3 * 3 + (other + 2) % 3]
    along, first, second = (positions[each] - positions[start] for each in (end, apex, beyond))
    # The volume is linear in each position; its derivatives are these normals.
    slopes = [np.cross(first, second), np.cross(second, along), np.cross(along, first)]
    volume = np.abs(dots(second, slopes[2]))
    slopes.append(-(slopes[0] + slopes[1] + slopes[2]))
    per_edge, per_length = np.zeros((2, len(side)))
    for vertex, slope in zip((end, apex, beyond, start), slopes, strict=True):
        part = np.square(dots(slope, frame.normals[vertex]))
        per_length += part
        per_edge += part * np.square(frame.spacing[vertex])
    # Triangles without an area see nothing.
    seen = np.flatnonzero(per_edge > 0)
    ends = np.stack([start[seen], end[seen]], axis=1)
    size = frame.spread(np.log(frame.spacing), parameters().averaging_passes)
    return Contrast(
        volume[seen] / np.sqrt(per_edge[seen]),
        per_length[seen] / per_edge[seen],
        size[ends].mean(axis=1),
        ends,
        parameters().low_quantile,
    )
