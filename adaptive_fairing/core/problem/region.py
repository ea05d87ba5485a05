"""Part of a surface around the vertices that may move: all that a solve with weights looks at.

A vertex of weight 0 is held: its equation is dropped.  The equations of the others come from the
triangles that their basis functions reach.  If all those triangles are in the part, the solve on it
equals the solve on the whole surface; it is not an approximation.
"""

from __future__ import annotations

import numpy as np

from ..mesh.solver_mesh import SolverSurface, solvable_surface
from ..mesh.topology import TriangleTopology
from ..runtime.arrays import BoolArray, FloatArray, IndexArray
from .prepared_surface import PreparedSurface

SUPPORT_RINGS = 3
"""Number of rings around a vertex on which its equation depends.

Its Loop basis function is not 0 on triangles with a corner in the first ring.  Their corners are in
the second ring, and the control points around those in the third.
"""

# Largest fraction of the triangles in a part. Larger parts save little, and measures of the whole
# mesh are better.
LARGEST_PART = 0.5


class Region(PreparedSurface):
    """A part of a surface, prepared for solves.

    Attributes
    ----------
    surface : SolverSurface
        The part.  Its `vertex_of` refers to the caller's vertices.
    inner_of : (k,) int
        The vertex of the whole surface behind each of the part's.
    """

    def __init__(
        self, whole: PreparedSurface, surface: SolverSurface, inner_of: IndexArray
    ) -> None:
        super().__init__(surface, whole.quadrature_tolerance, whole.surface.topology)
        self.inner_of = inner_of


def rings_around(
    topology: TriangleTopology, is_start: BoolArray, n_rings: int, least: int = 0
) -> BoolArray:
    """Vertices within some rings around a set of vertices, without the last ring.

    Parameters
    ----------
    topology : TriangleTopology
    is_start : (n,) bool
    n_rings : int
        Rings of neighbours around the vertices to start from, at least 1.
    least : int
        Further rings are added until this many vertices are found, or no others can be reached.

    Returns
    -------
    (n,) bool
        Vertices whose neighbours have all been reached.
    """
    is_inside = has_ring = is_start.copy()
    front = np.flatnonzero(is_start)
    count, count_found, ring = len(front), 0, 0
    while len(front) and (ring < n_rings or count_found < least):
        has_ring, count_found = is_inside.copy(), count
        sizes = topology.ring_size[front]
        firsts = topology.ring_start[front] - (np.cumsum(sizes) - sizes)
        neighbours = topology.ring[np.repeat(firsts, sizes) + np.arange(sizes.sum())]
        front = np.unique(neighbours[~is_inside[neighbours]])
        is_inside[front] = True
        count, ring = count + len(front), ring + 1
    return has_ring if len(front) else is_inside


def part_around(
    points: FloatArray, whole: PreparedSurface, moves: BoolArray, n_rings: int, least: int = 0
) -> Region | None:
    """Cut out the triangles within some rings around the vertices that may move.

    Parameters
    ----------
    points : (n, 3)
        Positions of the solver's vertices; they only decide the order of the part's.
    whole : PreparedSurface
    moves : (n,) bool
        Which of the solver's vertices may move.
    n_rings, least : int
        As in `rings_around`.

    Returns
    -------
    Region or None
        None if there is nothing to move, or the part would be most of the surface.
    """
    topology = whole.surface.topology
    has_ring = rings_around(topology, moves, n_rings, least)
    is_in_part = has_ring[topology.triangles].any(axis=1)
    n_in_part = np.count_nonzero(is_in_part)
    if not 0 < n_in_part <= LARGEST_PART * topology.n_triangles:
        return None
    triangles = topology.triangles[is_in_part]
    used, corners = np.unique(triangles, return_inverse=True)
    # A vertex where the border touches itself is cut apart. It is held, as all there.
    part = solvable_surface(points[used], corners.reshape(-1, 3).astype(np.int32))
    inner_of = used[part.vertex_of].astype(np.intp)
    surface = SolverSurface(
        part.topology,
        whole.surface.vertex_of[inner_of],
        whole.surface.is_cut[inner_of] | part.is_cut,
        whole.surface.notes,
    )
    return Region(whole, surface, inner_of)
