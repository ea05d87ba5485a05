r"""Connectivity of a mesh and of its refinements: edges, ordered rings, sharp edges, by arithmetic.

A step cuts every triangle into four.  Nothing is searched or sorted for that: the numbers of the
new vertices, edges and triangles follow from those of the coarse mesh with n vertices, E edges.

              2                    vertices    those of the coarse mesh, then one per edge: n + e
             / \                   triangles   4 f + c at corner c, and 4 f + 3 in the middle
            / 2 \                  edges       halves 2 e (at the first end of e) and 2 e + 1,
      e_2  o-----o  e_1                        then 2 E + 3 f + c, the one that cuts off corner c
          / \ 3 / \                half-edges  3 f + k runs from corner k of f to corner k + 1,
         / 0 \ / 1 \                           along side e_k
        0-----o-----1
             e_0
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, listed
from ..mesh.topology import TriangleTopology
from ..runtime.arrays import BoolArray, IndexArray, IntArray, LongArray
from ..runtime.lazy import cached_property

SMOOTH, DART, CREASE, CORNER = np.arange(4, dtype=np.int8)
"""Kinds of vertices: with no, one, two, or more sharp edges.  Corners stay where they are."""


class RefinedTopology:
    """A level of refinement: an oriented manifold of triangles that is cheap to refine.

    Attributes
    ----------
    n_vertices : int
    triangles : (m, 3) int32
    sides : (m, 3) int32
        Edge from corner k to corner k + 1.
    edges : (e, 2) int32
        Vertices of the edges.
    left, right : (e,) int32
        Half-edges along and against an edge; -1 on the right of the boundary.
    is_sharp : (e,) bool
        Creases and the boundary.
    kind : (n_vertices,) int8
        `SMOOTH`, `DART`, `CREASE` or `CORNER`.
    """

    def __init__(
        self,
        triangles: IntArray,
        sides: IntArray,
        edges: IntArray,
        halves: tuple[IntArray, IntArray],
        is_sharp: BoolArray,
        kind: NDArray[np.int8],
        rings: Callable[[], tuple[IntArray, IntArray, IntArray]],
    ) -> None:
        self.n_vertices = len(kind)
        self.triangles = triangles
        self.sides = sides
        self.edges = edges
        self.left, self.right = halves
        self.is_sharp = is_sharp
        self.kind = kind
        self._make_rings = rings

    @cached_property
    def _rings(self) -> tuple[IntArray, IntArray, IntArray]:
        return self._make_rings()  # many refined meshes never need theirs

    @property
    def ring_start(self) -> IntArray:
        """Start of every vertex's ring, (n_vertices + 1,)."""
        return self._rings[0]

    @property
    def ring(self) -> IntArray:
        """Neighbours of all vertices, ordered as in `TriangleTopology`, (ring_start[-1],)."""
        return self._rings[1]

    @property
    def ring_edges(self) -> IntArray:
        """Edges to the neighbours, (ring_start[-1],)."""
        return self._rings[2]

    @property
    def ring_size(self) -> IntArray:
        """Number of neighbours of every vertex, (n_vertices,)."""
        return np.diff(self.ring_start)

    @cached_property
    def on_boundary(self) -> BoolArray:
        """Vertices whose ring is no cycle, (n_vertices,)."""
        result = np.zeros(self.n_vertices, dtype=bool)
        result[self.edges[self.right < 0]] = True
        return result

    @cached_property
    def has_sharp_edges(self) -> bool:
        """Whether there is a boundary or a crease at all."""
        return bool(self.is_sharp.any())

    @cached_property
    def opposite(self) -> IntArray:
        """Vertices that face the edges on the left and on the right, (e, 2).

        On the right of the boundary nothing useful.
        """
        corner_of = self.triangles.reshape(-1)
        faces = [corner_of[_other_sides(half_edge)[1]] for half_edge in (self.left, self.right)]
        return np.stack(faces, axis=1)

    @cached_property
    def finer(self) -> RefinedTopology:
        """Mesh after one step of refinement."""
        n, n_edges = self.n_vertices, len(self.edges)
        m = len(self.triangles)
        middle = n + self.sides
        before = middle[:, [2, 0, 1]]
        triangles = np.empty((m, 4, 3), dtype=np.int32)
        triangles[:, :3, 0], triangles[:, :3, 1], triangles[:, :3, 2] = (
            self.triangles,
            middle,
            before,
        )
        triangles[:, 3] = middle

        # Half of side k at corner k, half of the side before at corner k, the edge between them.
        starts_at_corner = self.edges[:, 0][self.sides] == self.triangles
        halves = 2 * self.sides
        first = halves + ~starts_at_corner
        last = (halves + starts_at_corner)[:, [2, 0, 1]]
        inner = 2 * n_edges + np.arange(3 * m, dtype=np.int32).reshape(m, 3)
        sides = np.empty((m, 4, 3), dtype=np.int32)
        sides[:, :3, 0], sides[:, :3, 1], sides[:, :3, 2] = first, inner, last
        sides[:, 3] = inner[:, [1, 2, 0]]

        edges = np.empty((2 * n_edges + 3 * m, 2), dtype=np.int32)
        halved = edges[: 2 * n_edges].reshape(n_edges, 2, 2)
        halved[:, 0, 0], halved[:, 1, 1] = self.edges.T
        halved[:, 0, 1] = halved[:, 1, 0] = np.arange(n, n + n_edges, dtype=np.int32)
        edges[2 * n_edges :, 0], edges[2 * n_edges :, 1] = middle.ravel(), before.ravel()

        kind = np.concatenate([self.kind, np.where(self.is_sharp, CREASE, SMOOTH)])
        is_sharp = np.zeros(len(edges), dtype=bool)
        is_sharp[: 2 * n_edges] = np.repeat(self.is_sharp, 2)
        return RefinedTopology(
            triangles.reshape(-1, 3),
            sides.reshape(-1, 3),
            edges,
            self._finer_halves(),
            is_sharp,
            kind,
            self._finer_rings,
        )

    def _finer_halves(self) -> tuple[IntArray, IntArray]:
        """Half-edges left and right of the edges of the finer mesh."""
        n_edges, m = len(self.edges), len(self.triangles)
        left, right = np.empty((2, 2 * n_edges + 3 * m), dtype=np.int32)
        corner = np.arange(3, dtype=np.int32)
        child = 12 * np.arange(m, dtype=np.int32)[:, None]
        left[2 * n_edges :] = (child + 3 * corner + 1).ravel()
        right[2 * n_edges :] = (child + 9 + (corner + 2) % 3).ravel()
        near, far = _children_along(self.left)
        left[: 2 * n_edges : 2], left[1 : 2 * n_edges : 2] = near, far
        near, far = _children_along(self.right)
        right[: 2 * n_edges : 2] = np.where(self.right < 0, -1, far)
        right[1 : 2 * n_edges : 2] = np.where(self.right < 0, -1, near)
        return left, right

    @cached_property
    def edge_point_rings(self) -> IntArray:
        """Neighbours in the finer mesh of the points on edges, (e, 6).

        Counter-clockwise from the second end of the edge on; on the boundary the first four.
        """
        n = self.n_vertices
        ring = np.empty((len(self.edges), 6), dtype=np.int32)
        ring[:, 3], ring[:, 0] = self.edges.T
        middle_of = n + self.sides.reshape(-1)
        for column, half_edge in ((1, self.left), (4, self.right)):
            following, preceding = _other_sides(half_edge)
            ring[:, column] = middle_of[following]
            ring[:, column + 1] = middle_of[preceding]
        return ring

    def _finer_rings(self) -> tuple[IntArray, IntArray, IntArray]:
        """Rings of the finer mesh: around the old vertices, then around the edge points."""
        n, n_edges = self.n_vertices, len(self.edges)
        halves = 2 * self.ring_edges
        owner = np.repeat(np.arange(n, dtype=np.int32), self.ring_size)
        halves += self.edges[:, 0][self.ring_edges] != owner

        ring = self.edge_point_rings
        spokes = np.empty((n_edges, 6), dtype=np.int32)
        spokes[:, 3] = np.arange(0, 2 * n_edges, 2)
        spokes[:, 0] = spokes[:, 3] + 1
        for column, half_edge in ((1, self.left), (4, self.right)):
            spokes[:, column] = 2 * n_edges + _other_sides(half_edge)[0]
            spokes[:, column + 1] = 2 * n_edges + half_edge
        size = np.full(n_edges, 6, dtype=np.int32)
        if (self.right < 0).any():
            size[self.right < 0] = 4
            is_there = np.arange(6) < size[:, None]
            ring, spokes = ring[is_there], spokes[is_there]
        end = self.ring_start[-1]
        return (
            np.concatenate([self.ring_start, end + np.cumsum(size, dtype=np.int32)]),
            np.concatenate([n + self.ring_edges, ring.reshape(-1)]),
            np.concatenate([halves, spokes.reshape(-1)]),
        )


