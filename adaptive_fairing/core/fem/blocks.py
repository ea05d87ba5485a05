"""Blocks: the triangles that are integrated in one go.

A block is as many triangles as one numpy call should work on.  It may hold parts of
several patch classes that have equally many points: what differs by class is a matrix product per
part, everything between the products runs over all points of the block at once.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..loop.patches import Segment
from ..runtime.arrays import IntArray
from ..runtime.precision import Precision
from .class_tables import ClassTables
from .table_cache import Piece, SpaceTables, Tables

Value = TypeVar("Value", np.float32, np.float64, np.int32)

# Large enough to hide the cost of a numpy call, and of threads taking turns at the interpreter;
# small enough for the cache: in single precision, half or twice as many points take longer.
POINTS_PER_BLOCK = 24576


class Part(NamedTuple):
    """Triangles of one class within a block, or of several rare classes.

    Attributes
    ----------
    tables : Tables
    columns : slice
        The triangles' places among those of the block.
    control : slice
        Place of the (K, n) control points among those of the block.
    """

    tables: Tables
    columns: slice
    control: slice

    @property
    def n_triangles(self) -> int:
        """Number of triangles."""
        return int(self.columns.stop - self.columns.start)

    @property
    def n_entries(self) -> int:
        """Number of local matrix entries."""
        return len(self.tables.pairs[0]) * self.n_triangles

    def tables_in(self, precision: Precision) -> Tables:
        """Return the tables in single or double precision."""
        return self.tables if precision is np.float64 else self.tables.single

    def of_control(self, values: NDArray[Value]) -> NDArray[Value]:
        """View values (…, n_control) at a block's control points as those of this part's."""
        own = values[..., self.control]
        return own.reshape(*values.shape[:-1], self.tables.n_control_points, -1)


class Block:
    """Triangles of one or several classes with q quadrature points each.

    Attributes
    ----------
    parts : list of Part
    n_points : int
        Points of one triangle, q.
    n_triangles : int
    control_points : (n_control,) int32
        Vertex numbers relative to the chunk's lowest one, part by part.
    triangles : (n_triangles,) int32
        Which triangles of the topology.
    weights : (q, k), weight_starts : (k,) int
        Quadrature weights, and the first of the triangles that have them.
    """

    def __init__(self, pieces: list[Piece], control_points: IntArray) -> None:
        self.n_points = pieces[0].tables.n_points
        self.control_points = control_points
        self.triangles = np.concatenate([p.triangles for p in pieces]).astype(np.int32)
        self.n_triangles = len(self.triangles)
        self.parts: list[Part] = []
        column = control = 0
        for piece in pieces:
            ends = column + len(piece.triangles), control + piece.control_points.size
            self.parts.append(Part(piece.tables, slice(column, ends[0]), slice(control, ends[1])))
            column, control = ends
        self.weights = np.concatenate([part.tables.weights for part in self.parts], axis=1)
        self.weight_starts = np.concatenate(
            [part.columns.start + np.arange(part.tables.weights.shape[1]) for part in self.parts]
        )

    @property
    def n_entries(self) -> int:
        """Number of local matrix entries."""
        return sum(part.n_entries for part in self.parts)


class Chunk:
    """Neighbouring triangles whose contributions are scattered together.

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
        self.low = min(int(segment.control_points.min()) for segment in segments)
        self.high = max(int(segment.control_points.max()) for segment in segments) + 1
        groups = list(_blocks(tables.pieces(segments)))
        flat = [piece.control_points.reshape(-1) for pieces in groups for piece in pieces]
        self.control_points = np.concatenate(flat)
        self.control_points -= np.int32(self.low)
        self.blocks = []
        n_done = 0
        for pieces in groups:
            n_control = sum(piece.control_points.size for piece in pieces)
            own = self.control_points[n_done : n_done + n_control]
            self.blocks.append(Block(pieces, own))
            n_done += n_control
        self.n_entries = sum(block.n_entries for block in self.blocks)


def _blocks(pieces: list[Piece]) -> Iterator[list[Piece]]:
    """Cut pieces, and gather those of equally many points to full blocks."""
    gathered: list[Piece] = []
    room = 0
    for piece in sorted(pieces, key=lambda piece: piece.tables.n_points):
        n_points = piece.tables.n_points
        if gathered and gathered[0].tables.n_points != n_points:
            yield gathered
            gathered = []
        first, count = 0, len(piece.triangles)
        while first < count:
            room = room if gathered else max(POINTS_PER_BLOCK // n_points, 1)
            # Tables of single triangles stay together, the block may become a little larger.
            last = min(first + room, count) if isinstance(piece.tables, ClassTables) else count
            gathered.append(piece.part(first, last))
            room -= last - first
            first = last
            if room <= 0:
                yield gathered
                gathered = []
    if gathered:
        yield gathered
