"""Regions of a surface that are flat but for noise, by merging from single triangles on.

Neighbours that turn away from each other least merge first.  Two regions stay apart if one plane
for both leaves so much more of the noisy positions than two planes do that, by Schwarz's criterion,
a second plane pays.  So a crease may turn as little as the noise beside it allows.

Source: the order after D. Cohen-Steiner, P. Alliez and M. Desbrun, Variational shape approximation,
2004; the limit after G. Schwarz, Estimating the dimension of a model, 1978.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..mesh.normals import dots, unit_vectors
from ..mesh.topology import TriangleTopology
from ..runtime.arrays import BoolArray, FloatArray, IndexArray, IntArray
from .parameters import parameters

# Entries of a symmetric matrix that differ.
ENTRIES = (0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)

# Fewer vertices say little: what is assumed of the noise counts as so many beside what the regions
# show of it, and regions of fewer may turn from each other by chance.
FEWEST = 12


class _Regions(NamedTuple):
    """Sums over the triangles of k regions.

    Attributes
    ----------
    turned : (k, 3)
        Normals times areas.
    areas : (k,)
    moments : (k, 10)
        Of the noisy vertices, weighted with their information: 1, x, and the `ENTRIES` of x xᵀ.
    vertices : (k,)
        Number of vertices that carry information of their own.
    """

    turned: FloatArray
    areas: FloatArray
    moments: FloatArray
    vertices: FloatArray

    def at(self, some: IndexArray | BoolArray) -> _Regions:
        """Return some of the regions."""
        return _Regions(*(each[some] for each in self))

    def summed(self, region: IntArray) -> _Regions:
        """Return the regions 0 to k - 1 to which these belong."""
        k = region.max() + 1

        def of_each(sums: FloatArray) -> FloatArray:
            total = np.zeros((k, *sums.shape[1:]))
            np.add.at(total, region, sums)
            return total

        return _Regions(*(of_each(sums) for sums in self))

    def off_plane(self) -> FloatArray:
        """Least squares (k,) of the distances of a region's vertices from a plane."""
        weight = np.maximum(self.moments[:, 0], np.finfo(float).tiny)
        centre = self.moments[:, 1:4] / weight[:, None]
        matrix = np.empty((len(weight), 3, 3))
        for (i, j), moment in zip(ENTRIES, self.moments[:, 4:].T, strict=True):
            matrix[:, i, j] = matrix[:, j, i] = moment - weight * centre[:, i] * centre[:, j]
        least: FloatArray = np.linalg.eigvalsh(matrix)[:, 0]
        return np.maximum(least, 0)


def flat_regions(
    topology: TriangleTopology,
    normals: FloatArray,
    noisy: FloatArray,
    size: FloatArray,
    own_part: float = 1.0,
    factor: float = 1.0,
    face: IntArray | None = None,
) -> IntArray:
    """Merge the triangles of a surface, or its faces, to regions that are flat but for noise.

    Parameters
    ----------
    topology : TriangleTopology
    normals : (m, 3)
        Normals of the denoised triangles; their lengths are the areas.
    noisy : (n, 3)
        Noisy positions of the vertices.
    size : (n,)
        Standard deviation of the noise, above 0, in units of length.
    own_part : float
        Vertices with smooth noise say as much as this part of them would with white noise.
    factor : float
        Of the limit, and exponent of the areas in the order. Other factors give other regions
        where rounding decides.
    face : (m,) int, optional
        Faces so far, below 0 without one.  Where there are any, none but these merge.

    Returns
    -------
    (m,) int
        Region of each triangle, 0 to k - 1.
    """
    limit = factor * 3 * math.log(topology.n_vertices)
    least_cosine = math.cos(parameters().short_fit_angle)
    regions = _single(topology, normals, noisy, own_part / np.square(size), own_part)
    pairs = triangles_beside(topology)
    pairs = pairs[:, pairs[0] < pairs[1]]
    is_crease = np.zeros(pairs.shape[1], dtype=bool)
    region = np.arange(topology.n_triangles)
    if face is not None and (face >= 0).any():
        is_crease = (face[pairs] < 0).any(axis=0)
        region = np.unique(np.where(face >= 0, face, len(face) + region), return_inverse=True)[1]
        regions = regions.summed(region)
        pairs, is_crease = _once(region[pairs], is_crease, len(regions.areas))
    left = regions.off_plane()
    while True:
        chosen = _nearest_to_each_other(regions, pairs, is_crease, factor)
        if not len(chosen):
            return region
        keep, lose = pairs[:, chosen]
        both = _Regions(*(each[keep] + each[lose] for each in regions))
        apart, together = left[keep] + left[lose], both.off_plane()
        # More noise than was assumed is no reason for a second plane.
        excess = np.maximum(1, (apart + FEWEST) / (both.vertices + FEWEST))
        fits = together - apart <= limit * excess
        # However little smooth noise may tell, no face has such a bend.
        cosine = dots(unit_vectors(regions.turned[keep]), unit_vectors(regions.turned[lose]))
        smaller = np.minimum(regions.vertices[keep], regions.vertices[lose])
        fits &= (cosine > least_cosine) | (smaller < own_part * FEWEST)
        is_crease[chosen[~fits]] = True
        keep, lose = keep[fits], lose[fits]
        left[keep] = together[fits]
        for sums, of_both in zip(regions, both, strict=True):
            sums[keep] = of_both[fits]
        target = np.arange(len(left))
        target[lose] = keep
        stays = target == np.arange(len(left))
        number = (np.cumsum(stays) - 1)[target]
        regions, left, region = regions.at(stays), left[stays], number[region]
        pairs, is_crease = _once(number[pairs], is_crease, len(left))


