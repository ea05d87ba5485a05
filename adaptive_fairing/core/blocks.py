"""Blocks: the triangles that are integrated in one go, with the surface at their points.

A block is as many triangles as fill the cache with quadrature points.  It may hold parts of
several patch classes: what differs by class is a matrix product per part, everything between the
products runs over all points of the block at once.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .class_tables import ClassTables
from .geometry import Metric, mean_curvature, metric_at
from .patches import Segment

FloatArray = NDArray[np.float64]

# Large enough to hide the cost of a numpy call, small enough for the cache of one core.
POINTS_PER_BLOCK = 6144


class Part(NamedTuple):
    """Triangles of one class within a block.

    Attributes
    ----------
    tables : ClassTables
    control_points : (K, n) int32
        Vertex numbers relative to the chunk's lowest one.
    points : slice
        Place of the (q, n) quadrature points in the block.
    """

    tables: ClassTables
    control_points: NDArray[np.int32]
    points: slice

    @property
    def n_triangles(self) -> int:
        """Number of triangles."""
        return self.control_points.shape[1]

    @property
    def n_entries(self) -> int:
        """Number of local matrix entries."""
        return len(self.tables.pairs[0]) * self.n_triangles


Block = list[Part]


class Chunk:
    """Neighbouring triangles whose contributions are scattered together.

    Attributes
    ----------
    blocks : list of Block
    low, high : int
        Range of the vertices of all control points.
    control_points : (n_loads,) int32
        Those of all parts one after the other, minus `low`.
    n_entries : int
        Number of local matrix entries.
    """

    def __init__(self, segments: list[Segment], tables: list[ClassTables]) -> None:
        self.low = min(int(segment.control_points.min()) for segment in segments)
        self.high = max(int(segment.control_points.max()) for segment in segments) + 1
        n_loads = sum(segment.control_points.size for segment in segments)
        self.control_points = np.empty(n_loads, dtype=np.int32)
        self.blocks: list[Block] = [[]]
        filled = done = 0
        for class_tables, control in _pieces(segments, tables):
            size = class_tables.n_points * control.shape[1]
            if self.blocks[-1] and filled + size > POINTS_PER_BLOCK:
                self.blocks.append([])
                filled = 0
            local = self.control_points[done : done + control.size].reshape(control.shape)
            np.subtract(control, np.int32(self.low), out=local)
            self.blocks[-1].append(Part(class_tables, local, slice(filled, filled + size)))
            filled += size
            done += control.size
        self.n_entries = sum(part.n_entries for block in self.blocks for part in block)


def _pieces(
    segments: list[Segment], tables: list[ClassTables]
) -> Iterator[tuple[ClassTables, NDArray[np.int32]]]:
    """Cut segments into pieces that fit a block."""
    for segment in segments:
        class_tables = tables[segment.class_index]
        step = max(POINTS_PER_BLOCK // class_tables.n_points, 1)
        for first in range(0, len(segment.triangles), step):
            yield class_tables, segment.control_points[:, first : first + step]


class SurfaceBlock(NamedTuple):
    """Surface and field at the quadrature points of a block.

    Attributes
    ----------
    values : (4, n_points)
        Coordinates and a scalar field.
    metric : Metric
    second_derivatives : (3, 3, n_points) or None
        ∂11 x, ∂12 x, ∂22 x, if they were asked for.
    """

    values: FloatArray
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
    n_points = block[-1].points.stop
    values = np.empty((4, n_points))
    tangents = np.empty((2, 3, n_points))
    seconds = np.empty((3, 3, n_points)) if curved else None
    for part in block:
        tables, control = part.tables, part.control_points
        shape = (tables.n_points, part.n_triangles)
        local = np.empty((4, *control.shape))
        for column, row in zip(columns, local, strict=True):
            np.take(column, control, out=row, mode="clip")
        np.matmul(tables.values, local, out=values[:, part.points].reshape(4, *shape))
        out = tangents[..., part.points].reshape(2, 3, *shape)
        np.matmul(tables.gradients, local[:3], out=out)
        if seconds is not None:
            out = seconds[..., part.points].reshape(3, 3, *shape)
            np.matmul(tables.second_derivatives, local[:3], out=out)
    return SurfaceBlock(values, metric_at(tangents), seconds)


def integrate_measures(block: Block, surface: SurfaceBlock) -> FloatArray:
    """Curvature energy, area and volume of a block, (3,)."""
    metric = surface.metric
    integrands = np.empty((3, len(metric.area_element)))
    if surface.second_derivatives is not None:
        curvature = mean_curvature(metric, surface.second_derivatives)
        np.multiply(metric.area_element, np.square(curvature), out=integrands[0])
    integrands[1] = metric.area_element
    np.einsum("dp,dp->p", surface.values[:3], metric.normal, out=integrands[2])
    integrands[2] /= 3
    totals = np.zeros(3)
    for part in block:
        at_points = integrands[:, part.points].reshape(3, part.tables.n_points, -1)
        totals += at_points.sum(axis=2) @ part.tables.weights
    return totals
