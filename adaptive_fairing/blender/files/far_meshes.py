"""Meshes far from the origin, such as maps: near it in Blender, back in place in files.

Blender stores coordinates in single precision, whose steps at 4,600,000 m are half a metre. So the
distance goes into the location of the object, which holds it exactly, and the mesh keeps all its
digits.
"""

from __future__ import annotations

import math

import bpy
import numpy as np
from numpy.typing import NDArray

from ...files.inspection.contents import FarPoints, is_far
from ..data.mesh_arrays import read_mesh_coordinates, read_positions, write_positions

_MOST_DECIMALS = 13
"""Most decimals that count in a double where single precision is too coarse."""


def move_near_origin(far: FarPoints) -> None:
    """Give newly imported meshes the exact coordinates of the file, moved near the origin.

    A mesh whose coordinates are not the rounded ones of the file stays as it is.
    """
    for obj in bpy.data.objects:
        points = _points_of(obj.data, far) if obj.type == "MESH" else None
        if points is not None:
            origin = _origin(points)
            write_positions(obj.data, points - origin)
            # Importers turn by right angles only, but their matrices are not that exact.
            obj.location = np.round(np.array(obj.matrix_basis)[:3, :3]) @ origin
    bpy.context.view_layer.update()


def _points_of(mesh: bpy.types.Mesh, far: FarPoints) -> NDArray[np.float64] | None:
    """Points (n, 3) of the file from which the importer made the mesh."""
    rounded = read_mesh_coordinates(mesh)
    for part in far.parts:
        if len(part) == len(rounded):
            points = far.points[part]
            if np.array_equal(points.astype(np.float32), rounded):
                return points
    return None


def _origin(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Centre of a mesh, rounded to a short number that single precision holds exactly."""
    low, high = points.min(axis=0), points.max(axis=0)
    held = float(np.spacing(np.float32(np.abs(points).max())))
    step = max(held, 2.0 ** math.floor(math.log2(max((high - low).max() / 8, held))))
    return np.round((low + high) / 2 / step) * step


def world_points(obj: bpy.types.Object) -> NDArray[np.float64]:
    """Positions (n, 3) in the world, as files hold them.

    For a mesh far from the origin they have no more decimals than its own precision needs, so that
    4600001.37 comes out as it went in.
    """
    matrix = np.array(obj.matrix_world, dtype=np.float64)
    turn, location = matrix[:3, :3], matrix[:3, 3]
    if np.abs(turn - np.round(turn)).max() < 1e-6:
        turn = np.round(turn)  # the cosine of a right angle, in single precision, is not 0
    near = read_positions(obj.data) @ turn.T
    return _shortest(near, location) if is_far(near + location) else near + location


def _shortest(near: NDArray[np.float64], location: NDArray[np.float64]) -> NDArray[np.float64]:
    """Add a location to points, with the fewest decimals that still give the same near points."""
    points = near + location
    is_found = np.zeros(points.shape, dtype=bool)
    for decimals in range(_MOST_DECIMALS):
        rounded = np.round(near + location, decimals)
        is_same = (rounded - location).astype(np.float32) == near.astype(np.float32)
        points = np.where(is_same & ~is_found, rounded, points)
        is_found |= is_same
        if is_found.all():
            break
    return points


def rounding_notes(points: NDArray[np.float64], what: str) -> list[str]:
    """Note how much single precision rounds points (n, 3) that are far from the origin."""
    if not is_far(points):
        return []
    step = float(np.spacing(np.float32(np.abs(points).max())))
    return [
        f"{what} rounded to multiples of {step:.2g}, because single precision holds no more so far "
        "from the origin; move the mesh near it to keep all digits"
    ]
