"""Any points of the limit surface, by the basis functions of the patch that they lie in."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError, listed
from ..loop.basis import evaluate_basis
from ..loop.patches import PatchSet
from ..mesh.input_checks import plain_array
from ..mesh.normals import unit_vectors
from ..runtime.arrays import FloatArray, IndexArray

# Barycentric coordinates are as good as this.
ROUNDING = 1e-9

# Points that are evaluated together: their basis functions have to be stored.
POINTS_AT_ONCE = 8192


class SurfacePoints(NamedTuple):
    """Points of a limit surface.

    Attributes
    ----------
    points : (k, 3)
    normals : (k, 3)
        Unit normals.
    """

    points: FloatArray
    normals: FloatArray


class PatchEvaluation:
    """Patches of a mesh without creases, for the evaluation of single points.

    Parameters
    ----------
    patches : PatchSet
    """

    def __init__(self, patches: PatchSet) -> None:
        self._patches = patches
        self._segments = list(patches.segments)
        n_triangles = patches.topology.n_triangles
        self._segment_of = np.empty(n_triangles, dtype=np.intp)
        self._place = np.empty(n_triangles, dtype=np.intp)
        for number, segment in enumerate(self._segments):
            self._segment_of[segment.triangles] = number
            self._place[segment.triangles] = np.arange(len(segment.triangles))

    def evaluate(
        self, positions: FloatArray, triangles: IndexArray, barycentric: FloatArray
    ) -> SurfacePoints:
        """Evaluate points that are not at a corner of their triangle.

        Parameters
        ----------
        positions : (n_vertices, 3)
            Control points of the surface.
        triangles : (k,) int
        barycentric : (k, 3)
            As `checked_places` returns them.
        """
        result = SurfacePoints(np.empty((len(triangles), 3)), np.empty((len(triangles), 3)))
        segment_of = self._segment_of[triangles]
        order = np.argsort(segment_of, kind="stable")
        for run in np.split(order, np.flatnonzero(np.diff(segment_of[order])) + 1):
            for first in range(0, len(run), POINTS_AT_ONCE):
                some = run[first : first + POINTS_AT_ONCE]
                points, normals = self._of_segment(positions, triangles[some], barycentric[some])
                result.points[some], result.normals[some] = points, normals
        return result

    def _of_segment(
        self, positions: FloatArray, triangles: IndexArray, barycentric: FloatArray
    ) -> SurfacePoints:
        segment = self._segments[self._segment_of[triangles[0]]]
        control = segment.control_points[:, self._place[triangles]].T
        # A patch starts at the corner that its class starts with.
        corners = self._patches.topology.triangles[triangles]
        turn = (corners == control[:, :1]).argmax(axis=1)[:, None]
        second, third = (
            np.take_along_axis(barycentric, (turn + k) % 3, axis=1)[:, 0] for k in (1, 2)
        )
        patch_class = self._patches.classes[segment.class_index]
        table = evaluate_basis(patch_class, np.stack([second, third], axis=1))[:3]
        jets = np.einsum("iqa,qad->iqd", table, positions[control])
        return SurfacePoints(jets[0], unit_vectors(np.cross(jets[1], jets[2])))


def checked_places(
    triangles: ArrayLike, barycentric: ArrayLike, n_triangles: int
) -> tuple[IndexArray, FloatArray]:
    """Check numbers of triangles (k,) and barycentric coordinates (k, 3); make these add up to 1.

    Raises
    ------
    InputError
        Arrays have the wrong shape or type, a triangle does not exist, or a point lies outside its
        triangle.
    """
    numbers, places = plain_array(triangles, "triangles"), plain_array(barycentric, "barycentric")
    if numbers.ndim != 1 or (numbers.dtype.kind not in "iu" and numbers.size):
        raise InputError(
            f"triangles must be integers of shape (k,), not {numbers.dtype} of {numbers.shape}"
        )
    if places.shape != (len(numbers), 3):
        raise InputError(f"barycentric must have shape ({len(numbers)}, 3), not {places.shape}")
    unknown = np.flatnonzero((numbers < 0) | (numbers >= n_triangles))
    if len(unknown):
        raise InputError(
            f"{len(unknown)} points are in triangles outside 0 … {n_triangles - 1}: points "
            f"{listed(unknown)}"
        )
    # Not "<" and ">", so that NaN counts as outside too.
    is_inside = (places >= -ROUNDING).all(axis=1) & (np.abs(places.sum(axis=1) - 1) <= ROUNDING)
    outside = np.flatnonzero(~is_inside)
    if len(outside):
        raise InputError(
            f"{len(outside)} points lie outside their triangle: points {listed(outside)}; "
            "barycentric coordinates are at least 0 and add up to 1"
        )
    clipped = np.maximum(places, 0.0)
    return numbers.astype(np.intp), clipped / clipped.sum(axis=1, keepdims=True)
