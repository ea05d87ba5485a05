"""Flat faces of a denoised surface: detection, fit to the noisy positions, flattening.

1.  Merge triangles to regions that are flat but for noise (`plane_merging`), and draw the limits
    between these along the triangles that are nearest to either plane.  Merge them again where
    they show that their vertices say less than was assumed.
2.  Tell faces from pieces of a round surface.  Flat faces turn at their limits and not within, and
    two of them are no single quadric.

A vertex of one face then moves onto its plane, a vertex of several faces to where they meet.  It
moves less where a face is hardly a flat one, where the vertex is hardly near enough to it, or where
its triangles are nearly as near to another: what rounding decides should change nothing.
"""

from __future__ import annotations

from copy import copy

import numpy as np

from ..mesh.normals import dots, unit_vectors
from ..runtime.arrays import FloatArray, IntArray
from .noise_model import WHITE, NoiseCorrelation, certainty
from .parameters import parameters
from .plane_fits import PlaneFits
from .plane_merging import FEWEST, flat_regions, triangles_beside
from .triangle_surface import TriangleSurface

NO_FACE = -1

# Part of a face that must lie well inside, to tell whether it bends.  Thin rings of a torus have
# less; with 0.35 narrow faces were missed: the error of *steps* was 1.15 times as large.
LEAST_INSIDE = 0.2

# How often the limits between regions are drawn.
DRAWN = 2

# What a triangle turns away from a plane, as 1 - cos, counts as so many squared edge lengths.
TURN = 0.3


