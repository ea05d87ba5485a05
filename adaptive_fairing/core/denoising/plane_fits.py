"""Planes fitted to the vertices of flat faces, and vertices moved onto them."""

from __future__ import annotations

import numpy as np

from ..mesh.normals import dots
from ..runtime.arrays import BoolArray, FloatArray, IntArray
from .parameters import parameters

# Of the median of absolute values and the standard deviation, for normal noise.
MEDIAN_TO_DEVIATION = 1.4826

# In local edge lengths: exact planes have residuals of rounding.
LEAST_DEVIATION = 1e-9

# Relative to the trace, keeps a system of a handful of vertices on one line definite.
RIDGE = 1e-9


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

    Attributes
    ----------
    vertex, face : (p,) int
        Vertices with each of the faces that they belong to.
    centres, normals : (k, 3)
        A point on each plane, and its unit normal, of either sign.
    deviations : (k,)
        Standard deviations of the positions from their planes, in local edge lengths.
    """

    def __init__(
        self, positions: FloatArray, spacing: FloatArray, triangles: IntArray, face: IntArray
    ) -> None:
        n_faces = int(face.max(initial=-1)) + 1
        has_face = face >= 0
        corner = triangles[has_face].astype(np.int64) * n_faces + face[has_face][:, None]
        self.vertex, self.face = np.divmod(np.unique(corner), max(n_faces, 1))
        self._count = np.bincount(self.face, minlength=n_faces)
        self._points, self._spacing = positions[self.vertex], spacing[self.vertex]
        tuned = parameters()
        self._weights = by_noise = 1 / self._spacing**2
        for _ in range(tuned.plane_fits):
            self._fit()
            self._residuals = self.heights(self._points, self.face) / self._spacing
            median = self._medians(np.abs(self._residuals))
            self.deviations = MEDIAN_TO_DEVIATION * median
            limit = tuned.plane_outlier * np.maximum(self.deviations, LEAST_DEVIATION)
            # Tukey's biweight.
            inside = np.clip(1 - (self._residuals / limit[self.face]) ** 2, 0, None)
            self._weights = by_noise * inside**2

    def __len__(self) -> int:
        return len(self._count)

    def heights(self, points: FloatArray, face: IntArray) -> FloatArray:
        """Heights (p,) of points (p, 3) above the planes of faces (p,)."""
        height: FloatArray = dots(points - self.centres[face], self.normals[face])
        return height

    def are_bent(self, own_part: float = 1.0) -> BoolArray:
        """Whether a quadric fits each face significantly better than a plane, by the F test, (k,).

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
        bent: BoolArray = own_part * gain * freedom > parameters().most_bend * np.maximum(left, 0)
        return bent

    def onto(self, surface: FloatArray, spacing: FloatArray) -> FloatArray:
        """Move vertices of a surface (n, 3) the shortest way onto all of their planes.

        Between nearly parallel planes the vertex moves half-way. A vertex that would move further
        than `farthest_to_planes` local edge lengths, (n,), stays.
        """
        tuned, n = parameters(), len(surface)
        normals = self.normals[self.face]
        heights = self.heights(surface[self.vertex], self.face)
        matrix, right = np.empty((n, 3, 3)), np.empty((n, 3))
        for i in range(3):
            right[:, i] = np.bincount(self.vertex, normals[:, i] * heights, n)
            for j in range(i + 1):
                product = np.bincount(self.vertex, normals[:, i] * normals[:, j], n)
                matrix[:, i, j] = matrix[:, j, i] = product
        matrix += tuned.parallel_planes * np.eye(3)
        way = np.linalg.solve(matrix, right[:, :, None])[:, :, 0]
        is_near = np.linalg.norm(way, axis=1) <= tuned.farthest_to_planes * spacing
        return np.where(is_near[:, None], surface - way, surface)

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
        ordered = values[np.lexsort((values, self.face))]
        last = np.cumsum(self._count)
        middle = np.minimum(last - self._count + self._count // 2, len(ordered) - 1)
        median: FloatArray = ordered[middle]
        return median
