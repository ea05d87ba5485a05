"""The surface at the quadrature points of a block, and what is integrated over it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..runtime.arrays import FloatArray, RealArray
from ..runtime.precision import SINGLE, Precision
from ..runtime.threads import Workspace
from .blocks import Block, Chunk
from .differential_geometry import Metric, mean_curvature, metric_at

_workspace = Workspace()


class ControlValues(NamedTuple):
    """Coordinates and a scalar field of a chunk's vertices.

    Attributes
    ----------
    columns : (4, n)
        From the chunk's lowest vertex on: coordinates minus the origin, and the field.
    origin : (3,)
    extent : float
        Largest side of the box around the vertices.
    """

    columns: RealArray
    origin: RealArray
    extent: float = 0.0

    @classmethod
    def of_chunk(cls, chunk: Chunk, columns: FloatArray, precision: Precision) -> ControlValues:
        """Take a chunk's part of the columns (4, n_vertices) of all vertices."""
        own = columns[:, chunk.low : chunk.high]
        if precision is np.float64:
            return cls(own, np.zeros(3))
        # Subtracting the middle of the chunk before rounding leaves more digits for the shape.
        low, high = own[:3].min(axis=1), own[:3].max(axis=1)
        middle = (low + high) / 2
        shifted = own.astype(precision)
        np.subtract(own[:3], middle[:, None], out=shifted[:3], casting="same_kind")
        return cls(shifted, middle.astype(precision), float((high - low).max()))

    def resolves(self, metric: Metric) -> bool:
        """Whether the precision is enough for a surface with this metric."""
        if self.columns.dtype == np.float64:
            return True
        return SINGLE.serves_metric(metric.g11, metric.g22, metric.area_element, self.extent)


class SurfaceBlock(NamedTuple):
    """Surface and field at the quadrature points of a block, until the thread's next block.

    Points run over the quadrature points first, then over the triangles: arrays (…, n_points) can
    be seen as (…, q, n_triangles).

    Attributes
    ----------
    field : (n_points,)
        A scalar field.
    positions : (3, n_points)
    tangents : (2, 3, n_points)
        ∂1 x, ∂2 x.
    metric : Metric
    second_derivatives : (3, 3, n_points) or None
        ∂11 x, ∂12 x, ∂22 x, if they were asked for.
    """

    field: RealArray
    positions: RealArray
    tangents: RealArray
    metric: Metric
    second_derivatives: RealArray | None


def evaluate(block: Block, values: ControlValues, curved: bool) -> SurfaceBlock:
    """Evaluate the surface at the quadrature points of a block.

    Parameters
    ----------
    block : Block
    values : ControlValues
        Of the block's chunk.
    curved : bool
        Whether second derivatives are wanted.
    """
    columns, origin, _ = values
    precision = columns.dtype.type
    control = _workspace.array("control", 4, len(block.control_points), precision=precision)
    indices = block.control_points.astype(np.intp)  # once, not for every column
    for column, row in zip(columns, control, strict=True):
        # All indices are in range, and mode "wrap" saves the time of checking them.
        np.take(column, indices, out=row, mode="wrap")
    n_derivatives = 6 if curved else 3
    shape = block.n_points, block.n_triangles
    field = _workspace.array("field", 1, *shape, precision=precision)
    jets = _workspace.array("jets", 3, n_derivatives, *shape, precision=precision)
    rows = jets.reshape(3, -1, block.n_triangles)
    origins = np.tile(origin[:, None], block.n_triangles)
    for segment in block.segments:
        own, tables = segment.of_control(control), segment.tables_in(precision)
        if precision is np.float32:
            _see_from_corners(own[:3], origins[:, segment.columns])
        tables.evaluate(own[:3], n_derivatives, out=rows[..., segment.columns])
        tables.evaluate(own[3:], 1, out=field[..., segment.columns])
    positions = _workspace.array("positions", 3, *shape, precision=precision)
    np.add(jets[:, 0], origins[:, None], out=positions)
    by_derivative = jets.reshape(3, n_derivatives, -1).swapaxes(0, 1)
    tangents, second_derivatives = by_derivative[1:3], by_derivative[3:] if curved else None
    metric = metric_at(tangents)
    return SurfaceBlock(
        field.reshape(-1), positions.reshape(3, -1), tangents, metric, second_derivatives
    )


def _see_from_corners(control: RealArray, origins: RealArray) -> None:
    """Subtract from control points (3, K, n) the first one of each triangle; add it to (3, n).

    Rounded basis functions do not add up to 1, nor their derivatives to 0: an error that grows with
    the distance from the origin.
    """
    corners = control[:, 0].copy()
    control -= corners[:, None]
    origins += corners


def integrate_measures(block: Block, surface: SurfaceBlock) -> FloatArray:
    """Curvature energy, area and volume of a block, (3,)."""
    metric = surface.metric
    precision = metric.area_element.dtype.type
    integrands = _workspace.array("integrands", 3, len(metric.area_element), precision=precision)
    if surface.second_derivatives is not None:
        np.square(mean_curvature(metric, surface.second_derivatives), out=integrands[0])
        integrands[0] *= metric.area_element
    else:
        integrands[0] = 0
    integrands[1] = metric.area_element
    np.einsum("dp,dp->p", surface.positions, metric.normal, out=integrands[2])
    by_point = integrands.reshape(3, block.n_points, block.n_triangles)
    sums = np.add.reduceat(by_point, block.weight_starts, axis=2, dtype=np.float64)
    totals: FloatArray = np.einsum("iqk,qk->i", sums, block.weights)
    totals[2] /= 3
    return totals
