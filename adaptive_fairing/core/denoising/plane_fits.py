"""Planes that are fitted to several faces, quadrics beside them, and moves onto the planes."""

from __future__ import annotations

import numpy as np
from scipy import special

from ..mesh.normals import dots
from ..runtime.arrays import FloatArray, IntArray

# Ratio of the median of absolute values to the standard deviation, for normal noise.
MEDIAN_TO_DEVIATION = 1.4826

# Vertices that lie this many standard deviations off a plane do not count.
#
# Source: J. W. Tukey's biweight with an efficiency of 95 % for normal noise.
OUTLIER = 4.685

# Deviation over the size of the noise: exact planes have residuals of rounding.
LEAST_DEVIATION = 1e-9

# Nearly parallel planes do not say where they meet: a vertex between two planes at an angle of θ
# goes half of its way to them if θ² / 2 is this.  With a tenth of it nothing changes.
PARALLEL = 0.003

# Probability with which a flat face passes the F test. Limits of F from 5.4 to 8, and such as grow
# with the face, gave the same results.
FLATNESS = 0.9999

# Terms of polynomials of two variables, by degree.
N_TERMS = 1, 3, 6, 10

# Vertices of a face that may tell whether noise is alike.
ENOUGH = 40

# Relative to the trace, keeps a system of a handful of vertices on one line definite.
RIDGE = 1e-9


