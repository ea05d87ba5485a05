"""Surfaces for refinement, made from any triangles: cut where not manifold, and joined again.

The cuts are those of the solver, see `mesh.manifold`.  Both sides of a cut keep its curve, and
vertices where the sides would not agree stay where they are, so that the refined mesh is joined
wherever the caller's is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import TopologyError
from ..mesh.manifold import cut_to_manifold
from ..mesh.topology import TriangleTopology
from ..runtime.arrays import BoolArray, IntArray, LongArray
from .limit_surface import RefinementLevels
from .refined_topology import edge_keys


@dataclass(frozen=True)
class CutSurface:
    """A surface to refine, and the caller's vertices and corners behind its own.

    Attributes
    ----------
    levels : RefinementLevels
    vertex_of : (n,) int
        The caller's vertex behind each vertex.
    corner_of : (m, 3) int
        The caller's triangle corner 3 f + k behind each corner; triangles that were turned round
        have them in opposite order.
    is_turned : (m,) bool
    is_cut : bool
        Whether the caller's mesh was not an oriented manifold.
    notes : tuple of str
        What was cut, turned or left out, with counts.
    """

    levels: RefinementLevels
    vertex_of: LongArray
    corner_of: LongArray
    is_turned: BoolArray
    is_cut: bool
    notes: tuple[str, ...]

    def joined_vertices(self, level: int) -> LongArray:
        """Assign numbers to the vertices of a level, (n_level,); copies at cuts share one.

        The caller's vertices keep their numbers; the others follow without gaps.
        """
        if not self.is_cut:
            return np.arange(self.levels.mesh(level).n_vertices)
        number = self.vertex_of
        for step in range(level):
            ends = np.sort(number[self.levels.mesh(step).edges], axis=1)
            n = int(number.max()) + 1
            _, of_edges = np.unique(ends[:, 0] * n + ends[:, 1], return_inverse=True)
            number = np.concatenate([number, n + of_edges.reshape(-1)])
        return number


def cut_surface(
    triangles: IntArray, n_vertices: int, creases: LongArray, corners: LongArray
) -> CutSurface:
    """Make any triangles refinable.

    Parameters
    ----------
    triangles : (m, 3) int
    n_vertices : int
    creases : (k, 2) int
        Vertex pairs of edges that stay sharp; those that no triangle has are ignored.
    corners : (j,) int
        Vertices that stay where they are.
    """
    notes: tuple[str, ...] = ()
    try:
        topology = TriangleTopology(triangles, n_vertices)
        vertex_of = np.arange(n_vertices)
        used, is_cut = np.arange(len(triangles)), False
        is_turned = np.zeros(len(triangles), dtype=bool)
    except TopologyError:
        mesh = cut_to_manifold(triangles, n_vertices)
        topology = TriangleTopology(mesh.triangles, len(mesh.vertex_of))
        vertex_of, notes, is_cut = mesh.vertex_of, mesh.notes, True
        used = np.setdiff1d(np.arange(len(triangles)), mesh.left_out)
        is_turned = (vertex_of[mesh.triangles] != triangles[used]).any(axis=1)
    corner_of = 3 * used[:, None] + np.arange(3)
    corner_of[is_turned] = corner_of[is_turned, ::-1]

    own_creases = np.empty((0, 2), dtype=np.int32)
    if len(creases):
        edges = _edges(topology)
        keys = edge_keys(vertex_of[edges], n_vertices)
        own_creases = edges[np.isin(keys, edge_keys(creases, n_vertices))]
    held = np.isin(vertex_of, corners)
    if is_cut:
        held |= _apart(topology, vertex_of, own_creases)
    levels = RefinementLevels(topology, own_creases, np.flatnonzero(held))
    return CutSurface(levels, vertex_of, corner_of, is_turned, is_cut, notes)


def _edges(topology: TriangleTopology) -> IntArray:
    """Edges once each, (e, 2)."""
    ends = np.stack([topology.origins, topology.triangles[:, [1, 2, 0]].reshape(-1)], axis=1)
    is_first = (topology.twin < 0) | (np.arange(len(ends)) < topology.twin)
    result: IntArray = ends[is_first]
    return result


def _apart(topology: TriangleTopology, vertex_of: LongArray, creases: IntArray) -> BoolArray:
    """Choose copies of vertices that would move apart, because they do not lie on one curve."""
    n = int(vertex_of.max()) + 1
    ends = np.stack([topology.origins, topology.triangles[:, [1, 2, 0]].reshape(-1)], axis=1)
    sharp = np.concatenate([ends[topology.twin < 0], creases])
    sharp = np.unique(np.sort(sharp, axis=1), axis=0)
    per_copy = np.bincount(sharp.reshape(-1), minlength=len(vertex_of))
    curve_ends = np.concatenate([vertex_of[sharp], vertex_of[sharp][:, ::-1]])
    distinct = np.unique(curve_ends, axis=0)[:, 0]
    per_vertex = np.bincount(distinct, minlength=n)
    n_copies = np.bincount(vertex_of, minlength=n)
    on_one_curve = (per_copy == 2) & (per_vertex == 2)[vertex_of]
    n_on_curve = np.bincount(vertex_of, on_one_curve, n)
    result: BoolArray = ((n_copies > 1) & (n_on_curve < n_copies))[vertex_of]
    return result & ~topology.is_loose
