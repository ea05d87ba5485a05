"""Denoising of the boundary as closed curves, where it is free to move.

Filters draw a boundary inwards, because nothing outside holds it.  So its vertices follow the
filters only along the boundary, and no further than their noise.  Across the surface and sideways
every closed curve of the boundary is denoised by itself: a vertex moves to an average over the
curve around it.  The average is as wide as the curve allows: it must stay within the confidence
intervals of all narrower averages.  At a corner it leaves one of them at once, so corners stay.

Smooth noise is alike along the curve, too, so averages over the curve leave most of it.  But it is
also alike beside the curve, inside the surface, where the filters have removed it.

Source: intersection of confidence intervals, A. Goldenshluger and A. Nemirovski, On spatially
adaptive estimation of nonparametric regression, 1997.
"""

from __future__ import annotations

import numpy as np
from scipy import ndimage, sparse
from scipy.sparse import csgraph
from scipy.special import binom

from ..mesh.normals import dots, unit_vectors
from ..runtime.arrays import FloatArray
from .noise.level import NORMAL_MEDIAN
from .noise_model import WHITE, NoiseCorrelation
from .parameters import parameters
from .triangle_surface import TriangleSurface, mean_among

# Passes of averaging along a curve, ascending: each twice as wide in its variance.
PASSES = (1, 2, 4, 8, 16, 32)

# Standard deviation that (1, -4, 6, -4, 1) / 4 makes of white noise.
DIFFERENCE_OF_WHITE = 70**0.5 / 4


