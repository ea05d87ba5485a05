"""Flat faces of a denoised surface: detection, fit to the noisy positions, flattening.

Faces are found in four steps.

1.  Smooth the normals of the denoised surface.  A triangle is even if no triangle around it turns
    away by more than noise explains; triangles beyond a crease do not count.
2.  Connected even triangles form a face.  Fit planes to the noisy vertices of all faces.
3.  Drop faces that are bent: their normals vary too much, or a quadric fits them better.
4.  Let the others grow, ring by ring, up to where the surface leaves their planes.  A face that is
    bent afterwards returns to what it was before.

A vertex of one face then moves onto its plane, a vertex of several faces to where they meet.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from ..mesh.normals import dots, unit_vectors
from ..runtime.arrays import BoolArray, FloatArray, IntArray
from .noise_correlation import WHITE, NoiseCorrelation
from .normal_filter import Smoothing, smoothed_normals
from .parameters import parameters
from .plane_fits import PlaneFits
from .triangle_surface import TriangleSurface

NO_FACE = -1


def flattened(
    surface: TriangleSurface,
    noisy: FloatArray,
    around: IntArray,
    least: float = 0.0,
    weights: FloatArray | None = None,
    correlation: NoiseCorrelation = WHITE,
) -> FloatArray | None:
    """Move the vertices of a surface's flat faces onto their planes.

    Parameters
    ----------
    surface : TriangleSurface
        Denoised surface, on which the faces are found.
    noisy : (n, 3)
        Noisy positions of the same vertices, to which the planes are fitted.
    around : (9, m) int
        Triangles around each one, see `triangles_around`.
    least : float
        Fraction of the triangles that must be on flat faces.
    weights : (m,), optional
        Weight of the normal of each triangle.
    correlation : NoiseCorrelation
        Correlation of smooth noise; no correlation otherwise.

    Returns
    -------
    (n, 3)
        Positions with flat faces; vertices on none of them do not move.  None if too few triangles,
        or none, are on flat faces.
    """
    found = FlatFaces(surface, noisy, around, weights, correlation)
    part = np.mean(found.face >= 0)
    if part == 0 or part < least:
        return None
    return found.planes.onto(surface.positions, surface.smooth_spacing)


class FlatFaces:
    """The flat faces of a surface; parameters as for `flattened`.

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
        weights: FloatArray | None = None,
        correlation: NoiseCorrelation = WHITE,
    ) -> None:
        tuned, topology = parameters(), surface.topology
        # Neighbours with smooth noise say less than as many of their own would.
        self._own_part = correlation.deviation**2 if correlation.passes else 1.0
        self._most_uneven = tuned.most_uneven_if_smooth if correlation.passes else tuned.most_uneven
        self._triangles, self._noisy = topology.triangles, noisy
        self._surface, self._spacing = surface.positions, surface.smooth_spacing
        scaled = surface.triangle_normals()
        self._areas = np.sqrt(dots(scaled, scaled))
        passes = tuned.face_passes + tuned.face_passes_for_smooth * correlation.passes
        smoothing = Smoothing(tuned.short_fit_angle, (passes,))
        (self._normals,) = smoothed_normals(unit_vectors(scaled), around, smoothing, weights)
        side = np.flatnonzero(topology.twin >= 0)
        self._beside = side // 3, topology.twin[side] // 3
        self.face = self._connected(self._even(around))
        self.planes = self._fitted()
        self._drop(self.planes.are_bent(self._own_part) | self._are_uneven())
        found = self.face.copy()
        for _ in range(tuned.face_rings):
            if not self._grow():
                break
        self.planes = self._fitted()
        # Those that are bent now have grown too far: onto what is round.
        has_grown_too_far = self._of_triangles(self.planes.are_bent(self._own_part))
        if has_grown_too_far.any():
            self.face = np.where(has_grown_too_far, found, self.face)
            self.planes = self._fitted()

    def of_vertices(self) -> IntArray:
        """Return the face of every vertex whose triangles are all on one, (n,), or `NO_FACE`."""
        lowest = np.full(len(self._noisy), len(self.planes), dtype=self.face.dtype)
        highest = np.full_like(lowest, NO_FACE)
        for vertex in self._triangles.T:
            np.minimum.at(lowest, vertex, self.face)
            np.maximum.at(highest, vertex, self.face)
        return np.where(lowest == highest, highest, NO_FACE)

    def _fitted(self) -> PlaneFits:
        return PlaneFits(self._noisy, self._spacing, self._triangles, self.face)

    def _even(self, around: IntArray) -> BoolArray:
        """Whether no triangle around each one turns away, those beyond creases aside, (m,)."""
        tuned = parameters()
        is_even = np.ones(len(self._triangles), dtype=bool)
        # Where there is no other triangle, the product with the last row is 0: a crease.
        normals = np.append(self._normals, np.zeros((1, 3)), axis=0)
        for other in around:
            cosine = dots(self._normals, normals[other])
            is_even &= (cosine > np.cos(tuned.even_angle)) | (cosine < np.cos(tuned.face_angle))
        return is_even

    def _connected(self, is_even: BoolArray) -> IntArray:
        """Find the sets of even triangles that are connected without a crease."""
        first, second = self._beside
        cosine = dots(self._normals[first], self._normals[second])
        is_inside = is_even[first] & is_even[second] & (cosine > np.cos(parameters().even_angle))
        m = len(is_even)
        links = sparse.coo_array(
            (np.ones(np.count_nonzero(is_inside)), (first[is_inside], second[is_inside])), (m, m)
        )
        number = connected_components(links, directed=False)[1]
        is_large = np.bincount(number) >= parameters().fewest_triangles
        return self._renumbered(np.where(is_even & is_large[number], number, NO_FACE))

    def _are_uneven(self) -> BoolArray:
        """Whether the normals of each face differ too much from that of its plane, (k,)."""
        flat = np.flatnonzero(self.face >= 0)
        face, areas = self.face[flat], self._areas[flat]
        cosine = np.abs(dots(self._normals[flat], self.planes.normals[face]))
        n = len(self.planes)
        limit = np.cos(self._most_uneven) * np.bincount(face, areas, n)
        uneven: BoolArray = np.bincount(face, areas * cosine, n) < limit
        return uneven

    def _of_triangles(self, of_faces: BoolArray) -> BoolArray:
        """Pass flags (k,) of the faces on to their triangles; False without a face."""
        return np.append(of_faces, False)[self.face]

    def _drop(self, faces: BoolArray) -> None:
        self.face = np.where(self._of_triangles(faces), NO_FACE, self.face)

    def _grow(self) -> bool:
        """Add triangles beside faces to the face from which they turn away least, if they fit."""
        tuned, planes = parameters(), self.planes
        outside, inside = self._beside
        is_border = (self.face[outside] < 0) & (self.face[inside] >= 0)
        triangle, face = outside[is_border], self.face[inside[is_border]]
        cosine = np.abs(dots(self._normals[triangle], planes.normals[face]))
        fits = cosine > np.cos(tuned.face_angle_at_border)
        # Less noise leaves a surface that is nearer to its planes.
        part = np.clip(planes.deviations / tuned.coarse_noise, tuned.least_face_height, 1)[face]
        for vertex in self._triangles[triangle].T:
            height = np.abs(planes.heights(self._surface[vertex], face))
            fits &= height < tuned.face_height * part * self._spacing[vertex]
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
