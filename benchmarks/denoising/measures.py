"""How far a result is from the clean mesh: distances by density class, normals, volume, flips."""

from __future__ import annotations

from functools import cached_property

import igl
import numpy as np

from tools.samples.triangles import (
    Faces,
    FloatArray,
    is_closed,
    local_edge_lengths,
    normals,
    signed_volume,
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
    def local_edges(self) -> FloatArray:
        """Mean length of the clean mesh's edges around every vertex that has any."""
        return local_edge_lengths(self.vertices, self.faces)[self._used]

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

    def distances(self, result: FloatArray) -> FloatArray:
        """Distance of every result vertex to the clean surface, over the local edge length."""
        points = np.ascontiguousarray(result[self._used], dtype=np.float64)
        squares = igl.point_mesh_squared_distance(points, self.vertices, self.faces)[0]
        return np.sqrt(squares) / self.local_edges

    def score(self, result: FloatArray) -> Score:
        """Measure a result (n, 3).

        Returns
        -------
        dict
            mean, worst, classes: root mean square of `distances` over all vertices, in the worst
            density class, and in every class. moved: root mean square of the distance of every
            vertex to its own clean place, over the local edge. angle: mean angle to the clean
            faces' normals in degrees, as the literature has it. volume: relative error of the
            volume, None for open meshes. flips: faces whose normal points against the clean one.
        """
        squares = np.square(self.distances(result))
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
        }
