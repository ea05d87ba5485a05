"""The line of sight of a depth camera, told from the mesh it left.

A camera sees its points along rays that are a grid, and a mesh joins neighbours of that grid.  Any
two triangles side by side are then a parallelogram, as seen by the camera: the sums of the opposite
corners differ along the line of sight alone.  The errors of the depths lie along that line too, and
are as large everywhere: along the surface's normals they are less where it is seen at an angle.
"""

from __future__ import annotations

import numpy as np

from ...mesh.topology import TriangleTopology
from ...runtime.arrays import FloatArray, IntArray
from ..parameters import parameters
from .noisy_surface import NoisySurface

# Cosine of the steepest angle at which a surface is seen: what is seen along itself has no noise
# along its normals, and every unit of length must be more than 0.
LEAST_COSINE = 0.1


def line_of_sight(topology: TriangleTopology, positions: FloatArray) -> FloatArray | None:
    """Find the direction along which the vertices (n, 3) are a grid, a unit vector (3,), if any."""
    side = np.flatnonzero(topology.twin > np.arange(len(topology.twin)))
    other = topology.twin[side]
    corners = topology.triangles.ravel()

    def corner(half_edge: IntArray, step: int) -> FloatArray:
        points: FloatArray = positions[corners[half_edge // 3 * 3 + (half_edge + step) % 3]]
        return points

    # Half-edge k of a triangle runs from its corner k to the next.
    gaps = corner(side, 2) + corner(other, 2) - corner(side, 0) - corner(side, 1)
    sizes, axes = np.linalg.eigh(gaps.T @ gaps)
    if sizes[:2].sum() > parameters().most_off_sight * sizes.sum():
        return None
    direction: FloatArray = axes[:, 2]
    return direction


def along_sight(surface: NoisySurface) -> NoisySurface:
    """Return a surface with the unit of length in which a depth camera's noise is even.

    Its mean is the local edge length.  A surface that no depth camera saw comes back as it is.
    """
    direction = line_of_sight(surface.topology, surface.positions)
    if direction is None:
        return surface
    frame = surface.frame
    unit = np.maximum(np.abs(frame.normals @ direction), LEAST_COSINE)
    unit *= np.median(frame.spacing) / np.median(unit)
    return NoisySurface(surface.positions, frame.with_frame(spacing=unit))
