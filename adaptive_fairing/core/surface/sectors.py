r"""Sectors around a vertex between two sharp edges: sides of creases, boundary, corners.

  p_2   p_1            p_0 and p_k are the ends of two sharp edges; a sector has k triangles.
    \   /              On a crease p_0 - p_k is the tangent of the curve; the tangent across is
p_3--v--p_0            a left eigenvector of the sector's subdivision matrix.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from ..mesh.normals import unit_vectors
from ..runtime.arrays import BoolArray, FloatArray, IndexArray
from .refined_topology import CORNER, CREASE, RefinedTopology


@dataclass(frozen=True)
class Sectors:
    """Sectors of all creases, boundaries and corners; entries run over their rings p_0 … p_k.

    Attributes
    ----------
    vertex : (s,) int
        Vertex of each sector.
    size : (s,) int
        Number k of its triangles.
    start : (s,) int
        Its first entry; the sector has k + 1 of them, shared by none.
    neighbour : (entries,) int
        Vertices p_0 … p_k, sector after sector.
    half_edge : (entries,) int
        From the vertex to the neighbour; meaningless at the last entry of a sector.
    """

    vertex: IndexArray
    size: IndexArray
    start: IndexArray
    neighbour: IndexArray
    half_edge: IndexArray

    @property
    def end(self) -> IndexArray:
        """Last entry of each sector, (s,)."""
        return self.start + self.size

    def corners(self) -> tuple[IndexArray, IndexArray]:
        """Corners 3 f + k of the triangles in the sectors, and the sector of each."""
        sector, place = counted(self.size)
        return self.half_edge[self.start[sector] + place], sector


def sectors_of(mesh: RefinedTopology) -> Sectors:
    """Cut the rings of vertices on sharp edges into sectors."""
    if not mesh.has_sharp_edges:
        none = np.empty(0, dtype=np.intp)
        return Sectors(none, none, none, none, none)
    touched = np.zeros(mesh.n_vertices, dtype=bool)
    touched[mesh.edges[mesh.is_sharp]] = True
    vertices = np.flatnonzero(touched & (mesh.kind >= CREASE))
    n_entries = mesh.ring_size[vertices].astype(np.intp)
    # A cycle begins at a sharp edge and ends there again; the chain of the boundary has both.
    is_cycle = ~mesh.on_boundary[vertices]
    owner, step = counted(n_entries)
    ring_start = mesh.ring_start[vertices].astype(np.intp)
    is_sharp = mesh.is_sharp[mesh.ring_edges[ring_start[owner] + step]]
    first = np.zeros(len(vertices), dtype=np.intp)
    sharp_owner, place = np.unique(owner[is_sharp], return_index=True)
    first[sharp_owner] = step[is_sharp][place]

    owner, step = counted(n_entries + is_cycle)
    entry = ring_start[owner] + (first[owner] + step) % n_entries[owner]
    edge = mesh.ring_edges[entry]
    at = vertices[owner]
    is_last = step == (n_entries + is_cycle - 1)[owner]
    begins = np.flatnonzero(mesh.is_sharp[edge] & ~is_last)
    ends = np.flatnonzero(mesh.is_sharp[edge] & (step > 0))
    # Entries between two sectors belong to both: write them twice.
    size = ends - begins
    sector, offset = counted(size + 1)
    taken = begins[sector] + offset
    start = np.cumsum(size + 1) - (size + 1)
    outgoing = np.where(mesh.edges[edge, 0] == at, mesh.left[edge], mesh.right[edge])
    return Sectors(
        at[begins], size, start, mesh.ring[entry][taken].astype(np.intp), outgoing[taken]
    )


def counted(sizes: IndexArray) -> tuple[IndexArray, IndexArray]:
    """Group of every member, and its place in the group, for groups of these sizes."""
    group = np.repeat(np.arange(len(sizes)), sizes)
    return group, np.arange(len(group)) - np.repeat(np.cumsum(sizes) - sizes, sizes)


def sector_normals(mesh: RefinedTopology, sectors: Sectors, control: FloatArray) -> FloatArray:
    """Compute the unit normals of the limit surface in the sectors, at their vertices, (s, 3).

    Exact where the side has a tangent plane: on creases with up to five triangles on that side,
    at corners with up to three.  With more triangles Loop's rules turn the plane between the curve
    and the inside; the normal is then that of the curve's tangent and the tangent across, at
    corners the mean of those at both edges.
    """
    own = control[sectors.vertex]
    begin = control[sectors.neighbour[sectors.start]] - own
    end = control[sectors.neighbour[sectors.end]] - own
    is_corner = mesh.kind[sectors.vertex] == CORNER
    across = _tangents_across(sectors, is_corner, control)
    normals = np.cross(begin - end, across)
    narrow, wide = is_corner & (sectors.size <= 3), is_corner & (sectors.size > 3)
    normals[narrow] = np.cross(begin[narrow], end[narrow])
    normals[wide] = unit_vectors(np.cross(begin[wide], across[wide]))
    normals[wide] += unit_vectors(np.cross(across[wide], end[wide]))
    # Two edges in line span no plane.
    lengths = np.linalg.norm(normals, axis=1)
    scale = np.linalg.norm(begin, axis=1) * np.linalg.norm(end, axis=1)
    is_degenerate = lengths <= DEGENERATE * np.where(wide, 1, scale)
    if is_degenerate.any():
        normals[is_degenerate] = _fan_normals(sectors, control)[is_degenerate]
    return unit_vectors(normals)


# Tangents this close to parallel, by the sine of their angle, span a plane of rounding errors.
DEGENERATE = 1e-12


def _tangents_across(sectors: Sectors, is_corner: BoolArray, control: FloatArray) -> FloatArray:
    """Compute the tangents from the vertex into the sectors, (s, 3), as long as they come.

    With θ = π/k the inner weights are sin jθ, of the eigenvalue λ = 3/8 + cos(θ)/4.  The columns of
    the ends say w (λ - 1/2) = (sin θ + w_v)/8 with the vertex's weight w_v, which the sum of all
    weights, 0, gives on a crease; a corner, which stays, has no say in it.
    """
    if not len(sectors.size):
        return np.empty((0, 3))
    sector, place = counted(sectors.size + 1)
    theta = np.pi / sectors.size
    weights = np.sin(theta[sector] * place)
    weights[sectors.start] = weights[sectors.end] = 0
    ends = np.sin(theta) - np.add.reduceat(weights, sectors.start)
    ends /= 1 + 2 * np.cos(theta)
    wide = is_corner & (sectors.size > 3)
    ends[wide] = np.sin(theta[wide]) / (2 * np.cos(theta[wide]) - 1)
    # A single triangle has no neighbour inside: across is the next eigenvector of the curve.
    ends[sectors.size == 1] = 1
    weights[sectors.start] = weights[sectors.end] = ends
    shape = (len(sectors.size), len(control))
    sums = sparse.csr_array((weights, (sector, sectors.neighbour)), shape=shape) @ control
    own = np.add.reduceat(weights, sectors.start)[:, None] * control[sectors.vertex]
    tangents: FloatArray = sums - own
    return tangents


def _fan_normals(sectors: Sectors, control: FloatArray) -> FloatArray:
    """Add up the normals of the control triangles of each sector, (s, 3)."""
    sector, place = counted(sectors.size)
    first = sectors.start[sector] + place
    own = control[sectors.vertex[sector]]
    a, b = control[sectors.neighbour[first]] - own, control[sectors.neighbour[first + 1]] - own
    sums = [np.bincount(sector, x, len(sectors.size)) for x in np.cross(a, b).T]
    return np.stack(sums, axis=1)
