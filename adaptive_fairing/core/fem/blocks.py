"""Blocks and chunks of triangles that are integrated together.

    chunk     triangles of a slab or of several slabs (see `partition`): the work of one thread,
              scattered together
    block     triangles of a chunk with equally many quadrature points: the work of one numpy call
    group     triangles of a block with equally many control points
    segment   triangles of a group, or of a chunk, that one `PatchTables` serves

Each segment has matrix products with tables of its own; everything between the products runs over
all points of a block at once.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import groupby
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..linalg.symmetric_pattern import Pairs
from ..loop.patches import Segment
from ..runtime.arrays import IntArray
from ..runtime.precision import Precision
from .patch_tables import PatchTables, upper_pairs
from .table_cache import SpaceTables

Value = TypeVar("Value", np.float32, np.float64, np.int32)

# Large enough to hide the cost of a numpy call, and of threads taking turns at the interpreter;
# small enough for the cache.  In single precision half as many points take 3 % longer.
POINTS_PER_BLOCK = 98304


class Group(NamedTuple):
    """Place of a group's triangles in the arrays of their block and chunk.

    Attributes
    ----------
    n_control_points : int
        Of a triangle, K.
    columns : slice
        Among the triangles of the block.
    control : slice
        Of the (K, n) control points, among those of the block.
    entries : slice
        Of the (p, n) local matrix entries, among those of the chunk.
    """

    n_control_points: int
    columns: slice
    control: slice
    entries: slice

    @property
    def pairs(self) -> Pairs:
        """Pairs of control points, the p = K (K + 1) / 2 entries of a local matrix."""
        return upper_pairs(self.n_control_points)

    def of_control(self, values: NDArray[Value]) -> NDArray[Value]:
        """View values (…, n_control) at a block's control points as (…, K, n)."""
        own = values[..., self.control]
        return own.reshape(*values.shape[:-1], self.n_control_points, -1)

    def of_entries(self, values: NDArray[Value]) -> NDArray[Value]:
        """View values (n_entries,) of a chunk's local matrices as (p, n)."""
        return values[self.entries].reshape(len(self.pairs[0]), -1)


class BlockSegment(NamedTuple):
    """Place of a segment's triangles in the arrays of their block and chunk.

    Attributes
    ----------
    tables : PatchTables
    columns : slice
        Among the triangles of the block.
    group : Group
    in_group : slice
        Among the triangles of the group.
    """

    tables: PatchTables
    columns: slice
    group: Group
    in_group: slice

    def tables_in(self, precision: Precision) -> PatchTables:
        """Return the tables in single or double precision."""
        return self.tables if precision is np.float64 else self.tables.single

    def of_control(self, values: NDArray[Value]) -> NDArray[Value]:
        """View values (…, n_control) at a block's control points as (…, K, n)."""
        return self.group.of_control(values)[..., self.in_group]

    def of_entries(self, values: NDArray[Value]) -> NDArray[Value]:
        """View values (n_entries,) of a chunk's local matrices as (p, n)."""
        return self.group.of_entries(values)[:, self.in_group]


