"""Evaluation of the surface at the quadrature points of a block, and integrals over it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..runtime.arrays import FloatArray, RealArray
from ..runtime.precision import SINGLE, Precision
from ..runtime.threads import Workspace
from .blocks import Block
from .differential_geometry import Metric, mean_curvature, metric_at

_workspace = Workspace()


class SurfaceBlock(NamedTuple):
    """Surface and field at the quadrature points of a block, until the thread's next block.

    Points run over the quadrature points first, then over the triangles: arrays (…, n_points) can
    be seen as (…, q, n_triangles).

    Attributes
    ----------
    field : (n_points,) or None
        A scalar field, if there is one.
    positions : (3, n_points)
    tangents : (2, 3, n_points)
        ∂1 x, ∂2 x.
    metric : Metric
    second_derivatives : (3, 3, n_points) or None
        ∂11 x, ∂12 x, ∂22 x, if they were asked for.
    """

    field: RealArray | None
    positions: RealArray
    tangents: RealArray
    metric: Metric
    second_derivatives: RealArray | None

    @property
    def precision(self) -> Precision:
        """In which all was computed."""
        return self.positions.dtype.type


def evaluate(
    block: Block, columns: FloatArray, curved: bool, precision: Precision = np.float64
) -> SurfaceBlock:
    """Evaluate the surface at the quadrature points of a block.

    Parameters
    ----------
    block : Block
    columns : (3, n_vertices) or (4, n_vertices)
        Coordinates, and the control values of a scalar field if there is one, from the chunk's
        lowest vertex on.
    curved : bool
        Whether second derivatives are wanted.
    precision : float32 or float64
        Single precision is tried, and left where it does not resolve the metric.
    """
    control = _workspace.array("control", len(columns), len(block.control_points))
    indices = block.control_points.astype(np.intp)  # once, not for every column
    for column, row in zip(columns, control, strict=True):
        # All indices are in range, and mode "wrap" saves the time of checking them.
        np.take(column, indices, out=row, mode="wrap")
    if precision is np.float32:
        surface = _evaluated(block, *_seen_from_corners(block, control), curved)
        metric = surface.metric
        if SINGLE.serves_metric(metric.g11, metric.g22, metric.area_element):
            return surface
    return _evaluated(block, control, np.zeros((3, block.n_triangles)), curved)


def _seen_from_corners(block: Block, control: FloatArray) -> tuple[RealArray, RealArray]:
    """Round control values (3 or 4, n) to single precision as seen from a corner of each triangle.

    Differences in double precision keep all digits of small triangles.  And rounded basis functions
    do not add up to 1, nor their derivatives to 0: an error that grows with the distance from the
    origin.  Also returns the corners, (3, n_triangles).
    """
    seen = _workspace.array("seen", *control.shape, dtype=np.float32)
    seen[3:] = control[3:]
    origins = np.empty((3, block.n_triangles))
    for group in block.groups:
        own = group.of_control(control[:3])
        origins[:, group.columns] = own[:, 0]
        np.subtract(own, own[:, :1], out=group.of_control(seen[:3]), casting="same_kind")
    return seen, origins.astype(np.float32)


def _evaluated(block: Block, control: RealArray, origins: RealArray, curved: bool) -> SurfaceBlock:
    precision = control.dtype.type
    n_derivatives = 6 if curved else 3
    shape = block.n_points, block.n_triangles
    fields = _workspace.array("fields", len(control) - 3, *shape, dtype=precision)
    jets = _workspace.array("jets", 3, n_derivatives, *shape, dtype=precision)
    rows = jets.reshape(3, -1, block.n_triangles)
    for segment in block.segments:
        own, tables = segment.of_control(control), segment.tables_in(precision)
        tables.evaluate(own[:3], n_derivatives, out=rows[..., segment.columns])
        if len(fields):
            tables.evaluate(own[3:], 1, out=fields[..., segment.columns])
    positions = _workspace.array("positions", 3, *shape, dtype=precision)
    np.add(jets[:, 0], origins[:, None], out=positions)
    by_derivative = jets.reshape(3, n_derivatives, -1).swapaxes(0, 1)
    tangents, second_derivatives = by_derivative[1:3], by_derivative[3:] if curved else None
    metric = metric_at(tangents)
    field = fields[0].reshape(-1) if len(fields) else None
    return SurfaceBlock(field, positions.reshape(3, -1), tangents, metric, second_derivatives)


def integrate_measures(block: Block, surface: SurfaceBlock) -> FloatArray:
    """Curvature energy, area and volume of a block, (3,)."""
    metric = surface.metric
    precision = metric.area_element.dtype.type
    integrands = _workspace.array("integrands", 3, len(metric.area_element), dtype=precision)
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
