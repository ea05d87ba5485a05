"""Thin walls around triply periodic surfaces, as lattices are printed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from skimage.measure import marching_cubes

from tools.geometry.triangles import Faces, FloatArray

PERIODIC: dict[str, Callable[[FloatArray, FloatArray, FloatArray], FloatArray]] = {
    "gyroid": lambda x, y, z: np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x),
    "primitive": lambda x, y, z: np.cos(x) + np.cos(y) + np.cos(z),
    "diamond": lambda x, y, z: (
        np.sin(x) * np.sin(y) * np.sin(z)
        + np.sin(x) * np.cos(y) * np.cos(z)
        + np.cos(x) * np.sin(y) * np.cos(z)
        + np.cos(x) * np.cos(y) * np.sin(z)
    ),
}
"""Waves whose zero sets are near to triply periodic minimal surfaces."""


def periodic_wall(
    name: str, cells: int, periods: float, thickness: float
) -> tuple[FloatArray, Faces]:
    """Make a thin wall around a triply periodic minimal surface, cut out by a ball.

    Parameters
    ----------
    name
        Of `PERIODIC`.
    cells
        Cells along each side of the volume that is meshed.
    periods
        Periods of the surface along that side.
    thickness
        Of the wall, as a range of values of the wave: 0.4 to 1.2 are thin.
    """
    axis = np.linspace(-np.pi, np.pi, cells) * periods
    places = np.meshgrid(axis, axis, axis, indexing="ij")
    wall = np.abs(PERIODIC[name](*places)) - thickness / 2
    ball = np.linalg.norm(places, axis=0) - 0.9 * np.pi * periods
    vertices, faces, _, _ = marching_cubes(np.maximum(wall, ball), 0.0)
    return vertices.astype(float), faces.astype(np.int32)
