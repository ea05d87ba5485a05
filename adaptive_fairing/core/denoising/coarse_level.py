"""Coarse level of a surface: a mesh of fewer vertices, on which wide noise is a few edges wide.

Vertices of the surface, the seeds, are chosen so that no two lie within some edges of each other,
and every other vertex lies that near to a seed.  Every vertex joins the cell of its nearest seed.
Where three cells meet in a triangle, their seeds form a triangle of the level.  Contracting every
cell to its seed in this way keeps a closed surface closed.

The result on a level is carried back as a smooth field, which does not change finer detail.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from ..mesh.solver_mesh import SolverSurface, solvable_surface
from ..mesh.topology import TriangleTopology
from ..runtime.arrays import BoolArray, FloatArray, IndexArray, IntArray, LongArray
from ..runtime.lazy import cached_property
from .noise.own_numbers import SEEDS, OwnNumbers
from .triangle_surface import TriangleSurface

# Times that what the smooth field misses at the seeds is added to it.
CORRECTIONS = 2


@dataclass(frozen=True)
class CoarseLevel:
    """Coarse mesh over a finer one, for all frames of a surface.

    Attributes
    ----------
    surface : SolverSurface
        Mesh of the level; its `vertex_of` are indices into `seeds`.
    seeds : (k,) int
        Vertices of the finer mesh.
    cell : (n,) int
        Index into `seeds` for every vertex of the finer mesh; -1 at loose vertices.
    ratio : float
        Median number of edges of the finer mesh that an edge of the level spans.
    """

    surface: SolverSurface
    seeds: IndexArray
    cell: LongArray
    ratio: float

    @classmethod
    def over(cls, fine: TriangleSurface, hops: int) -> CoarseLevel:
        """Make the level whose seeds are more than some edges apart.

        Parameters
        ----------
        fine : TriangleSurface
        hops : int
            At least 1. See `most_hops`.
        """
        topology = fine.topology
        numbers = OwnNumbers(fine.positions, fine).phases(SEEDS)
        rank = np.empty(topology.n_vertices, dtype=np.int64)
        rank[np.argsort(numbers, kind="stable")] = np.arange(1, len(rank) + 1)
        seeds = _far_apart(topology.adjacency(), rank, ~topology.is_loose, hops)
        cell = _nearest(fine, seeds)
        surface = solvable_surface(fine.positions[seeds], _contracted(topology.triangles, cell))
        used, vertices = ~surface.topology.is_loose, seeds[surface.vertex_of]
        if not used.any():
            return cls(surface, seeds, cell, float(hops))
        own = TriangleSurface(surface.topology, fine.positions[vertices])
        ratio = float(np.median((own.spacing / fine.spacing[vertices])[used]))
        return cls(surface, seeds, cell, ratio)

    @property
    def topology(self) -> TriangleTopology:
        """Connectivity of the level."""
        return self.surface.topology

    @cached_property
    def is_known(self) -> BoolArray:
        """Whether a vertex of the level has a value to carry back, (c,): neither cut nor loose."""
        known: BoolArray = ~(self.surface.is_cut | self.topology.is_loose)
        return known

    @property
    def vertices(self) -> IndexArray:
        """Vertices of the finer mesh behind those of the level, (c,)."""
        return self.seeds[self.surface.vertex_of]

    def carried_back(self, values: FloatArray, fine: TriangleSurface) -> FloatArray:
        """Extend values (c, s) of the level's vertices to a smooth field on the finer mesh.

        Returns
        -------
        (n, s)
            Equal at the seeds, up to a few percent of the difference between neighbouring seeds.
            Cells without a value get one from their neighbours.
        """
        seed_of = self.surface.vertex_of[self.is_known]
        target = np.zeros((len(self.seeds), values.shape[1]))
        target[seed_of] = values[self.is_known]
        known = np.zeros(len(self.seeds))
        known[seed_of] = 1
        passes = max(1, round(2 * self.ratio**2))
        weight = np.maximum(fine.spread(self._spread_in_cells(known), passes), 1e-9)[:, None]
        field = np.zeros((len(self.cell), values.shape[1]))
        for _ in range(1 + CORRECTIONS):
            missing = (target - field[self.seeds]) * known[:, None]
            field += fine.spread(self._spread_in_cells(missing), passes) / weight
        return field

    def _spread_in_cells(self, values: FloatArray) -> FloatArray:
        """Value (k, ...) of its cell at every vertex; 0 at loose vertices."""
        return np.concatenate([values, np.zeros((1, *values.shape[1:]))])[self.cell]


def most_hops(ratio: float) -> int:
    """Largest `hops` of a level whose edges span at most this many edges; 0 if all span more.

    Measured: edges span 2.15, 3.3, 4.5, 5.7 and 10.5 with 1, 2, 3, 4 and 8 hops, within 3 %.
    """
    return max(0, math.floor((ratio - 0.95) / 1.18))


def _far_apart(
    adjacency: sparse.csr_array, rank: LongArray, is_free: BoolArray, hops: int
) -> IndexArray:
    """Choose vertices that are more than `hops` edges apart, until there is no room for more.

    In each round every free vertex joins that has the highest rank of the free ones around it.
    Ranks are distinct and above 0.

    Source: M. Luby, A simple parallel algorithm for the maximal independent set problem, 1986.
    """
    is_seed = np.zeros(len(rank), dtype=bool)
    while is_free.any():
        waiting = np.where(is_free, rank, 0)
        chosen = is_free & (_largest_near(adjacency, waiting, hops) == rank)
        is_seed |= chosen
        is_free = is_free & (_largest_near(adjacency, chosen.astype(np.int64), hops) == 0)
    return np.flatnonzero(is_seed)


def _largest_near(adjacency: sparse.csr_array, values: LongArray, hops: int) -> LongArray:
    """Largest of the values (n,) within some edges of each vertex, (n,)."""
    start = adjacency.indptr[:-1]
    has_any = np.diff(adjacency.indptr) > 0
    for _ in range(hops):
        largest = values.copy()
        around = np.maximum.reduceat(values[adjacency.indices], start[has_any])
        largest[has_any] = np.maximum(values[has_any], around)
        values = largest
    return values


def _nearest(fine: TriangleSurface, seeds: IndexArray) -> LongArray:
    """Index of the seed that is nearest along the edges, (n,); -1 at loose vertices."""
    graph = fine.topology.adjacency(np.float64)
    start = np.repeat(np.arange(len(fine.positions)), np.diff(graph.indptr))
    lengths = np.linalg.norm(fine.positions[start] - fine.positions[graph.indices], axis=1)
    graph.data = np.maximum(lengths, np.finfo(float).tiny)  # an explicit 0 would be no edge
    _, _, source = csgraph.dijkstra(graph, indices=seeds, min_only=True, return_predecessors=True)
    index = np.full(len(fine.positions), -1, dtype=np.int64)
    index[seeds] = np.arange(len(seeds))
    reached = source >= 0
    index[reached] = index[source[reached]]
    return index


def _contracted(triangles: IntArray, cell: LongArray) -> IntArray:
    """Triangles (m', 3) between the cells of vertices (n,), each once.

    Two triangles with the same corners and opposite orientation are a fold, and both are dropped.
    """
    corners = cell[triangles]
    following = np.roll(corners, -1, axis=1)
    corners = corners[(corners != following).all(axis=1)]
    low = np.sort(corners, axis=1)
    # A permutation that leaves one of three in its place swaps the others.
    is_turned = np.count_nonzero(corners == low, axis=1) == 1
    found, where = np.unique(low, axis=0, return_inverse=True)
    net = np.bincount(where.reshape(-1), np.where(is_turned, -1.0, 1.0), len(found))
    found[net < 0] = found[net < 0][:, [0, 2, 1]]
    contracted: IntArray = found[net != 0].astype(np.int32)
    return contracted
