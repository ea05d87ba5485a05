"""Caller's mesh: arrays checked and copied, once for every solve."""

from __future__ import annotations

from typing import NamedTuple

from numpy.typing import ArrayLike

from ..mesh.input_checks import checked_vertices, checked_weights, require_surface
from ..mesh.topology import checked_triangles
from ..runtime.arrays import FloatArray, IntArray


class CallerMesh(NamedTuple):
    """The caller's mesh, checked.

    Attributes
    ----------
    points : (n, 3)
    triangles : (m, 3) int32
    weights : (n,)
        In [0, 1]; a vertex of weight 0 stays where it is.
    """

    points: FloatArray
    triangles: IntArray
    weights: FloatArray

    @classmethod
    def checked(
        cls, vertices: ArrayLike, faces: ArrayLike, weights: ArrayLike | None = None
    ) -> CallerMesh:
        """Check and copy the arrays: the caller may change them while a run goes on.

        Raises
        ------
        InputError
            Arrays of the wrong shape or type, coordinates that are not finite, indices or weights
            out of range, no triangle at all.
        """
        points = checked_vertices(vertices)
        triangles = checked_triangles(faces, len(points))
        require_surface(points, triangles)
        return cls(points, triangles, checked_weights(weights, len(points)))