class Block:
    """Triangles with q quadrature points each.

    Parameters
    ----------
    segments : list of pairs (PatchTables, Segment)
        In ascending numbers of control points.
    control_points : (n_control,) int32
        Vertex numbers relative to the chunk's lowest one, group by group.
    first_control, first_entry : int
        Numbers of the block's first control point and local matrix entry in the chunk.

    Attributes
    ----------
    groups : list of Group
    segments : list of BlockSegment
    control_points : (n_control,) int32
    control : slice
        Of the control points, among those of the chunk.
    n_points : int
        Points of one triangle, q.
    triangles : (n_triangles,) int
        Which ones of the topology.
    n_triangles : int
    weights : (q, k), weight_starts : (k,) int
        Quadrature weights of the measures, and the first of the triangles that have them.
    """

    def __init__(
        self,
        segments: list[tuple[PatchTables, Segment]],
        control_points: IntArray,
        first_control: int,
        first_entry: int,
    ) -> None:
        self.control_points = control_points
        self.control = slice(first_control, first_control + len(control_points))
        self.n_points = segments[0][0].n_points
        self.groups: list[Group] = []
        self.segments: list[BlockSegment] = []
        column, control, entry = 0, 0, first_entry
        for members in _groups(segments):
            n_control_points = members[0][0].n_control_points
            n = sum(len(segment.triangles) for _, segment in members)
            controls = slice(control, control + n * n_control_points)
            entries = slice(entry, entry + n * len(members[0][0].pairs[0]))
            first = column
            group = Group(n_control_points, slice(first, first + n), controls, entries)
            for tables, segment in members:
                columns = slice(column, column + len(segment.triangles))
                in_group = slice(columns.start - first, columns.stop - first)
                self.segments.append(BlockSegment(tables, columns, group, in_group))
                column = columns.stop
            self.groups.append(group)
            control, entry = controls.stop, entries.stop
        self.triangles = np.concatenate([segment.triangles for _, segment in segments])
        self.n_triangles = column
        self.weights = np.concatenate([tables.weights[0] for tables, _ in segments], axis=1)
        self.weight_starts = np.concatenate(
            [s.columns.start + np.arange(s.tables.weights.shape[2]) for s in self.segments]
        )


class Chunk:
    """Triangles whose contributions are scattered together.

    Attributes
    ----------
    blocks : list of Block
    low, high : int
        Range of the vertices of all control points.
    control_points : (n_control,) int32
        Of all triangles, block by block, relative to `low`.
    n_entries : int
        Number of local matrix entries.
    """

    def __init__(self, segments: list[Segment], tables: SpaceTables) -> None:
        blocks = list(_block_wise(tables.of_chunk(segments)))
        of_blocks = [_control_points(block) for block in blocks]
        self.control_points = np.concatenate(of_blocks)
        self.low, self.high = int(self.control_points.min()), int(self.control_points.max()) + 1
        self.control_points -= np.int32(self.low)
        self.blocks: list[Block] = []
        control = self.n_entries = 0
        for block, own in zip(blocks, of_blocks, strict=True):
            first, control = control, control + len(own)
            self.blocks.append(
                Block(block, self.control_points[first:control], first, self.n_entries)
            )
            self.n_entries = self.blocks[-1].groups[-1].entries.stop


def _groups(
    segments: list[tuple[PatchTables, Segment]],
) -> Iterator[list[tuple[PatchTables, Segment]]]:
    """Part segments by their numbers of control points, which ascend."""
    for _, group in groupby(segments, lambda each: each[0].n_control_points):
        yield list(group)


def _control_points(segments: list[tuple[PatchTables, Segment]]) -> IntArray:
    """Put the control points of a block's segments together, group by group."""
    groups = [[segment.control_points for _, segment in group] for group in _groups(segments)]
    return np.concatenate([np.concatenate(each, axis=1).reshape(-1) for each in groups])


def _block_wise(
    segments: Iterable[tuple[PatchTables, Segment]],
) -> Iterator[list[tuple[PatchTables, Segment]]]:
    """Cut segments, and gather those of equally many points to full blocks."""
    gathered: list[tuple[PatchTables, Segment]] = []
    room = 0
    for tables, segment in sorted(segments, key=_shape):
        if gathered and gathered[0][0].n_points != tables.n_points:
            yield gathered
            gathered = []
        first, count = 0, len(segment.triangles)
        while first < count:
            room = room if gathered else max(POINTS_PER_BLOCK // tables.n_points, 1)
            # Segments with a table for each triangle stay whole: the block may become larger.
            last = min(first + room, count) if tables.is_shared else count
            gathered.append((tables, segment.part(first, last)))
            room -= last - first
            first = last
            if room <= 0:
                yield gathered
                gathered = []
    if gathered:
        yield gathered


def _shape(segment: tuple[PatchTables, Segment]) -> tuple[int, int]:
    """Numbers of points and of control points."""
    return segment[0].n_points, segment[0].n_control_points