def _other_sides(half_edge: IntArray) -> tuple[IntArray, IntArray]:
    """Half-edges after and before one in its triangle; meaningless for -1."""
    k = half_edge % 3
    start = half_edge - k
    return start + (k + 1) % 3, start + (k + 2) % 3


def _children_along(half_edge: IntArray) -> tuple[IntArray, IntArray]:
    """Half-edges of the children along a coarse one: that at its origin, that at its target."""
    triangle, k = half_edge // 3, half_edge % 3
    return 12 * triangle + 3 * k, 12 * triangle + 3 * ((k + 1) % 3) + 2


def unrefined_topology(
    topology: TriangleTopology, creases: LongArray, corners: BoolArray
) -> RefinedTopology:
    """Build level 0.

    Parameters
    ----------
    topology : TriangleTopology
    creases : (k, 2) int
        Vertex pairs of the sharp edges; the boundary is sharp anyway.
    corners : (n_vertices,) bool
        Vertices that stay where they are, beside those where more than two sharp edges meet.

    Raises
    ------
    InputError
        A crease is no edge of the mesh.
    """
    n, triangles, twin = topology.n_vertices, topology.triangles, topology.twin
    half_edges = np.arange(triangles.size, dtype=np.int32)
    origins, targets = topology.origins, triangles[:, [1, 2, 0]].reshape(-1)
    left = np.flatnonzero((twin < 0) | (half_edges < twin)).astype(np.int32)
    right = twin[left]
    side_of = np.empty(triangles.size, dtype=np.int32)
    side_of[left] = np.arange(len(left), dtype=np.int32)
    side_of[right[right >= 0]] = np.flatnonzero(right >= 0)
    edges = np.stack([origins[left], targets[left]], axis=1)

    ring_edges = np.empty(len(topology.ring), dtype=np.int32)
    ring_edges[topology.ring_start[origins] + topology.ring_position] = side_of
    border = np.flatnonzero(twin < 0)
    ring_edges[topology.ring_start[targets[border] + 1] - 1] = side_of[border]

    is_sharp = right < 0
    is_sharp[_edge_numbers(edges, creases, n)] = True
    n_sharp = np.bincount(edges[is_sharp].reshape(-1), minlength=n)
    kind = np.minimum(n_sharp, CORNER).astype(np.int8)
    kind[corners | topology.is_loose] = CORNER
    return RefinedTopology(
        triangles,
        side_of.reshape(-1, 3),
        edges,
        (left, right),
        is_sharp,
        kind,
        lambda: (topology.ring_start, topology.ring, ring_edges),
    )


def _edge_numbers(edges: IntArray, pairs: LongArray, n_vertices: int) -> IndexArray:
    """Find pairs of vertices among the edges."""
    keys, wanted = edge_keys(edges, n_vertices), edge_keys(pairs, n_vertices)
    order = np.argsort(keys)
    place = np.searchsorted(keys, wanted, sorter=order)
    numbers = order[np.minimum(place, len(keys) - 1)] if len(keys) else place
    found = keys[numbers] == wanted if len(keys) else np.zeros(len(wanted), dtype=bool)
    if not found.all():
        missing = pairs[~found]
        raise InputError(f"{len(missing)} creases are not edges of the mesh: {listed(missing)}")
    return numbers


def edge_keys(ends: IntArray | LongArray, n_vertices: int) -> LongArray:
    """Make one number of every vertex pair (e, 2), whatever the order of the two."""
    low, high = np.minimum(ends[:, 0], ends[:, 1]), np.maximum(ends[:, 0], ends[:, 1])
    keys: LongArray = low.astype(np.int64) * n_vertices + high
    return keys
