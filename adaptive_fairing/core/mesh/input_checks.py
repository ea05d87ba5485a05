"""Checks of arrays from callers; each raises `InputError` that names the culprits."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError, listed
from ..runtime.arrays import FloatArray, IndexArray, IntArray

# Coordinates and sizes beyond these overflow or underflow in double precision, where the solve
# takes fifth powers and more. Blender's single precision ends at about the same sizes.
LARGEST_COORDINATE = 1e39
SMALLEST_SIZE = 1e-39


def plain_array(values: ArrayLike, name: str) -> NDArray[Any]:
    """Copy an array of numbers; refuse ragged rows, text and masked entries."""
    try:
        array = np.array(values, copy=True, subok=True)
        # Lists of unlike numbers, such as fractions, become objects.
        array = array.astype(np.float64) if array.dtype.kind == "O" else array
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} must be an array of numbers: {error}") from error
    if array.dtype.kind not in "biuf":
        raise InputError(f"{name} must be an array of numbers, not of {array.dtype}")
    if np.ma.is_masked(array):
        masked = np.unique(np.nonzero(np.ma.getmaskarray(array))[0])
        raise InputError(
            f"{len(masked)} rows of {name} are masked: {listed(masked)}; fill or leave them out"
        )
    return np.asarray(array)


def checked_vertices(vertices: ArrayLike) -> FloatArray:
    """Copy positions as (n, 3) float64; refuse other shapes and numbers not finite or too large."""
    points = plain_array(vertices, "vertices").astype(np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise InputError(f"vertices must have shape (n, 3), not {points.shape}")
    if (np.abs(points) <= LARGEST_COORDINATE).all():
        return points
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise InputError(
            f"{len(bad)} vertices have coordinates that are not finite numbers: {listed(bad)}; "
            "delete or repair them"
        )
    far = np.flatnonzero(np.abs(points).max(axis=1) > LARGEST_COORDINATE)
    raise InputError(
        f"{len(far)} vertices have coordinates beyond {LARGEST_COORDINATE:g}: {listed(far)}; "
        "scale the mesh down or delete them"
    )


def require_surface(points: FloatArray, triangles: IntArray) -> None:
    """Refuse a mesh that is far too small, or has no triangle with three different vertices."""
    a, b, c = triangles.T
    if not ((a != b) & (b != c) & (c != a)).any():
        raise InputError(
            f"none of the {len(triangles)} triangles has three different vertices"
            if len(triangles)
            else "the mesh has no triangles: there is no surface to fair"
        )
    low, high = bounding_box(points, triangles.reshape(-1))
    size = float((high - low).max())
    if 0 < size < SMALLEST_SIZE:
        raise InputError(f"the mesh is only {size:g} across: scale it up")


def bounding_box(
    points: FloatArray, chosen: IntArray | IndexArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest coordinates of points (n, 3), or of the chosen ones, of at least one."""
    if chosen is not None:
        is_chosen = np.zeros(len(points), dtype=bool)
        is_chosen[chosen] = True
        points = points if is_chosen.all() else points[is_chosen]
    # Column by column: numpy is ten times slower at reducing along the first axis.
    columns = points.T
    return np.array([x.min() for x in columns]), np.array([x.max() for x in columns])


def checked_weights(weights: ArrayLike | None, n_vertices: int) -> FloatArray:
    """Copy weights as (n,) float64, by default 1; refuse other shapes and values outside [0, 1]."""
    if weights is None:
        return np.ones(n_vertices)
    checked = plain_array(weights, "weights").astype(np.float64)
    if checked.shape != (n_vertices,):
        raise InputError(f"weights must have shape ({n_vertices},), not {checked.shape}")
    bad = np.flatnonzero(~((checked >= 0) & (checked <= 1)))
    if len(bad):
        raise InputError(f"{len(bad)} weights lie outside [0, 1]: at vertices {listed(bad)}")
    return checked