class FlatFaces:
    """The flat faces of a surface.

    Parameters
    ----------
    surface : TriangleSurface
        Denoised surface, on which the faces are found.
    noisy : (n, 3)
        Noisy positions of the same vertices, to which the planes are fitted.
    noise : (n,), optional
        Standard deviation in local edge lengths; a usual one where it is not known.
    correlation : NoiseCorrelation
        Correlation of smooth noise; no correlation otherwise.

    Attributes
    ----------
    face : (m,) int
        Index of each triangle's face; `NO_FACE` without one.
    planes : PlaneFits
        Plane of each index.
    """

    def __init__(
        self,
        surface: TriangleSurface,
        noisy: FloatArray,
        noise: FloatArray | None = None,
        correlation: NoiseCorrelation = WHITE,
    ) -> None:
        tuned, self._topology, self._noisy = parameters(), surface.topology, noisy
        if noise is None:
            noise = np.full(len(noisy), tuned.usual_noise)
        self._surface, self._spacing = surface.positions, surface.smooth_spacing
        # Neighbours with smooth noise say less than as many of their own would.
        self._assumed_part = correlation.deviation**2 if correlation.passes else 1.0
        # Where the noise is smooth or stronger, more of it is left in the surface.
        self._left = 1 / np.sqrt(correlation.deviation) if correlation.passes else 1.0
        height = np.maximum(1, self._left * noise / tuned.coarse_noise)
        self._reach = tuned.face_height * height * self._spacing
        # Clean surfaces are as rough as this.
        self._size = np.maximum(noise, tuned.clean_roughness) * self._spacing
        self._edges = self._spacing[self._topology.triangles].mean(axis=1)
        # In local edge lengths, or dense triangles would not count.
        self._turned = surface.triangle_normals() / np.square(self._edges)[:, None]
        self._normals = unit_vectors(self._turned)
        self._beside = triangles_beside(self._topology)
        self._find(1.0)

    def again(self, factor: float) -> FlatFaces:
        """Find the faces of the same surface, merged with another factor."""
        other = copy(self)
        other._find(factor)
        return other

    def _find(self, factor: float) -> None:
        self._own_part = self._assumed_part
        self.face = np.full(len(self._edges), NO_FACE)
        self._merge(factor)
        for _ in range(DRAWN):
            self._number(self._drawn())
            self._fit()
            own_part = self.planes.own_part()
            if own_part < self._own_part:
                # The noise of scanners is alike, whatever was assumed of it.
                self._own_part = own_part
                self._merge(factor)
        certainties = self._certainties()
        is_face = np.append(certainties > 0, False)
        self._number(np.where(is_face[self.face], self.face, NO_FACE))
        self._fit()
        self._share()
        self._certainty = certainties[certainties > 0]

    def _merge(self, factor: float) -> None:
        """Merge the triangles, or the faces so far, and fit the planes."""
        region = flat_regions(
            self._topology, self._turned, self._noisy, self._size, self._own_part, factor, self.face
        )
        self._number(np.where(np.bincount(region)[region] >= FEWEST, region, NO_FACE))
        may_be_flat = np.append(self._bend_within() < 1, False)[self.face]
        if np.mean(may_be_flat) < parameters().least_flat:
            # Faces would count for nothing: that saves the rest.
            self._number(np.full_like(region, NO_FACE))
        self._fit()

    def flattened(self, noisy: FloatArray, surface: FloatArray) -> FloatArray:
        """Move the vertices of flat faces onto planes fitted to the noisy positions, (n, 3) each.

        The surface may be a little different from that on which the faces were found.  Others of
        its vertices do not move.  The fewer triangles are on flat faces, the likelier the surface
        is round, and its faces are mistakes.
        """
        part = float(np.mean(np.append(self._certainty, 0)[self.face]))
        flatness = part / parameters().least_flat - 1
        if flatness <= 0:
            return surface
        planes = self.planes
        if noisy is not self._noisy:
            planes = self._fitted(noisy, planes.vertex, planes.face)
        belonging = min(flatness, 1.0) * self._belonging(surface)
        return planes.onto(surface, self._moved, self._moved_to, belonging)

    def of_vertices(self) -> IntArray:
        """Return the face of every vertex whose triangles are all on one, (n,), or `NO_FACE`."""
        lowest = np.full(len(self._spacing), self._n_faces)
        highest = np.full_like(lowest, NO_FACE)
        for vertex in self._topology.triangles.T:
            np.minimum.at(lowest, vertex, self.face)
            np.maximum.at(highest, vertex, self.face)
        return np.where(lowest == highest, highest, NO_FACE)

    def _number(self, face: IntArray) -> None:
        """Take the faces of the triangles, (m,), and number them without gaps."""
        has_face = face >= 0
        self.face = np.full(len(face), NO_FACE)
        numbers, self.face[has_face] = np.unique(face[has_face], return_inverse=True)
        self._n_faces = len(numbers)

    def _fit(self) -> None:
        """List the vertices of each face, and fit the planes."""
        vertex, face, _ = self._pairs(*self._faced())
        self.planes = self._fitted(self._noisy, vertex, face)

    def _faced(self) -> tuple[IntArray, IntArray]:
        """Return the triangles that have a face, and their faces, (t,) each."""
        triangle = np.flatnonzero(self.face >= 0)
        return triangle, self.face[triangle]

    def _pairs(self, triangle: IntArray, face: IntArray) -> tuple[IntArray, IntArray, IntArray]:
        """List the vertices of triangles (t,) with a face of each, (t,).

        Returns
        -------
        vertex, face : (p,)
            Every pair once.
        corners : (t, 3)
            Places of the triangles' corners among the pairs.
        """
        n_faces = max(self._n_faces, 1)
        corners = self._topology.triangles[triangle].astype(np.int64) * n_faces
        pairs, places = np.unique(corners + face[:, None], return_inverse=True)
        return *np.divmod(pairs, n_faces), places.reshape(corners.shape)

    def _share(self) -> None:
        """List which vertices move onto which planes, and the share of each face in its triangles.

        A triangle at a limit is shared with the face beyond if that is nearly as near, in halves
        where both are equally near.
        """
        triangle, face = self._faced()
        at_limit, own, beyond = self._limits()
        way, way_beyond = (self._ways(at_limit, each) for each in (own, beyond))
        nearness = np.sqrt(way / np.maximum(way_beyond, np.finfo(float).tiny))
        shared = (1 - certainty(nearness)) / 2
        kept = np.ones(len(self.face))
        np.minimum.at(kept, at_limit, 1 - shared)
        self._moved, self._moved_to, self._corners = self._pairs(
            np.concatenate([triangle, at_limit]), np.concatenate([face, beyond])
        )
        self._shares = np.concatenate([kept[triangle], shared])

    def _fitted(self, noisy: FloatArray, vertex: IntArray, face: IntArray) -> PlaneFits:
        return PlaneFits(noisy, self._size, vertex, face, self._n_faces)

    def _limits(self) -> tuple[IntArray, IntArray, IntArray]:
        """Return triangles beside another face, their own and that beyond, (s,), for each side."""
        triangle, _ = self._beside
        own, beyond = self.face[self._beside]
        is_limit = (own != beyond) & (own >= 0) & (beyond >= 0)
        return triangle[is_limit], own[is_limit], beyond[is_limit]

    def _drawn(self) -> IntArray:
        """Return for each triangle the nearest of its own and its neighbours' faces, (m,)."""
        first, second = self._beside
        is_limit = self.face[first] != self.face[second]
        at_limit, beyond = first[is_limit], second[is_limit]
        triangle = np.concatenate([at_limit, at_limit])
        tried = self.face[np.concatenate([at_limit, beyond])]
        triangle, tried = triangle[tried >= 0], tried[tried >= 0]
        nearest_first = np.lexsort((self._ways(triangle, tried), triangle))
        triangle, index = np.unique(triangle[nearest_first], return_index=True)
        face = self.face.copy()
        face[triangle] = tried[nearest_first][index]
        return face

    def _ways(self, triangle: IntArray, face: IntArray) -> FloatArray:
        """How far triangles (p,) are from the planes of faces, (p,), in squared edge lengths."""
        square = np.zeros(len(triangle))
        for vertex in self._topology.triangles[triangle].T:
            square += np.square(self.planes.heights(self._surface[vertex], face)) / 3
        cosine = np.abs(dots(self._normals[triangle], self.planes.normals[face]))
        ways: FloatArray = square / np.square(self._edges[triangle]) + TURN * (1 - cosine)
        return ways

    def _certainties(self) -> FloatArray:
        """How certainly each face is flat, 0 to 1, (k,)."""
        parts = (
            self.planes.bends(self._own_part),
            self._bend_within(),
            self._round_limits() / parameters().most_round_limits,
        )
        least: FloatArray = np.min([certainty(each) for each in parts], axis=0)
        return least

    def _bend_within(self) -> FloatArray:
        """How much each face turns within, over what it turns at its limits, (k,); 1 is too much.

        It is the root mean square well inside, and the mean at the limits: what is between may have
        been rounded.
        """
        k = self._n_faces

        def sums(some: IntArray) -> tuple[FloatArray, FloatArray]:
            """Areas (k,) and normals times areas (k, 3) of some triangles of the faces."""
            face, turned = self.face[some], self._turned[some]
            areas: FloatArray = np.bincount(face, np.sqrt(dots(turned, turned)), k) + 0.0
            return areas, np.stack([np.bincount(face, each, k) for each in turned.T], axis=1)

        inner_face = np.append(self.of_vertices(), NO_FACE)[self._topology.triangles]
        areas, turned = sums(np.flatnonzero((inner_face >= 0).all(axis=1)))
        length = np.sqrt(dots(turned, turned))
        # Of unit vectors of which the mean has the length l, 2 (1 - l) is the variance.
        within = np.sqrt(2 * np.maximum(1 - length / np.maximum(areas, 1e-300), 0))
        whole, of_all = sums(np.flatnonzero(self.face >= 0))
        normals = unit_vectors(of_all)
        _, first, second = self._limits()
        way = normals[first] - normals[second]
        counts = np.bincount(first, minlength=k)
        turns = np.bincount(first, np.sqrt(dots(way, way)), k) / np.maximum(counts, 1)
        # A face that ends nowhere is no piece of a round surface.
        turns = np.where(counts > 0, np.maximum(turns, 1e-9), 1)
        part = within / (turns * self._left * parameters().most_bent_within)
        parts: FloatArray = np.maximum(part, LEAST_INSIDE * whole / np.maximum(areas, 1e-300))
        return parts

    def _round_limits(self) -> FloatArray:
        """Part of each face's limits beyond which it goes on as one quadric, (k,)."""
        k = self._n_faces
        _, first, second = self._limits()
        is_once = first < second
        code, lengths = np.unique(first[is_once] * k + second[is_once], return_counts=True)
        pairs = np.stack(np.divmod(code, max(k, 1)))
        order = np.argsort(self.planes.face, kind="stable")
        sizes = np.bincount(self.planes.face, minlength=k)
        of_faces = np.split(self.planes.vertex[order], np.cumsum(sizes)[:-1])

        def excess(some: IntArray) -> FloatArray:
            """Return what quadrics for pairs (2, p) leave more than their planes, (p,)."""
            members = some.T.ravel()
            vertex = np.concatenate([of_faces[each] for each in members])
            place = np.repeat(np.arange(len(members)), sizes[members])
            both = PlaneFits(
                self._noisy, self._size, vertex, place // 2, some.shape[1], has_outliers=False
            )
            apart = both.squares_off(self.planes, members[place])
            return both.left_by_quadrics() - apart

        # Few at once, which bounds the memory: a large face has many neighbours.
        chunk = np.cumsum(sizes[pairs].sum(axis=0)) // len(self._noisy)
        found = [excess(pairs[:, chunk == each]) for each in np.unique(chunk)]
        most = parameters().clear_deviations ** 2
        is_round = self._own_part * np.concatenate([np.zeros(0), *found]) < most
        ends = pairs.ravel()
        part = np.bincount(ends, np.tile(lengths * is_round, 2), k)
        parts: FloatArray = part / np.maximum(np.bincount(ends, np.tile(lengths, 2), k), 1)
        return parts

    def _belonging(self, surface: FloatArray) -> FloatArray:
        """How far each vertex belongs to each of the faces it moves onto, 0 to 1, (p,).

        A triangle belongs to its face the less the nearer its highest vertex is to the end of the
        reach, and a vertex as far as the best of its triangles does.  So a triangle that joins or
        leaves a face there changes nothing.
        """
        heights = np.abs(self.planes.heights(surface[self._moved], self._moved_to))
        near = certainty(heights / self._reach[self._moved])
        best = best_of_triangles(near, self._corners, self._shares)
        return best * self._certainty[self._moved_to]


def best_of_triangles(values: FloatArray, corners: IntArray, shares: FloatArray) -> FloatArray:
    """Give each place (p,) the best of its triangles' values.

    The value of a triangle, with its corners (t, 3) among the places, is the least of those there
    times its share, (t,).
    """
    of_triangles = shares * values[corners].min(axis=1)
    best = np.zeros(len(values))
    for place in corners.T:
        np.maximum.at(best, place, of_triangles)
    return best
