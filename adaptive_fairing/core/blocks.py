"""Blocks: the triangles that are integrated in one go, with the surface at their points.

A block is as many triangles as one numpy call should work on.  It may hold parts of
several patch classes that have equally many points: what differs by class is a matrix product per
part, everything between the products runs over all points of the block at once.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from .class_tables import ClassTables
from .geometry import Metric, mean_curvature, metric_at
from .parallel import Workspace
from .patches import Segment
from .space_tables import Piece, SpaceTables, Tables

FloatArray = NDArray[np.float64]
Value = TypeVar("Value", np.float64, np.int32)

_workspace = Workspace()

# Large enough to hide the cost of a numpy call, and of threads taking turns at the interpreter;
# small enough for the cache: twice as many points take a tenth longer.
POINTS_PER_BLOCK = 12288


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

    def __init__(self, pieces: list[Piece], control_points: NDArray[np.int32]) -> None:
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


class SurfaceBlock(NamedTuple):
    """Surface and field at the quadrature points of a block, until the thread's next block.

    Points run over the quadrature points first, then over the triangles: arrays (…, n_points) can
    be seen as (…, q, n_triangles).

    Attributes
    ----------
    values : (4, n_points)
        Coordinates and a scalar field.
    tangents : (2, 3, n_points)
        ∂1 x, ∂2 x.
    metric : Metric
    second_derivatives : (3, 3, n_points) or None
        ∂11 x, ∂12 x, ∂22 x, if they were asked for.
    """

    values: FloatArray
    tangents: FloatArray
    metric: Metric
    second_derivatives: FloatArray | None


def evaluate(block: Block, columns: FloatArray, curved: bool) -> SurfaceBlock:
    """Evaluate the surface at the quadrature points of a block.

    Parameters
    ----------
    block : Block
    columns : (4, n)
        Coordinates and field of the chunk's vertices, from its lowest one on.
    curved : bool
        Whether second derivatives are wanted.
    """
    control = _workspace.array("control", 4, len(block.control_points))
    for column, row in zip(columns, control, strict=True):
        np.take(column, block.control_points, out=row, mode="clip")
    n_derivatives = 6 if curved else 3
    shape = block.n_points, block.n_triangles
    values = _workspace.array("values", 4, *shape)
    jets = _workspace.array("jets", 3, n_derivatives, *shape)
    rows = jets.reshape(3, -1, block.n_triangles)
    for part in block.parts:
        own = part.of_control(control)
        part.tables.evaluate(own[:3], n_derivatives, out=rows[..., part.columns])
        part.tables.evaluate(own[3:], 1, out=values[3:, :, part.columns])
    values[:3] = jets[:, 0]
    by_derivative = jets.reshape(3, n_derivatives, -1).swapaxes(0, 1)
    tangents, second_derivatives = by_derivative[1:3], by_derivative[3:] if curved else None
    return SurfaceBlock(values.reshape(4, -1), tangents, metric_at(tangents), second_derivatives)


def integrate_measures(block: Block, surface: SurfaceBlock) -> FloatArray:
    """Curvature energy, area and volume of a block, (3,)."""
    metric = surface.metric
    integrands = _workspace.array("integrands", 3, len(metric.area_element))
    if surface.second_derivatives is not None:
        np.square(mean_curvature(metric, surface.second_derivatives), out=integrands[0])
        integrands[0] *= metric.area_element
    else:
        integrands[0] = 0
    integrands[1] = metric.area_element
    np.einsum("dp,dp->p", surface.values[:3], metric.normal, out=integrands[2])
    by_point = integrands.reshape(3, block.n_points, block.n_triangles)
    sums = np.add.reduceat(by_point, block.weight_starts, axis=2)
    totals: FloatArray = np.einsum("iqk,qk->i", sums, block.weights)
    totals[2] /= 3
    return totals