class BoundaryCurves:
    """The boundary of a surface as closed curves with r vertices in all.

    Parameters
    ----------
    start : TriangleSurface
        Surface before denoising.
    noise : (n,)
        Standard deviation across the surface in local edge lengths; 0 where it was not judged, as
        on the boundary.
    correlation : NoiseCorrelation, optional
        White noise otherwise.

    Attributes
    ----------
    vertices : (r,)
    """

    def __init__(
        self, start: TriangleSurface, noise: FloatArray, correlation: NoiseCorrelation = WHITE
    ) -> None:
        topology, self._correlation = start.topology, correlation
        self.vertices = topology.boundary_vertices
        place = np.full(topology.n_vertices, -1)
        place[self.vertices] = np.arange(len(self.vertices))
        self._next, self._previous = (place[each] for each in topology.boundary_neighbours)
        self._points = start.positions[self.vertices]
        self._beside, self._is_inside = start.mean[self.vertices], ~topology.on_boundary
        # As lengths: the mean noise of the judged neighbours, else a typical one.
        is_judged = noise > 0
        typical = float(np.median(noise[is_judged])) if is_judged.any() else 0.0
        beside = mean_among(self._beside, noise, is_judged)
        self._noise = np.where(beside > 0, beside, typical) * start.spacing[self.vertices]

    def moves(self, filtered: FloatArray, normals: FloatArray, strength: float) -> FloatArray:
        """Compute the moves (r, 3) of the vertices.

        Parameters
        ----------
        filtered : (n, 3)
            Moves of all vertices by the filters; where they are 0 there is no noise to remove.
        normals : (n, 3)
            Unit normals of the surface.
        strength : float
            Factor of the noise.
        """
        inside = mean_among(self._beside, dots(filtered, normals), self._is_inside)
        filtered, normals = filtered[self.vertices], normals[self.vertices]
        noise = strength * self._noise
        noise[~filtered.any(axis=1)] = 0
        sideways = unit_vectors(
            np.cross(normals, self._points[self._next] - self._points[self._previous])
        )
        along = np.cross(sideways, normals)
        across = dots(filtered, normals)
        slide = parameters().sliding_fraction * dots(filtered, along)
        parts = (
            (self._across(across, inside, noise), normals),
            (self._sideways(sideways, self._part_sideways(sideways) * noise), sideways),
            (np.clip(slide, -noise, noise), along),
        )
        return sum((way[:, None] * axis for way, axis in parts), np.zeros((len(noise), 3)))

    def _part_sideways(self, sideways: FloatArray) -> FloatArray:
        """Measure the noise sideways as a fraction of that across, at most 1, (r,).

        It is measured by fourth differences along each curve, whose medians ignore the corners.
        """
        r = len(self.vertices)
        links = sparse.coo_array((np.ones(r), (np.arange(r), self._next)), shape=(r, r))
        n_curves, curve = csgraph.connected_components(links, directed=False)
        bend = self._mean(self._points) - self._points
        rough = np.abs(dots(bend - self._mean(bend), sideways)) / DIFFERENCE_OF_WHITE
        ratio = rough / np.where(self._noise > 0, self._noise, np.inf)
        part = np.minimum(ndimage.median(ratio, curve, np.arange(n_curves)) / NORMAL_MEDIAN, 1)
        part[np.bincount(curve) < parameters().fewest] = 0
        of_vertex: FloatArray = part[curve]
        return of_vertex

    def _across(self, filtered: FloatArray, inside: FloatArray, noise: FloatArray) -> FloatArray:
        """Find the moves across the surface, (r,).

        First what the moves inside (r,) tell of smooth noise, then what is left of the filters'.

        Source: best linear prediction, A. S. Goldberger, 1962.
        """
        alike = self._correlation.of_neighbours
        told = alike * np.where(noise > 0, inside, 0)
        return told + self._along_curve(filtered - told, np.sqrt(1 - alike**2) * noise)

    def _along_curve(self, moves: FloatArray, noise: FloatArray) -> FloatArray:
        """Take moves across the surface, (r,), less their mean along the whole curve.

        The filters are right about the shape of a curve, but they have drawn all of it inwards.
        """
        smooth, done, ways = moves, 0, []
        for passes in PASSES:
            for _ in range(passes - done):
                smooth = self._smoothed(smooth)
            done = passes
            ways.append((moves - smooth, self._kept(2 * passes) ** 0.5))
        return widest(ways, noise)

    def _sideways(self, direction: FloatArray, noise: FloatArray) -> FloatArray:
        """Find the moves sideways, (r,), to averages 2 Kᵖ - K²ᵖ, which keep a bend."""
        smooth, ways = [self._points], []
        for passes in PASSES:
            while len(smooth) <= 2 * passes:
                smooth.append(self._smoothed(smooth[-1]))
            average = 2 * smooth[passes] - smooth[2 * passes]
            kept = 4 * self._kept(2 * passes) - 4 * self._kept(3 * passes) + self._kept(4 * passes)
            ways.append((dots(average - self._points, direction), kept**0.5))
        return widest(ways, noise)

    def _kept(self, passes: int) -> float:
        """Covariance of the noise with its average Kᵖ along a curve, over its variance.

        Along a curve smooth noise is like white noise after half as many passes of K.
        """
        averaged = self._correlation.passes
        return middle(passes + averaged) / middle(averaged)

    def _mean(self, values: FloatArray) -> FloatArray:
        return (values[self._next] + values[self._previous]) / 2

    def _smoothed(self, values: FloatArray) -> FloatArray:
        """Average with K = (1, 2, 1) / 4."""
        return (values + self._mean(values)) / 2


def widest(ways: list[tuple[FloatArray, float]], noise: FloatArray) -> FloatArray:
    """Move (r,) to the widest average that stays within the intervals of all narrower ones.

    Parameters
    ----------
    ways : list of (r,) and float
        Moves to averages, from narrow to wide, and the fraction of white noise that each keeps.
    noise : (r,)
        Standard deviation: half the width of the intervals.  With one and a half as much, 0.57
        instead of 0.56 of the noise across boundaries was left, with twice as much 0.58.
    """
    low, high, chosen = -noise, noise, np.zeros(len(noise))
    goes_on = noise > 0
    for way, kept in ways:
        low, high = np.maximum(low, way - kept * noise), np.minimum(high, way + kept * noise)
        goes_on = goes_on & (low <= high)
        chosen = np.where(goes_on, way, chosen)
    return chosen


def middle(passes: int) -> float:
    """Entry in the middle of Kᵖ with K = (1, 2, 1) / 4; of K²ᵖ the sum of the squares of Kᵖ."""
    return float(binom(2 * passes, passes)) / 4.0**passes
