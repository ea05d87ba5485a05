"""Flat faces of a denoised surface: detection, fit to the noisy positions, flattening.

Faces are found in four steps.

1.  Smooth the normals of the denoised surface.  A triangle is even if no triangle around it turns
    away by more than noise explains; triangles beyond a crease do not count.
2.  Connected even triangles form a face.  Fit planes to the noisy vertices of all faces.
3.  Drop faces that are bent: their normals vary too much, or a quadric fits them better.
4.  Let the others grow, ring by ring, up to where the surface leaves their planes.  What a face has
    grown by counts less the more the face is bent afterwards.

A vertex of one face then moves onto its plane, a vertex of several faces to where they meet.  It
moves less where a face is hardly large enough, or the vertex is hardly near enough to it: what
rounding decides should change nothing.
"""

from __future__ import annotations

from copy import copy

import numpy as np
from scipy import sparse, special
from scipy.sparse.csgraph import connected_components

from ..mesh.normals import dots, unit_vectors
from ..runtime.arrays import BoolArray, FloatArray, IntArray
from ..runtime.threads import chunks, for_each
from .noise_model import WHITE, NoiseCorrelation
from .normal_filter import Smoothing, smoothed_normals, weights_of_normals
from .parameters import parameters
from .triangle_surface import TriangleSurface

NO_FACE = -1

TRIANGLES_PER_CHUNK = 32768

# Ratio of the median of absolute values to the standard deviation, for normal noise.
MEDIAN_TO_DEVIATION = 1.4826

# Vertices that lie this many standard deviations off a plane do not count.
#
# Source: J. W. Tukey's biweight with an efficiency of 95 % for normal noise.
OUTLIER = 4.685

# Deviation in local edge lengths: exact planes have residuals of rounding.
LEAST_DEVIATION = 1e-9

# Nearly parallel planes do not say where they meet: a vertex between two planes at an angle of θ
# goes half of its way to them if θ² / 2 is this.  With a tenth of it nothing changes.
PARALLEL = 0.003

# Probability with which a flat face passes the F test. Limits of F from 5.4 to 8, and such as grow
# with the face, gave the same results.
FLATNESS = 0.9999

# What is near to a limit counts less, from 1 - 1 / FADING of it on: else rounding would decide.
FADING = 3

# Rings of triangles by which a face grows at most.  With 8, the error was 0.2 % larger.
MOST_RINGS = 32

# Relative to the trace, keeps a system of a handful of vertices on one line definite.
RIDGE = 1e-9


