r"""Connectivity of a triangulated surface: half-edges, twins, ordered one-rings, boundary.

Half-edge ``h = 3 f + k`` of triangle ``f`` runs from corner ``k`` to corner ``k + 1``.  Around an
interior vertex the one-ring is a cycle; around a boundary vertex it is a chain that starts at the
outgoing boundary edge.  Both run counter-clockwise as seen from outside.

    ring[1]   ring[0]
        \     /
         \   /          half-edge v -> ring[j] lies in the triangle (v, ring[j], ring[j+1])
    ----- v -----       and has ring position j at v
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, DTypeLike
from scipy import sparse

from ..errors import InputError, TopologyError, listed
from ..runtime.arrays import BoolArray, IndexArray, IntArray, LongArray
from ..runtime.lazy import cached_property
from .input_checks import plain_array


class TriangleTopology:
    """Connectivity of an oriented edge- and vertex-manifold triangulation, open or closed.

    Parameters
    ----------
    faces : (n_triangles, 3) int
        Vertex indices of each triangle, consistently oriented.
    n_vertices : int
        Number of vertices; vertices that no triangle uses are allowed and are called loose.

    Attributes
    ----------
    triangles : (n_triangles, 3) int32
    twin : (3 n_triangles,) int32
        Opposite half-edge, -1 on the boundary.
    ring_start : (n_vertices + 1,) int32, ring : (ring_start[-1],) int32
        Ordered one-rings, one after the other.
    ring_size : (n_vertices,) int32
        Number of neighbours; for an interior vertex this is its valence.
    ring_position : (3 n_triangles,) int32
        Place of a half-edge's target in the one-ring of its origin.
    on_boundary : (n_vertices,) bool

    Raises
    ------
    InputError
        `faces` is not an (m, 3) integer array with indices in range.
    TopologyError
        Repeated vertices in a triangle, an edge shared by more than two triangles, neighbours of
        opposite orientation, a vertex whose triangles form more than one fan, or a closed vertex
        of valence 2.

    Examples
    --------
    >>> from adaptive_fairing.core import TriangleTopology
    >>> square = TriangleTopology([(0, 1, 2), (0, 2, 3)], n_vertices=4)
    >>> square.ring[square.ring_start[0] : square.ring_start[1]].tolist()  # around vertex 0
    [1, 2, 3]
    >>> square.twin.tolist()  # only the edge between 0 and 2 has two triangles
    [-1, -1, 3, 2, -1, -1]
    """

    def __init__(self, faces: ArrayLike, n_vertices: int) -> None:
        self.triangles = checked_triangles(faces, n_vertices)
        _require_distinct_corners(self.triangles)
        self.n_vertices = int(n_vertices)
        self.n_triangles = len(self.triangles)
        self.twin = _twins(self.triangles, self.n_vertices)
        self.on_boundary = np.zeros(self.n_vertices, dtype=bool)
        self.on_boundary[self.origins[self.twin < 0]] = True
        self._build_rings()

    @property
    def origins(self) -> IntArray:
        """Origin vertex of every half-edge, (3 n_triangles,)."""
        return self.triangles.reshape(-1)

    @property
    def inner_edges(self) -> IndexArray:
        """One half-edge of every edge between two triangles, ascending."""
        return np.flatnonzero(self.twin > np.arange(len(self.twin)))

    @property
    def is_closed(self) -> bool:
        """Whether no edge lies on a boundary."""
        return not self.on_boundary.any()

    @property
    def is_loose(self) -> BoolArray:
        """Vertices that no triangle uses, (n_vertices,)."""
        loose: BoolArray = self.ring_size == 0
        return loose

    @property
    def boundary_vertices(self) -> IndexArray:
        """Indices of the vertices on a boundary, ascending."""
        return np.flatnonzero(self.on_boundary)

    @property
    def boundary_neighbours(self) -> tuple[IntArray, IntArray]:
        """Next and previous vertex of the boundary at each of `boundary_vertices`, (r,) each.

        The boundary runs in the direction of its half-edges.
        """
        border = self.boundary_vertices
        return self.ring[self.ring_start[border]], self.ring[self.ring_start[border + 1] - 1]

    @cached_property
    def n_regular(self) -> int:
        """Count of triangles whose vertices all have 6 neighbours, or 4 on the boundary."""
        is_regular = self.ring_size == np.where(self.on_boundary, 4, 6)
        a, b, c = is_regular[self.triangles].T
        return int(np.count_nonzero(a & b & c))

    def adjacency(self, dtype: DTypeLike = np.int8) -> sparse.csr_array:
        """Vertex adjacency (n_vertices, n_vertices): ones, with unsorted columns in each row."""
        data = np.ones(len(self.ring), dtype=dtype)
        shape = (self.n_vertices, self.n_vertices)
        return sparse.csr_array((data, self.ring, self.ring_start), shape=shape)

    def _build_rings(self) -> None:
        origins, targets = self.origins, self.triangles[:, [1, 2, 0]].reshape(-1)
        n_half_edges = len(origins)
        half_edges = np.arange(n_half_edges, dtype=np.int32)
        # The next half-edge around a vertex is the twin of the one that ends there.
        following = self.twin.reshape(-1, 3)[:, [2, 0, 1]].reshape(-1)
        fan_size = np.bincount(origins, minlength=self.n_vertices).astype(np.int32)
        # One start per vertex: any half-edge, but on the boundary the one without a twin.
        start = np.full(self.n_vertices, -1, dtype=np.int32)
        start[origins] = half_edges
        border = np.flatnonzero(self.twin < 0).astype(np.int32)
        start[origins[border]] = border

        self.ring_position = np.full(n_half_edges, -1, dtype=np.int32)
        begin = current = start[fan_size > 0]
        position = 0
        while len(current):
            self.ring_position[current] = position
            position += 1
            current = following[current]
            goes_on = (current != begin) & (current >= 0)
            if not goes_on.all():
                begin, current = begin[goes_on], current[goes_on]

        # A second fan at a vertex, or a cycle that closes early, leaves half-edges unvisited.
        split = np.unique(origins[self.ring_position < 0])
        if len(split):
            raise TopologyError(
                f"{len(split)} non-manifold vertices, where surfaces touch in a single point: "
                f"{listed(split)}; separate them there",
                vertices=split,
            )

        self.ring_size = fan_size + self.on_boundary
        self.ring_start = np.zeros(self.n_vertices + 1, dtype=np.int32)
        np.cumsum(self.ring_size, out=self.ring_start[1:])
        self.ring = np.empty(self.ring_start[-1], dtype=np.int32)
        self.ring[self.ring_start[origins] + self.ring_position] = targets
        # The last neighbour of a boundary vertex is where the boundary comes from.
        self.ring[self.ring_start[targets[border] + 1] - 1] = origins[border]
        pillow = np.flatnonzero((self.ring_size == 2) & ~self.on_boundary)
        if len(pillow):
            raise TopologyError(
                f"{len(pillow)} closed vertices of valence 2 (two triangles back to back): "
                f"{listed(pillow)}; delete one triangle of each pair",
                vertices=pillow,
            )


def following(half_edge: IndexArray | IntArray, steps: int = 1) -> IndexArray:
    """Half-edges so many steps further around their triangles, (k,)."""
    return half_edge - half_edge % 3 + (half_edge + steps) % 3


def require_topology(topology: object) -> None:
    """Refuse an argument that is not a topology; most likely it is the faces or the positions."""
    if not isinstance(topology, TriangleTopology):
        raise InputError(
            "the topology comes first, TriangleTopology(faces, n_vertices), and then positions; "
            f"not {type(topology).__name__}"
        )


def checked_triangles(faces: ArrayLike, n_vertices: int) -> IntArray:
    """Copy `faces` as (m, 3) int32, or raise InputError if they cannot be vertex indices."""
    array = plain_array(faces, "faces")
    if array.size == 0:
        return np.empty((0, 3), dtype=np.int32)
    if array.ndim != 2 or array.shape[1] != 3:
        raise InputError(f"faces must have shape (m, 3), not {array.shape}; triangulate first")
    if array.dtype.kind not in "iu":
        raise InputError(f"faces must be integers, not {array.dtype}")
    if array.min() < 0 or array.max() >= n_vertices:
        outside = np.flatnonzero(((array < 0) | (array >= n_vertices)).any(axis=1))
        raise InputError(
            f"{len(outside)} triangles use vertices outside 0 … {n_vertices - 1}: "
            f"triangles {listed(outside)}"
        )
    return np.ascontiguousarray(array, dtype=np.int32)


def _require_distinct_corners(triangles: IntArray) -> None:
    repeated = np.flatnonzero(
        (triangles[:, 0] == triangles[:, 1])
        | (triangles[:, 1] == triangles[:, 2])
        | (triangles[:, 2] == triangles[:, 0])
    )
    if len(repeated):
        raise TopologyError(
            f"{len(repeated)} triangles use one vertex twice: triangles {listed(repeated)}; "
            "delete them",
            triangles=repeated,
        )


def _twins(triangles: IntArray, n_vertices: int) -> IntArray:
    """Match every half-edge with its opposite; -1 where there is none."""
    origins, targets = triangles.reshape(-1), triangles[:, [1, 2, 0]].reshape(-1)
    half_edges = np.arange(len(origins), dtype=np.int32)
    shape = (n_vertices, n_vertices)
    outgoing = sparse.coo_array((half_edges, (origins, targets)), shape=shape).tocsr()
    if outgoing.nnz < len(half_edges):  # compressing adds up entries of the same place
        raise _edge_error(origins, targets, n_vertices)
    incoming = outgoing.T.tocsr()
    twin = np.full(len(origins), -1, dtype=np.int32)
    if np.array_equal(incoming.indptr, outgoing.indptr) and np.array_equal(
        incoming.indices, outgoing.indices
    ):
        twin[outgoing.data] = incoming.data  # closed: both matrices have one pattern
        return twin
    keys_in, keys_out = _entry_keys(incoming), _entry_keys(outgoing)
    place = np.minimum(np.searchsorted(keys_in, keys_out), len(keys_in) - 1)
    found = keys_in[place] == keys_out
    twin[outgoing.data[found]] = incoming.data[place[found]]
    return twin


def _entry_keys(matrix: sparse.csr_array) -> LongArray:
    """Return the stored entries of a row-compressed matrix as ascending n · row + column."""
    n_rows, n_columns = matrix.shape
    rows = np.repeat(np.arange(n_rows, dtype=np.int64), np.diff(matrix.indptr))
    return rows * n_columns + matrix.indices


def _edge_error(origins: IntArray, targets: IntArray, n_vertices: int) -> TopologyError:
    """Error that names edges with more than two triangles, or with two that run the same way."""
    low, high = np.minimum(origins, targets), np.maximum(origins, targets)
    keys, counts = np.unique(low.astype(np.int64) * n_vertices + high, return_counts=True)
    crowded = keys[counts > 2]
    if len(crowded):
        edges = np.stack([crowded // n_vertices, crowded % n_vertices], axis=1)
        return TopologyError(
            f"{len(edges)} non-manifold edges, shared by more than two triangles: "
            f"{listed(edges)}; delete the extra triangles or split the surface there",
            edges=edges,
        )
    directed = origins.astype(np.int64) * n_vertices + targets
    keys, counts = np.unique(directed, return_counts=True)
    same_way = keys[counts > 1]
    edges = np.stack([same_way // n_vertices, same_way % n_vertices], axis=1)
    return TopologyError(
        f"{len(edges)} edges whose two triangles have opposite orientation: {listed(edges)}; "
        "recalculate the normals",
        edges=edges,
    )
