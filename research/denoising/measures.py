"""Distance of a result from the clean mesh: by density class, normals, flips, boundaries."""

from __future__ import annotations

from functools import cached_property

import igl
import numpy as np
from numpy.typing import NDArray

from tools.geometry.triangles import (
    Faces,
    FloatArray,
    boundary_edges,
    is_closed,
    local_edge_lengths,
    normals,
    signed_volume,
    triangle_areas,
)

N_CLASSES = 5
"""Density classes: equal parts of the vertices by local edge length, densest first."""

Score = dict[str, float | int | list[float] | None]


class Reference:
    """A clean mesh and all about it that its results are compared with.

    Parameters
    ----------
    vertices, faces
        (n, 3) clean positions and (m, 3) triangles.
    """

    def __init__(self, vertices: FloatArray, faces: Faces) -> None:
        self.vertices = np.ascontiguousarray(vertices, dtype=np.float64)
        self.faces = np.ascontiguousarray(faces, dtype=np.int64)
        self._used = np.unique(self.faces)

    @cached_property
    def _edges(self) -> FloatArray:
        return local_edge_lengths(self.vertices, self.faces)

    @property
    def local_edges(self) -> FloatArray:
        """Mean length of the clean mesh's edges around every vertex that has any."""
        return self._edges[self._used]

    @cached_property
    def density_class(self) -> FloatArray:
        """Class 0 (densest) to `N_CLASSES` − 1 of every vertex that has edges."""
        bounds = np.quantile(self.local_edges, np.arange(1, N_CLASSES) / N_CLASSES)
        return np.searchsorted(bounds, self.local_edges, side="right")

    @cached_property
    def _face_normals(self) -> FloatArray:
        return normals(self.vertices, self.faces)

    @cached_property
    def _volume(self) -> float | None:
        return signed_volume(self.vertices, self.faces) if is_closed(self.faces) else None

    @cached_property
    def _boundary_edges(self) -> NDArray[np.int64]:
        return boundary_edges(self.faces)

    def distances(self, result: FloatArray) -> FloatArray:
        """Measure how far a result (n, 3) and the clean surface are apart, in local edges.

        Returns
        -------
        (2, k) float
            For the k vertices that have edges: from the result's vertices to the clean surface,
            then from the clean vertices to the result's surface. A boundary that was drawn inwards
            still lies on the clean surface: only the second distance sees what is missing.
        """
        return self._both_ways(result, self._used, self.faces)

    def boundary_error(self, result: FloatArray) -> float | None:
        """Measure how far the boundaries are from the clean ones, in local edges; None if closed.

        Root mean square of two distances together: of the result's vertices to the clean
        boundaries, and of the clean vertices to the result's boundaries.
        """
        if not len(self._boundary_edges):
            return None
        gaps = self._both_ways(result, np.unique(self._boundary_edges), self._boundary_edges)
        return float(np.sqrt(np.mean(np.square(gaps))))

    def _both_ways(self, result: FloatArray, vertices: NDArray, cells: NDArray) -> FloatArray:
        """Distances (2, k) of k vertices to the triangles or edges of the other mesh."""
        result = np.ascontiguousarray(result, dtype=np.float64)
        squares = [
            igl.point_mesh_squared_distance(points[vertices], surface, cells)[0]
            for points, surface in ((result, self.vertices), (self.vertices, result))
        ]
        return np.sqrt(squares) / self._edges[vertices]

    def area_error(self, result: FloatArray) -> float:
        """Return the relative error of the area."""
        areas = (triangle_areas(each, self.faces).sum() for each in (result, self.vertices))
        return float(next(areas) / next(areas) - 1)

    def score(self, result: FloatArray) -> Score:
        """Measure a result (n, 3).

        Returns
        -------
        dict
            mean, worst, classes: root mean square of both `distances` together, over all vertices,
            in the worst density class, and in every class. moved: root mean square of the distance
            of every vertex to its own clean place, over the local edge. angle: mean angle to the
            clean faces' normals in degrees, as the literature has it. volume: relative error of
            the volume, None for open meshes. flips: faces whose normal points against the clean
            one. boundary: `boundary_error`, and area: `area_error`; None for closed meshes.
        """
        squares = np.square(self.distances(result)).mean(axis=0)
        counts = np.maximum(np.bincount(self.density_class, minlength=N_CLASSES), 1)
        classes = np.sqrt(np.bincount(self.density_class, squares, N_CLASSES) / counts)
        moves = np.linalg.norm(result - self.vertices, axis=1)[self._used] / self.local_edges
        cosines = np.einsum("fd,fd->f", self._face_normals, normals(result, self.faces))
        return {
            "mean": float(np.sqrt(squares.mean())),
            "worst": float(classes.max()),
            "classes": classes.tolist(),
            "moved": float(np.sqrt(np.mean(np.square(moves)))),
            "angle": float(np.degrees(np.arccos(np.clip(cosines, -1, 1))).mean()),
            "volume": signed_volume(result, self.faces) / self._volume - 1
            if self._volume
            else None,
            "flips": int(np.count_nonzero(cosines < 0)),
            "boundary": self.boundary_error(result),
            "area": self.area_error(result) if len(self._boundary_edges) else None,
        }