class FlatFaces:
    """The flat faces of a surface.

    Parameters
    ----------
    surface : TriangleSurface
        Denoised surface, on which the faces are found.
    noisy : (n, 3)
        Noisy positions of the same vertices, to which the planes are fitted.
    around : (9, m) int
        Triangles around each one, see `triangles_around`.
    noise : (n,), optional
        Standard deviation in local edge lengths, where it is known.
    correlation : NoiseCorrelation
        Correlation of smooth noise; no correlation otherwise.

    Attributes
    ----------
    face : (m,) int
        Index of each triangle's face; `NO_FACE` without one.  An index may have no triangles.
    planes : PlaneFits
        Plane of each index.
    """

    def __init__(
        self,
        surface: TriangleSurface,
        noisy: FloatArray,
        around: IntArray,
        noise: FloatArray | None = None,
        correlation: NoiseCorrelation = WHITE,
    ) -> None:
        tuned, topology = parameters(), surface.topology
        if noise is None:
            noise = np.zeros(topology.n_vertices)
        # Neighbours with smooth noise say less than as many of their own would.
        self._own_part = correlation.deviation**2 if correlation.passes else 1.0
        self._triangles, self._noisy, self._around = topology.triangles, noisy, around
        self._surface, self._spacing = surface.positions, surface.smooth_spacing
        # Where the noise is stronger or smooth, more of it is left in the surface.
        left = noise / (tuned.coarse_noise * np.sqrt(correlation.deviation))
        self._reach = tuned.face_height * np.maximum(1, left) * self._spacing
        scaled = surface.triangle_normals()
        self._areas = np.sqrt(dots(scaled, scaled))
        passes = tuned.short_fit_passes[-1] * (1 + correlation.passes)
        smoothing = Smoothing(tuned.short_fit_angle, (passes,))
        weights = weights_of_normals(topology, noise)
        (self._normals,) = smoothed_normals(unit_vectors(scaled), around, smoothing, weights)
        side = np.flatnonzero(topology.twin >= 0)
        self._beside = side // 3, topology.twin[side] // 3
        self._find(1.0)

    def again(self, evenness: float) -> FlatFaces:
        """Find the faces of the same surface, with this factor of the angle of even triangles."""
        other = copy(self)
        other._find(evenness)
        return other

    def _find(self, evenness: float) -> None:
        tuned, noisy = parameters(), self._noisy
        self._even_angle = evenness * tuned.narrow_angle
        self._share = np.ones(len(self._triangles))
        self.face = self._connected(self._even())
        self.planes = self._fitted(noisy)
        bend = np.maximum(self.planes.bends(self._own_part), self._unevenness())
        self.face = np.where(self._of_triangles(bend >= 1) > 0, NO_FACE, self.face)
        found, self._grown_on = self.face.copy(), self.planes
        # One triangle less, and the smallest ones would not be faces.
        sizes = np.bincount(found[found >= 0], minlength=len(self.planes))
        self._certainty = np.minimum(fading(tuned.fewest / np.maximum(sizes, 1)), fading(bend))
        for _ in range(MOST_RINGS):
            if not self._grow():
                break
        self.planes = self._fitted(noisy)
        # Faces that are bent now have grown too far, onto a round part.
        part = self._of_triangles(fading(self.planes.bends(self._own_part)))
        self._share = np.where(self.face == found, 1.0, part)
        if (self._share < 1).any():
            self.face = np.where(self._share > 0, self.face, NO_FACE)
            self.planes = self._fitted(noisy)

    def flattened(self, noisy: FloatArray, surface: FloatArray) -> FloatArray:
        """Move the vertices of flat faces onto planes fitted to the noisy positions, (n, 3) each.

        The surface may be a little different from that on which the faces were found.  Others of
        its vertices do not move.  The fewer triangles are on flat faces, the likelier the surface
        is round, and its faces are mistakes.
        """
        part = float(np.mean(np.where(self.face >= 0, self._share, 0)))
        flatness = part / parameters().least_flat - 1
        if flatness <= 0:
            return surface
        planes = self.planes if noisy is self._noisy else self._fitted(noisy)
        return planes.onto(surface, min(flatness, 1.0) * self._belonging(planes, surface))

    def of_vertices(self) -> IntArray:
        """Return the face of every vertex whose triangles are all on one, (n,), or `NO_FACE`."""
        face = np.where(self._share > 0.5, self.face, NO_FACE)
        lowest = np.full(len(self._spacing), len(self.planes), dtype=face.dtype)
        highest = np.full_like(lowest, NO_FACE)
        for vertex in self._triangles.T:
            np.minimum.at(lowest, vertex, face)
            np.maximum.at(highest, vertex, face)
        return np.where(lowest == highest, highest, NO_FACE)

    def _belonging(self, planes: PlaneFits, surface: FloatArray) -> FloatArray:
        """How far each vertex belongs to each of its faces, 0 to 1, (p,).

        A triangle belongs to its face the less the nearer its highest vertex is to the end of the
        reach, and a vertex as far as the best of its triangles does.  So a triangle that joins or
        leaves a face there changes nothing.  Small faces count less as a whole.
        """
        vertex, face = planes.vertex, planes.face
        heights = np.abs(self._grown_on.heights(surface[vertex], face)) / self._reach[vertex]
        return planes.of_best_triangles(fading(heights)) * self._certainty[face]

    def _fitted(self, noisy: FloatArray) -> PlaneFits:
        return PlaneFits(noisy, self._spacing, self._triangles, self.face, self._share)

    def _even(self) -> BoolArray:
        """Whether no triangle around each one turns away, those beyond creases aside, (m,)."""
        tuned = parameters()
        crease, even = np.cos(tuned.short_fit_angle), np.cos(self._even_angle)
        is_even = np.ones(len(self._triangles), dtype=bool)
        # Without another triangle the product with the last row is 0, as at a crease.
        normals = np.append(self._normals, np.zeros((1, 3)), axis=0)

        def of_chunk(chunk: slice) -> None:
            for other in self._around[:, chunk]:
                cosine = dots(normals[chunk], normals[other])
                is_even[chunk] &= (cosine < crease) | (cosine > even)

        for_each(of_chunk, chunks(len(is_even), TRIANGLES_PER_CHUNK))
        return is_even

    def _connected(self, is_even: BoolArray) -> IntArray:
        """Find the sets of even triangles that are connected without a crease."""
        first, second = self._beside
        # Every edge once, between even triangles.
        inside = np.flatnonzero((first < second) & is_even[first] & is_even[second])
        first, second = first[inside], second[inside]
        cosine = dots(self._normals[first], self._normals[second])
        alike = np.flatnonzero(cosine > np.cos(self._even_angle))
        m = len(is_even)
        links = sparse.coo_array((np.ones(len(alike)), (first[alike], second[alike])), (m, m))
        number = connected_components(links, directed=False)[1]
        is_large = np.bincount(number) >= parameters().fewest
        return self._renumbered(np.where(is_even & is_large[number], number, NO_FACE))

    def _unevenness(self) -> FloatArray:
        """How much the normals of each face differ from that of its plane, (k,); 1 is too much."""
        flat = np.flatnonzero(self.face >= 0)
        face, areas = self.face[flat], self._areas[flat]
        cosine = np.abs(dots(self._normals[flat], self.planes.normals[face]))
        n = len(self.planes)
        limit = 1 - np.cos(parameters().most_uneven)
        total = np.maximum(np.bincount(face, areas, n), np.finfo(float).tiny)
        unevenness: FloatArray = np.bincount(face, areas * (1 - cosine), n) / (limit * total)
        return unevenness

    def _of_triangles(self, of_faces: FloatArray | BoolArray) -> FloatArray:
        """Pass values (k,) of the faces on to their triangles; 0 without a face."""
        return np.append(of_faces, 0.0)[self.face]

    def _grow(self) -> bool:
        """Add triangles beside faces to the face from which they turn away least, if they fit."""
        tuned, planes = parameters(), self.planes
        outside, inside = self._beside
        is_border = (self.face[outside] < 0) & (self.face[inside] >= 0)
        triangle, face = outside[is_border], self.face[inside[is_border]]
        cosine = np.abs(dots(self._normals[triangle], planes.normals[face]))
        fits = cosine > np.cos(tuned.short_fit_angle)
        for vertex in self._triangles[triangle].T:
            fits &= np.abs(planes.heights(self._surface[vertex], face)) < self._reach[vertex]
        triangle, face, cosine = triangle[fits], face[fits], cosine[fits]
        # Of several faces the last one in this order counts.
        best = np.argsort(cosine, kind="stable")
        self.face[triangle[best]] = face[best]
        return bool(fits.any())

    @staticmethod
    def _renumbered(face: IntArray) -> IntArray:
        """Renumber the faces without gaps."""
        has_face = face >= 0
        result = np.full(len(face), NO_FACE)
        result[has_face] = np.unique(face[has_face], return_inverse=True)[1]
        return result


