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
from ..triangle_surface import TriangleSurface

# Cosine of the steepest angle at which a surface is seen: what is seen along itself has no noise
# along its normals, and every unit of length must be more than 0.
LEAST_COSINE = 0.1

# And of the steepest angle at which a point goes along its ray all of the way to a plane: where it
# is steeper that may be far away.
LEAST_COSINE_OF_MOVES = 0.3

# A ray may pass a triangle by this part of it: those along its sides meet it as well.
ROUNDING = 1e-9


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


def on_rays(surface: TriangleSurface, points: FloatArray, direction: FloatArray) -> FloatArray:
    """Move points (n, 3) along the line of sight onto the triangles around their vertices, (n, 3).

    Where no triangle is met, onto the plane through the vertex.
    """
    axes = np.linalg.svd(direction[None])[2]
    # Depth and two places across the line of sight.
    seen, normals = surface.positions @ axes.T, surface.normals @ axes.T
    gap = points @ axes.T - seen
    corners = surface.topology.triangles
    vertex, second, third = (np.roll(corners, -step, axis=1).ravel() for step in range(3))
    to_second, to_third, to_point = (
        seen[second] - seen[vertex],
        seen[third] - seen[vertex],
        gap[vertex],
    )

    def area(one: FloatArray, other: FloatArray) -> FloatArray:
        double: FloatArray = one[:, 1] * other[:, 2] - one[:, 2] * other[:, 1]
        return double

    whole = area(to_second, to_third)
    whole[whole == 0] = np.nan
    by_second, by_third = area(to_point, to_third) / whole, area(to_second, to_point) / whole
    is_met = np.minimum(np.minimum(by_second, by_third), 1 - by_second - by_third) > -ROUNDING
    cosine = np.copysign(np.maximum(np.abs(normals[:, 0]), LEAST_COSINE_OF_MOVES), normals[:, 0])
    ways = -np.einsum("nd,nd->n", gap, normals) / cosine
    rises = by_second * to_second[:, 0] + by_third * to_third[:, 0] - to_point[:, 0]
    ways[vertex[is_met]] = rises[is_met]
    moved: FloatArray = points + ways[:, None] * axes[0]
    return moved
