"""The patches of a mesh: triangles grouped by patch class, with their control points.

Triangles are parted into chunks, and each chunk is sorted by class.  A run of triangles of one
class within a chunk is a segment: its integrals are dense matrix products.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..mesh.topology import TriangleTopology
from ..runtime.arrays import IndexArray, IntArray, LongArray
from ..runtime.lazy import cached_property
from ..runtime.threads import ordered_map
from .partition import chunk_triangles
from .patch_class import TETRAHEDRON, Corner, PatchClass, count_control_points
from .quadrature import QuadratureChoice, quadrature_choice

# Up to so many times their number, values are sorted by marking them in a table.
SMALL_VALUES = 4


class Segment(NamedTuple):
    """A run of triangles of one class.

    Attributes
    ----------
    class_index : int
        -1 for triangles of several classes.
    triangles : (n,) int
        Which triangles of the topology.
    control_points : (n_control_points, n) int32
        Vertex indices.
    """

    class_index: int
    triangles: IndexArray
    control_points: IntArray

    def part(self, first: int, last: int) -> Segment:
        """Return the triangles `first` to `last` - 1."""
        own = slice(first, last)
        return Segment(self.class_index, self.triangles[own], self.control_points[:, own])


class PatchSet:
    """All patches of a triangulation, ready for chunk-wise integration.

    Parameters
    ----------
    topology : TriangleTopology
    part_of : TriangleTopology, optional
        A larger mesh whose quadrature is to be used: what is integrated is then the same there.

    Attributes
    ----------
    topology : TriangleTopology
    classes : list of PatchClass
        Distinct connectivities, up to rotation of the triangle.
    class_of : (n_triangles,) int
        Class of every triangle.
    class_sizes : (n_classes,) int
        Number of triangles of each.
    n_control_points : (n_classes,) int
    """

    def __init__(self, topology: TriangleTopology, part_of: TriangleTopology | None = None) -> None:
        self.topology = topology
        self._part_of = part_of or topology
        self._codes, self._corners = corner_codes(topology)
        self.class_of, self._first_corner, class_codes = class_groups(self._codes.reshape(-1, 3))
        self.classes: list[PatchClass] = [
            (self._corners[a], self._corners[b], self._corners[c])
            for a, b, c in class_codes.tolist()
        ]
        self.class_sizes = np.bincount(self.class_of, minlength=len(self.classes))
        self.n_control_points = np.array([count_control_points(c) for c in self.classes], dtype=int)

    @cached_property
    def chunks(self) -> list[list[Segment]]:
        """Every triangle occurs in exactly one segment."""
        return list(ordered_map(self._segments, chunk_triangles(self.class_of, self.class_sizes)))

    @property
    def segments(self) -> Iterator[Segment]:
        """All segments, chunk by chunk."""
        for chunk in self.chunks:
            yield from chunk

    def quadrature(self, tolerance: float) -> QuadratureChoice:
        """Pick the rules that keep M and L of this mesh within a tolerance."""
        n_triangles = max(self._part_of.n_triangles, 1)
        return quadrature_choice(tolerance, n_triangles, self._part_of.n_regular / n_triangles)

    def _segments(self, chunk: IndexArray) -> list[Segment]:
        """Sort the triangles of a chunk by class."""
        class_of = self.class_of[chunk]
        # Small numbers are sorted by counting, in linear time.
        small = class_of.astype(np.min_scalar_type(len(self.classes)))
        order = np.argsort(small, kind="stable")
        bounds = np.flatnonzero(np.diff(class_of[order], prepend=-1, append=-1))
        triangles = chunk[order]
        flat, starts = self._control_points(triangles, bounds)
        segments = []
        for k, (low, high) in enumerate(pairwise(bounds.tolist())):
            control = flat[starts[k] : starts[k + 1]].reshape(-1, high - low)
            class_index = int(self.class_of[triangles[low]])
            segments.append(Segment(class_index, triangles[low:high], control))
        return segments

    def _control_points(
        self, triangles: IndexArray, bounds: IndexArray
    ) -> tuple[IntArray, LongArray]:
        """Fill the control points of all segments into one array; also where each starts."""
        topology = self.topology
        sizes = np.diff(bounds)
        lengths = sizes * self.n_control_points[self.class_of[triangles[bounds[:-1]]]]
        starts = np.concatenate([[0], np.cumsum(lengths)])
        flat = np.empty(starts[-1], dtype=np.int32)
        # Control point s of the k-th triangle of a segment lies at start + s * size + k.
        stride = np.repeat(sizes, sizes)
        place = np.repeat(starts[:-1] - bounds[:-1], sizes) + np.arange(len(triangles))
        first_corner = self._first_corner[triangles]
        half_edges = [3 * triangles + (first_corner + k) % 3 for k in range(3)]
        origins = topology.origins
        for half_edge in half_edges:
            flat[place] = origins[half_edge]
            place += stride
        for half_edge in half_edges:
            code = self._codes[half_edge]
            added = np.zeros(len(triangles), dtype=np.int64)
            for value in _numbered(code)[0].tolist():
                corner = self._corners[value]
                members = slice(None) if (code == value).all() else np.flatnonzero(code == value)
                edges, at, step = half_edge[members], place[members], stride[members]
                start = topology.ring_start[origins[edges]]
                position = topology.ring_position[edges]
                entries = np.array(corner.own_entries, dtype=np.int32)[:, None]
                index = position + entries
                if not corner.is_boundary:
                    index %= corner.ring_size
                flat[at + step * np.arange(len(entries))[:, None]] = topology.ring[start + index]
                added[members] = len(entries)
            place += added * stride
        self._complete_tetrahedra(triangles, half_edges[0], flat, place)
        return flat, starts

    def _complete_tetrahedra(
        self,
        triangles: IndexArray,
        half_edge: IndexArray,
        flat: IntArray,
        place: LongArray,
    ) -> None:
        """Add the fourth vertex of a tetrahedron, which no corner of its triangles owns."""
        if TETRAHEDRON in self.classes:
            topology = self.topology
            members = self.class_of[triangles] == self.classes.index(TETRAHEDRON)
            edges = half_edge[members]
            start = topology.ring_start[topology.origins[edges]]
            flat[place[members]] = topology.ring[start + (topology.ring_position[edges] + 2) % 3]


def corner_codes(topology: TriangleTopology) -> tuple[LongArray, dict[int, Corner]]:
    """Assign a code to every corner connectivity: a code per half-edge, and what codes mean."""
    origins = topology.origins
    codes = topology.ring_size[origins].astype(np.int64)
    stride = int(topology.ring_size.max(initial=0)) + 1
    border = np.flatnonzero(topology.on_boundary[origins])
    codes[border] += stride * (1 + topology.ring_position[border].astype(np.int64))
    decode = {}
    names, _ = _numbered(codes)
    for code in names.tolist():
        fan, ring_size = divmod(code, stride)
        decode[code] = Corner(ring_size, fan - 1)
    return codes, decode


def class_groups(
    codes: LongArray,
) -> tuple[IndexArray, LongArray, LongArray]:
    """Group triangles by their corner codes up to rotation.

    Returns
    -------
    class_of : (n_triangles,), first_corner : (n_triangles,), class_codes : (n_classes, 3)
        Class of each triangle, the corner at which its canonical order starts, and the codes.
    """
    names, numbers = _numbered(codes.reshape(-1))
    # Small numbers: the cube of the codes themselves could overflow.
    base = max(len(names), 1)
    small = numbers.astype(np.min_scalar_type(base**3))
    a, b, c = np.ascontiguousarray(small.reshape(-1, 3).T)
    keys = np.stack(
        [(a * base + b) * base + c, (b * base + c) * base + a, (c * base + a) * base + b]
    )
    smallest = keys.min(axis=0)
    # The same as argmin, which takes several times as long along this axis.
    first_corner = np.where(smallest == keys[0], 0, np.where(smallest == keys[1], 1, 2))
    unique, class_of = _numbered(smallest)
    class_codes = names[np.stack([unique // base**2, unique // base % base, unique % base], axis=1)]
    return class_of, first_corner, class_codes


def _numbered(values: LongArray) -> tuple[LongArray, IndexArray]:
    """Distinct values, ascending, and the number of each value among them; values ≥ 0."""
    largest = int(values.max(initial=0))
    if largest > SMALL_VALUES * len(values):
        names, numbers = np.unique(values, return_inverse=True)
        return names, numbers.reshape(-1)
    occurs = np.zeros(largest + 1, dtype=bool)
    occurs[values] = True
    return np.flatnonzero(occurs), (np.cumsum(occurs) - 1)[values]