def fading(parts: FloatArray) -> FloatArray:
    """Weights (k,) of what comes to these parts of a limit: 0 at the limit and beyond."""
    weights: FloatArray = np.clip(FADING * (1 - parts), 0, 1)
    return weights


class PlaneFits:
    """Least-squares planes of several faces, in which outliers do not count.

    Parameters
    ----------
    positions : (n, 3)
    spacing : (n,)
        Local edge length; the noise is assumed to grow with it.
    triangles : (m, 3) int
    face : (m,) int
        Index of each triangle's face, 0 to k - 1; negative without one.
    share : (m,), optional
        How far each triangle belongs to its face, 0 to 1; by default entirely.

    Attributes
    ----------
    vertex, face : (p,) int
        Vertices with each of the faces that they belong to.
    centres, normals : (k, 3)
        A point on each plane, and its unit normal, of either sign.
    """

    def __init__(
        self,
        positions: FloatArray,
        spacing: FloatArray,
        triangles: IntArray,
        face: IntArray,
        share: FloatArray | None = None,
    ) -> None:
        n_faces = int(face.max(initial=-1)) + 1
        has_face = face >= 0
        self._corners = triangles[has_face].astype(np.int64) * n_faces + face[has_face][:, None]
        self._pairs = np.unique(self._corners)
        self.vertex, self.face = np.divmod(self._pairs, max(n_faces, 1))
        self._count = np.bincount(self.face, minlength=n_faces)
        self._points, self._spacing = positions[self.vertex], spacing[self.vertex]
        self._share = None if share is None or (share == 1).all() else share[has_face]
        self._part = np.ones(len(self._pairs))
        if self._share is not None:
            self._part = self.of_best_triangles(self._part)
        self._weights = by_noise = self._part / self._spacing**2
        for _ in ("with outliers", "without"):
            self._fit()
            self._residuals = self.heights(self._points, self.face) / self._spacing
            median = self._medians(np.abs(self._residuals))
            limit = OUTLIER * np.maximum(MEDIAN_TO_DEVIATION * median, LEAST_DEVIATION)
            # Tukey's biweight.
            inside = np.clip(1 - (self._residuals / limit[self.face]) ** 2, 0, None)
            self._weights = by_noise * inside**2

    def __len__(self) -> int:
        return len(self._count)

    def heights(self, points: FloatArray, face: IntArray) -> FloatArray:
        """Heights (p,) of points (p, 3) above the planes of faces (p,)."""
        height: FloatArray = dots(points - self.centres[face], self.normals[face])
        return height

    def bends(self, own_part: float = 1.0) -> FloatArray:
        """F of a quadric that fits each face better than a plane, (k,); 1 is significant.

        With smooth noise, the vertices carry as much information as the fraction `own_part` of them
        would with independent noise.
        """
        offset = self._points - self.centres[self.face]
        sizes = np.sqrt(np.maximum(self._spread[:, :0:-1], np.finfo(float).tiny))
        u, v = (
            dots(offset, self._axes[self.face, :, axis]) / size[self.face]
            for axis, size in zip((2, 1), sizes.T, strict=True)
        )
        terms = np.stack([np.ones_like(u), u, v, u * u, u * v, v * v])
        weights = self._weights * self._spacing**2
        right = np.stack([self._sums(weights * row * self._residuals) for row in terms], axis=1)
        matrix = np.empty((len(self), 6, 6))
        for i, j in zip(*np.tril_indices(6), strict=True):
            matrix[:, i, j] = matrix[:, j, i] = self._sums(weights * terms[i] * terms[j])
        ridge = RIDGE * np.einsum("kii->k", matrix) + np.finfo(float).tiny
        matrix += ridge[:, None, None] * np.eye(6)

        def explained(n_terms: int) -> FloatArray:
            of_terms = right[:, :n_terms, None]
            found = np.linalg.solve(matrix[:, :n_terms, :n_terms], of_terms)
            gain: FloatArray = np.einsum("kij,kij->k", found, of_terms)
            return gain

        by_quadric = explained(6)
        left = self._sums(weights * self._residuals**2) - by_quadric
        gain = (by_quadric - explained(3)) / 3
        freedom = np.maximum(self._count - 6, 1)
        limit = special.fdtri(3, freedom, FLATNESS)
        least = np.finfo(float).tiny
        bend: FloatArray = own_part * gain * freedom / (limit * np.maximum(left, least))
        return bend

    def of_best_triangles(self, values: FloatArray) -> FloatArray:
        """Give each vertex of a face the best of its triangles' values there, (p,).

        The value of a triangle is its share of the least of those at its vertices, (p,) from 0 on.
        """
        corners = np.searchsorted(self._pairs, self._corners)
        of_triangles = values[corners].min(axis=1)
        if self._share is not None:
            of_triangles *= self._share
        best = np.zeros(len(values))
        for pair in corners.T:
            np.maximum.at(best, pair, of_triangles)
        return best

    def onto(self, surface: FloatArray, belonging: FloatArray) -> FloatArray:
        """Move vertices of a surface (n, 3) the shortest way onto all of their planes.

        Between nearly parallel planes the vertex moves half-way.  It is drawn to a plane the less
        the less it belongs to the face, (p,) from 0 to 1.
        """
        n = len(surface)
        normals = self.normals[self.face]
        heights = self.heights(surface[self.vertex], self.face)
        # With one plane, the vertex moves by this part of the way to it.
        weights = PARALLEL * belonging / (1 + PARALLEL - belonging)
        matrix, right = np.empty((n, 3, 3)), np.empty((n, 3))
        for i in range(3):
            right[:, i] = np.bincount(self.vertex, weights * normals[:, i] * heights, n)
            for j in range(i + 1):
                product = np.bincount(self.vertex, weights * normals[:, i] * normals[:, j], n)
                matrix[:, i, j] = matrix[:, j, i] = product
        matrix += PARALLEL * np.eye(3)
        way = np.linalg.solve(matrix, right[:, :, None])[:, :, 0]
        on_planes: FloatArray = surface - way
        return on_planes

    def _fit(self) -> None:
        total = np.maximum(self._sums(self._weights), np.finfo(float).tiny)
        columns = [self._sums(self._weights * column) / total for column in self._points.T]
        self.centres: FloatArray = np.stack(columns, axis=1)
        offset = self._points - self.centres[self.face]
        matrix = np.empty((len(self), 3, 3))
        for i in range(3):
            for j in range(i + 1):
                product = self._sums(self._weights * offset[:, i] * offset[:, j]) / total
                matrix[:, i, j] = matrix[:, j, i] = product
        self._spread, self._axes = np.linalg.eigh(matrix)
        self.normals: FloatArray = self._axes[:, :, 0]

    def _sums(self, values: FloatArray) -> FloatArray:
        return np.bincount(self.face, values, len(self)).astype(np.float64, copy=False)

    def _medians(self, values: FloatArray) -> FloatArray:
        """Median (k,) of the values (p,) of each face; arbitrary for a face without values."""
        order = np.lexsort((values, self.face))
        below = np.cumsum(np.append(0.0, self._part[order]))
        last = np.cumsum(self._count)
        half = (below[last - self._count] + below[last]) / 2
        middle = np.searchsorted(below[1:], half, side="right")
        median: FloatArray = values[order[np.minimum(middle, len(order) - 1)]]
        return median
