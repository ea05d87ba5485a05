"""The patches of a mesh: triangles grouped by patch class, with their control points.

Triangles are cut into chunks of neighbouring ones, and each chunk is sorted by class.  A run of
triangles of one class within a chunk is a segment: its integrals are dense matrix products.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .patch_class import TETRAHEDRON, ControlPoints, Corner, PatchClass
from .topology import TriangleTopology

# Threads that change places at every small array wait for the interpreter more than they compute:
# chunks are large, but for meshes that would then have too few for all threads.
LARGEST_CHUNK, SMALLEST_CHUNK, USUAL_CHUNKS = 32768, 4096, 4


class Segment(NamedTuple):
    """A run of triangles of one class.

    Attributes
    ----------
    class_index : int
    triangles : (n,) int
        Which triangles of the topology.
    control_points : (n_control_points, n) int32
        Vertex indices.
    """

    class_index: int
    triangles: NDArray[np.intp]
    control_points: NDArray[np.int32]

    def part(self, first: int, last: int) -> Segment:
        """Return the triangles `first` to `last` - 1 of this segment."""
        return Segment(
            self.class_index, self.triangles[first:last], self.control_points[:, first:last]
        )


class PatchSet:
    """All patches of a triangulation, ready for chunk-wise integration.

    Attributes
    ----------
    classes : list of PatchClass
        Distinct connectivities, up to rotation of the triangle.
    class_sizes : (n_classes,) int
        Number of triangles of each.
    chunks : list of lists of Segment
        Every triangle occurs in exactly one segment.
    """

    def __init__(self, topology: TriangleTopology) -> None:
        codes, decode = corner_codes(topology)
        codes = codes.reshape(-1, 3)
        class_of, first_corner, class_codes = class_groups(codes)
        self.classes: list[PatchClass] = [
            (decode[a], decode[b], decode[c]) for a, b, c in class_codes.tolist()
        ]
        self.class_sizes = np.bincount(class_of, minlength=len(self.classes))
        self.n_control_points = np.array([ControlPoints(c).count for c in self.classes], dtype=int)

        chunk_of = np.arange(topology.n_triangles) // chunk_size(topology.n_triangles)
        group = chunk_of * len(self.classes) + class_of
        order = np.argsort(group, kind="stable")
        bounds = np.flatnonzero(np.diff(group[order], prepend=-1, append=-1))
        self.chunks: list[list[Segment]] = (
            [[] for _ in range(chunk_of[-1] + 1)] if len(order) else []
        )

        flat, starts = self._control_points(
            topology, codes, decode, class_of[order], first_corner[order], order, bounds
        )
        for k, (low, high) in enumerate(pairwise(bounds.tolist())):
            triangles = order[low:high]
            class_index = int(class_of[triangles[0]])
            control = flat[starts[k] : starts[k + 1]].reshape(-1, high - low)
            self.chunks[chunk_of[triangles[0]]].append(Segment(class_index, triangles, control))

    @property
    def segments(self) -> Iterator[Segment]:
        """All segments, chunk by chunk."""
        for chunk in self.chunks:
            yield from chunk

    def _control_points(
        self,
        topology: TriangleTopology,
        codes: NDArray[np.int64],
        decode: dict[int, Corner],
        class_of: NDArray[np.int64],
        first_corner: NDArray[np.int64],
        order: NDArray[np.intp],
        bounds: NDArray[np.intp],
    ) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
        """Fill the control points of all segments into one array; also where each starts."""
        sizes = np.diff(bounds)
        lengths = sizes * self.n_control_points[class_of[bounds[:-1]]]
        starts = np.concatenate([[0], np.cumsum(lengths)])
        flat = np.empty(starts[-1], dtype=np.int32)
        # Control point s of the k-th triangle of a segment lies at start + s * size + k.
        stride = np.repeat(sizes, sizes)
        place = np.repeat(starts[:-1] - bounds[:-1], sizes) + np.arange(len(order))
        half_edges = [3 * order + (first_corner + k) % 3 for k in range(3)]
        origins, flat_codes = topology.origins, codes.reshape(-1)
        for half_edge in half_edges:
            flat[place] = origins[half_edge]
            place += stride
        for half_edge in half_edges:
            code = flat_codes[half_edge]
            added = np.zeros(len(order), dtype=np.int64)
            for value in np.unique(code).tolist():
                corner = decode[value]
                members = slice(None) if (code == value).all() else np.flatnonzero(code == value)
                edges, at, step = half_edge[members], place[members], stride[members]
                start = topology.ring_start[origins[edges]]
                position = topology.ring_position[edges]
                for k, entry in enumerate(corner.own_entries):
                    index = position + entry
                    if not corner.is_boundary:
                        index %= corner.ring_size
                    flat[at + k * step] = topology.ring[start + index]
                added[members] = len(corner.own_entries)
            place += added * stride
        self._complete_tetrahedra(topology, flat, place, class_of, half_edges[0])
        return flat, starts

    def _complete_tetrahedra(
        self,
        topology: TriangleTopology,
        flat: NDArray[np.int32],
        place: NDArray[np.int64],
        class_of: NDArray[np.int64],
        half_edge: NDArray[np.int64],
    ) -> None:
        """Add the fourth vertex of a tetrahedron, which no corner of its triangles owns."""
        if TETRAHEDRON in self.classes:
            members = class_of == self.classes.index(TETRAHEDRON)
            edges = half_edge[members]
            start = topology.ring_start[topology.origins[edges]]
            flat[place[members]] = topology.ring[start + (topology.ring_position[edges] + 2) % 3]


def chunk_size(n_triangles: int) -> int:
    """How many triangles a chunk of a mesh has; the same on every machine, as results are."""
    return min(max(-(-n_triangles // USUAL_CHUNKS), SMALLEST_CHUNK), LARGEST_CHUNK)


def corner_codes(topology: TriangleTopology) -> tuple[NDArray[np.int64], dict[int, Corner]]:
    """Assign a code to every corner connectivity: a code per half-edge, and what codes mean."""
    origins = topology.origins
    codes = topology.ring_size[origins].astype(np.int64)
    stride = int(topology.ring_size.max(initial=0)) + 1
    border = np.flatnonzero(topology.on_boundary[origins])
    codes[border] += stride * (1 + topology.ring_position[border].astype(np.int64))
    decode = {}
    for code in np.unique(codes).tolist():
        fan, ring_size = divmod(code, stride)
        decode[code] = Corner(ring_size, fan - 1)
    return codes, decode


def class_groups(
    codes: NDArray[np.int64],
) -> tuple[NDArray[np.intp], NDArray[np.int64], NDArray[np.int64]]:
    """Group triangles by their corner codes up to rotation.

    Returns
    -------
    class_of : (n_triangles,), first_corner : (n_triangles,), class_codes : (n_classes, 3)
        Class of each triangle, the corner at which its canonical order starts, and the codes.
    """
    names, codes = np.unique(codes, return_inverse=True)
    codes = codes.reshape(-1, 3)
    # Small numbers: the cube of the codes themselves could overflow.
    base = max(len(names), 1)
    keys = np.stack(
        [
            (codes[:, k] * base + codes[:, (k + 1) % 3]) * base + codes[:, (k + 2) % 3]
            for k in range(3)
        ]
    )
    first_corner = keys.argmin(axis=0)
    unique, class_of = np.unique(keys.min(axis=0, initial=base**3), return_inverse=True)
    class_codes = names[np.stack([unique // base**2, unique // base % base, unique % base], axis=1)]
    return class_of.reshape(-1), first_corner, class_codes
