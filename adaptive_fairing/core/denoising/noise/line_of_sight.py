"""Lines of sight of a depth camera or a scanner, recovered from its mesh.

A camera sees its points along the rays of a grid, and the mesh joins neighbours of that grid.  So
two triangles of one cell of the grid form a parallelogram as seen by the camera: the sums of
opposite corners differ only along the line of sight.  The errors of the depths lie along that line
too.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from ...mesh.normals import dots, triangle_normals, unit_vectors
from ...mesh.topology import TriangleTopology, following
from ...runtime.arrays import FloatArray, IntArray
from ..lifted_metric import squared_edges
from ..triangle_surface import TriangleSurface

# Cosine of the steepest angle at which a surface is seen: what is seen along itself has no noise
# along its normals, and every unit of length must be more than 0.
LEAST_COSINE = 0.1

# And of the steepest angle at which a point goes along its ray all of the way to a plane: where it
# is steeper that may be far away.
LEAST_COSINE_OF_MOVES = 0.3

# A ray may pass a triangle by this part of it: those along its sides meet it as well.
ROUNDING = 1e-9

# Largest part of the gaps that is across the lines of sight. Depth images had 1e-15, two real scans
# 0.001 and 0.003, those of near cameras (up to 34° to the side) 0.012, other meshes 0.43 or more.
MOST_OFF_SIGHT = 0.05

# Rays of more than a degree to either side of their mean meet in a camera.
PARALLEL = 0.9998

# Grids of terrain fill all of their convex outline, images of 22 shapes 0.22 to 0.976 of it.
WHOLE_OUTLINE = 0.98

# Cosine of the widest angle between the axis of a camera and what it sees.
WIDEST_VIEW = 0.7


def lines_of_sight(topology: TriangleTopology, positions: FloatArray) -> FloatArray | None:
    """Find the unit vectors (n, 3) along which vertices (n, 3) were seen; None if they were not.

    The lines are parallel or meet in one point, where the camera was.
    """
    if topology.is_closed:  # it has a back, which no camera sees
        return None
    # The diagonal of a cell is the longest edge of both its triangles, unless it is seen steeply.
    squares = squared_edges(topology.triangles, positions).T
    is_longest = (squares == squares.max(axis=1, keepdims=True)).ravel()
    is_diagonal = is_longest & is_longest[topology.twin]
    side = topology.inner_edges
    side = side[is_diagonal[side]]
    other = topology.twin[side]
    corners = topology.triangles.ravel()

    def corner(half_edge: IntArray, step: int) -> FloatArray:
        points: FloatArray = positions[corners[following(half_edge, step)]]
        return points

    # Half-edge k of a triangle runs from its corner k to the next.
    twice_middle = corner(side, 0) + corner(side, 1)
    gaps = corner(side, 2) + corner(other, 2) - twice_middle
    axes, origin = np.linalg.eigh(gaps.T @ gaps)[1], twice_middle.mean(axis=0) / 2
    # From p the camera is seen along (a, b, 1) + k p, which is a multiple of the gap at p.
    gap, place = gaps @ axes, (twice_middle / 2 - origin) @ axes
    depth, turned = gap[:, 2], gap[:, 2:] * place[:, :2] - gap[:, :2] * place[:, 2:]
    none = np.zeros_like(depth)
    terms = np.hstack([(depth, none, turned[:, 0]), (none, depth, turned[:, 1])])
    (a, b, k), *_ = np.linalg.lstsq(terms @ terms.T, terms @ gap[:, :2].T.ravel(), rcond=None)
    rays = unit_vectors([a, b, 1] + k * ((positions - origin) @ axes))
    along = dots(gap, unit_vectors([a, b, 1] + k * place))
    is_seen = np.square(along).sum() > (1 - MOST_OFF_SIGHT) * np.square(gap).sum()
    return rays @ axes.T if is_seen and rays[:, 2].min() > WIDEST_VIEW else None


def shows_object(topology: TriangleTopology, positions: FloatArray, rays: FloatArray) -> bool:
    """Whether rays (n, 3) meet in a camera, or show an object in front of nothing.

    Grids of terrain have parallel rays and fill their outline.
    """
    used = np.unique(topology.triangles)
    middle = rays[used].mean(axis=0)
    middle /= np.linalg.norm(middle)
    if (rays[used] @ middle).min() < PARALLEL:
        return True
    area = np.abs(triangle_normals(positions, topology.triangles) @ middle).sum() / 2
    across = np.linalg.svd(middle[None])[2][1:]
    try:
        outline = ConvexHull(positions[used] @ across.T)
    except QhullError:  # a plane that is seen along itself has no outline
        return False
    return bool(area < WHOLE_OUTLINE * outline.volume)


def on_rays(surface: TriangleSurface, points: FloatArray, rays: FloatArray) -> FloatArray:
    """Move points (n, 3) along their rays (n, 3) onto the triangles around their vertices, (n, 3).

    A ray that meets no triangle moves its point onto the tangent plane at the vertex.
    """
    gap, cosines = points - surface.positions, dots(surface.normals, rays)
    steepest = np.copysign(np.maximum(np.abs(cosines), LEAST_COSINE_OF_MOVES), cosines)
    ways = -dots(gap, surface.normals) / steepest
    corners = surface.topology.triangles
    vertex, second, third = (np.roll(corners, -step, axis=1).ravel() for step in range(3))
    first = surface.positions[vertex]
    to_second, to_third = surface.positions[second] - first, surface.positions[third] - first
    to_point, ray = gap[vertex], rays[vertex]
    normal = np.cross(to_second, to_third)
    seen = dots(normal, ray)
    seen[seen == 0] = np.nan
    by_second = dots(np.cross(to_point, to_third), ray) / seen
    by_third = dots(np.cross(to_second, to_point), ray) / seen
    is_met = np.minimum(np.minimum(by_second, by_third), 1 - by_second - by_third) > -ROUNDING
    ways[vertex[is_met]] = (-dots(to_point, normal) / seen)[is_met]
    moved: FloatArray = points + ways[:, None] * rays
    return moved