def triangles_beside(topology: TriangleTopology) -> IntArray:
    """Return the triangles on both sides of every inner edge, each way round, (2, s)."""
    side = np.flatnonzero(topology.twin >= 0)
    return np.stack([side, topology.twin[side]]) // 3


def _single(
    topology: TriangleTopology,
    normals: FloatArray,
    noisy: FloatArray,
    information: FloatArray,
    own_part: float,
) -> _Regions:
    """Return the regions of one triangle each, among which the vertices are divided."""
    triangles = topology.triangles
    x = noisy - noisy.mean(axis=0)
    rows = np.stack([np.ones(len(x)), *x.T, *(x[:, i] * x[:, j] for i, j in ENTRIES)], axis=1)
    degree = np.bincount(triangles.ravel(), minlength=len(x))
    rows *= (information / np.maximum(degree, 1))[:, None]
    moments = rows[triangles[:, 0]]
    for corner in (1, 2):
        moments += rows[triangles[:, corner]]
    # A closed surface has two triangles for a vertex.
    vertices = np.full(len(triangles), own_part / 2)
    return _Regions(normals.copy(), np.sqrt(dots(normals, normals)), moments, vertices)


def _nearest_to_each_other(
    regions: _Regions, pairs: IntArray, is_crease: BoolArray, exponent: float
) -> IndexArray:
    """Find the pairs (2, p) of which either region turns away least from the other, by index.

    With an exponent of 1 it is the turn by which the sum of squares over the area grows least.
    """
    first, second = pairs
    directions = unit_vectors(regions.turned)
    way, areas = directions[first] - directions[second], regions.areas**exponent
    both = np.maximum(areas[first] + areas[second], np.finfo(float).tiny)
    cost = dots(way, way) * areas[first] * areas[second] / both
    cost[is_crease] = np.inf
    least = np.full(len(areas), np.inf)
    for ends in pairs:
        np.minimum.at(least, ends, cost)
    found = np.flatnonzero((cost == least[first]) & (cost == least[second]) & np.isfinite(cost))
    # Of pairs that are equally good, those whose regions have no better place in the list.
    place = np.full(len(areas), len(cost))
    for ends in pairs:
        np.minimum.at(place, ends[found], found)
    return found[(place[first[found]] == found) & (place[second[found]] == found)]


def _once(pairs: IntArray, is_crease: BoolArray, n_regions: int) -> tuple[IntArray, BoolArray]:
    """Return the pairs (2, p) of different regions once; they are creases where any of them was."""
    low, high = pairs.min(axis=0), pairs.max(axis=0)
    differ = low < high
    code = low[differ].astype(np.int64) * n_regions + high[differ]
    code, number = np.unique(code, return_inverse=True)
    creases = np.bincount(number, is_crease[differ], len(code))
    return np.stack(np.divmod(code, n_regions)), creases > 0