class PlaneFits:
    """Least-squares planes of several faces, in which outliers do not count.

    Parameters
    ----------
    positions : (n, 3)
    size : (n,)
        Size of the noise, in any unit.
    vertex, face : (p,) int
        Vertices with each of the faces that they belong to, 0 to k - 1.
    n_faces : int
        k.  A face may have no vertices.
    has_outliers : bool
        Whether outliers are looked for.

    Attributes
    ----------
    vertex, face : (p,) int
    centres, normals : (k, 3)
        A point on each plane, and its unit normal, of either sign.
    """

    def __init__(
        self,
        positions: FloatArray,
        size: FloatArray,
        vertex: IntArray,
        face: IntArray,
        n_faces: int,
        *,
        has_outliers: bool = True,
    ) -> None:
        self.vertex, self.face, self._n_faces = vertex, face, n_faces
        self._count = np.bincount(face, minlength=n_faces)
        self._points, self._size = positions[vertex], size[vertex]
        self._weights = 1 / self._size**2
        self._fit()
        if has_outliers:
            median = self._medians(np.abs(self._residuals))
            limit = OUTLIER * np.maximum(MEDIAN_TO_DEVIATION * median, LEAST_DEVIATION)
            # Tukey's biweight.
            self._weights *= np.clip(1 - (self._residuals / limit[face]) ** 2, 0, None) ** 2
            self._fit()

    def __len__(self) -> int:
        return self._n_faces

    def heights(self, points: FloatArray, face: IntArray) -> FloatArray:
        """Heights (p,) of points (p, 3) above the planes of faces (p,)."""
        height: FloatArray = dots(points - self.centres[face], self.normals[face])
        return height

    def bends(self, own_part: float = 1.0) -> FloatArray:
        """F of a quadric that fits each face better than a plane, (k,); 1 is significant.

        With smooth noise, the vertices carry as much information as the fraction `own_part` of them
        would with independent noise.
        """
        return own_part * self._gains(2, FLATNESS)

    def own_part(self) -> float:
        """Return how much the vertices say, over what they would with independent noise.

        A quadric leaves nothing but noise on most faces.  Of noise that is alike over wide regions,
        as along the lines of a scanner, a cubic explains more.
        """
        gains = self._gains(3, 0.5)[self._count >= ENOUGH]
        return 1 / max(1.0, float(np.median(gains))) if len(gains) else 1.0

    def left_by_quadrics(self) -> FloatArray:
        """Least squares of the distances from a quadric instead of the plane, (k,)."""
        left: FloatArray = self._squares() - self._explained(2)[0]
        return left

    def squares_off(self, other: PlaneFits, face: IntArray) -> FloatArray:
        """Squares of the distances from planes of others, those of faces (p,), instead, (k,)."""
        return self._sums(np.square(other.heights(self._points, face) / self._size))

    def onto(
        self, surface: FloatArray, vertex: IntArray, face: IntArray, belonging: FloatArray
    ) -> FloatArray:
        """Move vertices of a surface (n, 3) the shortest way onto the planes of their faces, (p,).

        Between nearly parallel planes the vertex moves half-way.  It is drawn to a plane the less
        the less it belongs to the face, (p,) from 0 to 1.
        """
        n = len(surface)
        normals = self.normals[face]
        heights = self.heights(surface[vertex], face)
        # With one plane, the vertex moves by this part of the way to it.
        weights = PARALLEL * belonging / (1 + PARALLEL - belonging)
        matrix, right = np.empty((n, 3, 3)), np.empty((n, 3))
        for i in range(3):
            right[:, i] = np.bincount(vertex, weights * normals[:, i] * heights, n)
            for j in range(i + 1):
                product = np.bincount(vertex, weights * normals[:, i] * normals[:, j], n)
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
        self._residuals = self.heights(self._points, self.face) / self._size

    def _squares(self) -> FloatArray:
        return self._sums(self._weights * np.square(self._size * self._residuals))

    def _gains(self, degree: int, probability: float) -> FloatArray:
        """F of what polynomials of a degree explain beyond those below, over its quantile, (k,)."""
        below, explained = self._explained(degree - 1, degree)
        freedom = np.maximum(self._count - N_TERMS[degree], 1)
        left = np.maximum(self._squares() - explained, np.finfo(float).tiny)
        limit = special.fdtri(degree + 1, freedom, probability)
        gains: FloatArray = (explained - below) / (degree + 1) * freedom / (limit * left)
        return gains

    def _explained(self, *degrees: int) -> list[FloatArray]:
        """Squares of the residuals (k,) that polynomials of these degrees explain."""
        offset = self._points - self.centres[self.face]
        lengths = np.sqrt(np.maximum(self._spread[:, :0:-1], np.finfo(float).tiny))
        u, v = (
            dots(offset, self._axes[self.face, :, axis]) / length[self.face]
            for axis, length in zip((2, 1), lengths.T, strict=True)
        )
        highest = max(degrees)
        terms = [u ** (total - j) * v**j for total in range(highest + 1) for j in range(total + 1)]
        height = self._size * self._residuals
        right = np.stack([self._sums(self._weights * row * height) for row in terms], axis=1)
        matrix = np.empty((len(self), len(terms), len(terms)))
        for i, j in zip(*np.tril_indices(len(terms)), strict=True):
            matrix[:, i, j] = matrix[:, j, i] = self._sums(self._weights * terms[i] * terms[j])
        ridge = RIDGE * np.einsum("kii->k", matrix) + np.finfo(float).tiny
        matrix += ridge[:, None, None] * np.eye(len(terms))

        def explained(n_terms: int) -> FloatArray:
            of_terms = right[:, :n_terms, None]
            found = np.linalg.solve(matrix[:, :n_terms, :n_terms], of_terms)
            gain: FloatArray = np.einsum("kij,kij->k", found, of_terms)
            return gain

        return [explained(N_TERMS[degree]) for degree in degrees]

    def _sums(self, values: FloatArray) -> FloatArray:
        return np.bincount(self.face, values, len(self)).astype(np.float64, copy=False)

    def _medians(self, values: FloatArray) -> FloatArray:
        """Median (k,) of the values (p,) of each face; arbitrary for a face without values."""
        order = np.lexsort((values, self.face))
        last = np.cumsum(self._count)
        middle = (last - self._count + last) // 2
        median: FloatArray = values[order[np.minimum(middle, len(order) - 1)]]
        return median
