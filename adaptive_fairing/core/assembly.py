"""Finite elements in the Loop basis: mass and stiffness matrices, right sides, surface integrals.

Per segment of triangles (one patch class) everything is a dense product with the tables of the
class.  With K control points and q quadrature points, M and L together need one product: the
(K (K + 1) / 2, 4 q) table of products of basis functions times the (4 q, n) coefficients.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

from .class_tables import ClassTables
from .errors import InputError
from .geometry import Metric, SurfaceMeasures, mean_curvature, metric_at
from .loop_basis import basis_table
from .patches import PatchSet, Segment
from .quadrature import quadrature_choice
from .sparsity import SymmetricPattern
from .topology import TriangleTopology

FloatArray = NDArray[np.float64]

# Points handled at once: large enough to hide the cost of a numpy call, small enough for the cache.
POINTS_PER_BLOCK = 8192


class Part(NamedTuple):
    """Consecutive triangles of a segment, and their place in a block."""

    tables: ClassTables
    control_points: NDArray[np.int32]
    points: slice


class ChunkEntries(NamedTuple):
    """Where the local matrices of a chunk go.

    Attributes
    ----------
    numbers : (n_local,) int32
        Entry of the upper triangle, minus `low`, for every local matrix entry of the chunk.
    low, high : int
        Range of entries that the chunk touches.
    doubled : (k,) int
        Local off-diagonal entries whose two control points are one vertex: they count twice.
    """

    numbers: NDArray[np.int32]
    low: int
    high: int
    doubled: NDArray[np.intp]


class StepSystem(NamedTuple):
    """The linear system (3.3) of one step, and the measures of the surface it starts from."""

    matrix: sparse.csr_array
    right_side: FloatArray
    measures: SurfaceMeasures


class LoopSpace:
    """The finite element space of the Loop basis on a triangulated surface.

    Patches, tables and the sparsity pattern depend on connectivity alone: they are computed once
    and serve every surface with this topology.

    Parameters
    ----------
    topology : TriangleTopology
    quadrature_tolerance : float
        Bound for the error of matrix entries, relative to the largest; 1e-6 to 1.

    Raises
    ------
    SettingsError
        If the tolerance is out of range.
    """

    def __init__(self, topology: TriangleTopology, quadrature_tolerance: float = 1e-3) -> None:
        self.topology = topology
        choice = quadrature_choice(quadrature_tolerance)
        self._patches = PatchSet(topology)
        self._tables = [ClassTables(basis_table(c, choice)) for c in self._patches.classes]

    @cached_property
    def pattern(self) -> SymmetricPattern:
        """Sparsity pattern of every matrix in this space."""
        return SymmetricPattern(self.topology)

    def mass_matrix(
        self, positions: ArrayLike, timestep: ArrayLike | None = None
    ) -> sparse.csr_array:
        """Assemble ∫ t(x)⁻¹ φi φj over the limit surface, with t(x) = Σ t_k φ_k.

        Parameters
        ----------
        positions : (n_vertices, 3)
            Control points of the surface.
        timestep : (n_vertices,), optional
            Control values t_k > 0; without them t = 1 and this is the plain mass matrix.

        Returns
        -------
        (n_vertices, n_vertices) csr_array
            Symmetric, positive definite but for the empty rows of loose vertices; without
            `timestep` its entries add up to the area.

        Source: M of (3.4) and (3.9).
        """
        return self._assemble(positions, timestep, None, with_mass=True).matrix

    def stiffness_matrix(
        self, positions: ArrayLike, diffusivity: ArrayLike | None = None
    ) -> sparse.csr_array:
        """Assemble ∫ c(x) ∇φi · ∇φj over the limit surface, with c(x) = Σ c_k φ_k.

        Parameters
        ----------
        positions : (n_vertices, 3)
            Control points of the surface.
        diffusivity : (n_vertices,), optional
            Control values c_k ≥ 0; without them c = 1.

        Returns
        -------
        (n_vertices, n_vertices) csr_array
            Symmetric, positive semi-definite, rows add up to zero.

        Source: L of (3.4) and (3.9).
        """
        return self._assemble(positions, None, diffusivity, with_stiffness=True).matrix

    def step_system(
        self,
        positions: ArrayLike,
        *,
        timestep: ArrayLike | None = None,
        diffusivity: ArrayLike | None = None,
    ) -> StepSystem:
        """Assemble M + L and M X for one semi-implicit step, and measure the surface meanwhile.

        Source: (3.3) with (3.4) (`timestep`) or (3.9) (`diffusivity`).
        """
        return self._assemble(
            positions, timestep, diffusivity, with_mass=True, with_stiffness=True, measured=True
        )

    def measures(self, positions: ArrayLike) -> SurfaceMeasures:
        """Integrate curvature energy, area and volume of the limit surface of `positions`."""
        columns = self._columns(positions, None)
        totals = np.zeros(3)
        for chunk in self._patches.chunks:
            for parts in self._blocks(chunk):
                block = _evaluate(parts, columns, measured=True)
                totals += _integrate_measures(parts, block)
        return self._as_measures(totals)

    def _assemble(
        self,
        positions: ArrayLike,
        timestep: ArrayLike | None,
        diffusivity: ArrayLike | None,
        *,
        with_mass: bool = False,
        with_stiffness: bool = False,
        measured: bool = False,
    ) -> StepSystem:
        field = timestep if timestep is not None else diffusivity
        columns = self._columns(positions, field)
        upper = np.zeros(self.pattern.n_upper)
        right_side = np.zeros((3, self.topology.n_vertices))
        totals = np.zeros(3)
        for chunk, entries in zip(self._patches.chunks, self._entries, strict=True):
            local = np.empty(len(entries.numbers))
            loads = np.empty((3, sum(segment.control_points.size for segment in chunk)))
            n_done, n_loaded = 0, 0
            for parts in self._blocks(chunk):
                block = _evaluate(parts, columns, measured)
                if measured:
                    totals += _integrate_measures(parts, block)
                coefficients = _coefficients(
                    block,
                    inverse_mass=timestep is not None,
                    scaled_stiffness=diffusivity is not None,
                    with_mass=with_mass,
                    with_stiffness=with_stiffness,
                )
                weighted = block.values[:3] * coefficients[0] if measured else None
                for part in parts:
                    tables = part.tables
                    n = part.control_points.shape[1]
                    span = len(tables.pairs[0]) * n
                    tables.local_matrices(
                        coefficients[:, part.points].reshape(4, -1, n),
                        out=local[n_done : n_done + span].reshape(-1, n),
                    )
                    n_done += span
                    if weighted is not None:
                        span = part.control_points.size
                        np.matmul(
                            tables.weighted_values,
                            weighted[:, part.points].reshape(3, -1, n),
                            out=loads[:, n_loaded : n_loaded + span].reshape(3, -1, n),
                        )
                        n_loaded += span
            _scatter_matrix(upper, local, entries)
            if measured:
                self._scatter_loads(right_side, loads, chunk)
        return StepSystem(self.pattern.matrix(upper), right_side.T, self._as_measures(totals))

    @cached_property
    def _entries(self) -> list[ChunkEntries]:
        return [self._chunk_entries(chunk) for chunk in self._patches.chunks]

    def _chunk_entries(self, chunk: list[Segment]) -> ChunkEntries:
        numbers, doubled = [], []
        offset = 0
        for parts in self._blocks(chunk):
            for part in parts:
                a, b = part.tables.pairs
                rows, columns = part.control_points[a], part.control_points[b]
                numbers.append(self.pattern.entries(rows.reshape(-1), columns.reshape(-1)))
                merged = (rows == columns) & (a != b)[:, None]
                doubled.append(offset + np.flatnonzero(merged))
                offset += rows.size
        joined = np.concatenate(numbers)
        low, high = int(joined.min()), int(joined.max()) + 1
        joined -= np.int32(low)
        return ChunkEntries(joined, low, high, np.concatenate(doubled))

    def _blocks(self, chunk: list[Segment]) -> Iterator[list[Part]]:
        """Cut a chunk's segments into blocks of about `POINTS_PER_BLOCK` points."""
        parts: list[Part] = []
        filled = 0
        for segment in chunk:
            tables = self._tables[segment.class_index]
            first, n_triangles = 0, len(segment.triangles)
            while first < n_triangles:
                room = max((POINTS_PER_BLOCK - filled) // tables.n_points, 1)
                last = min(first + room, n_triangles)
                size = (last - first) * tables.n_points
                control = segment.control_points[:, first:last]
                parts.append(Part(tables, control, slice(filled, filled + size)))
                filled += size
                first = last
                if filled + tables.n_points > POINTS_PER_BLOCK:
                    yield parts
                    parts, filled = [], 0
        if parts:
            yield parts

    def _columns(self, positions: ArrayLike, field: ArrayLike | None) -> FloatArray:
        """Stack the coordinates and a scalar field as rows, (4, n_vertices)."""
        points = np.asarray(positions, dtype=np.float64)
        n = self.topology.n_vertices
        if points.shape != (n, 3):
            raise InputError(f"positions must have shape ({n}, 3), not {points.shape}")
        columns = np.ones((4, n))
        columns[:3] = points.T
        if field is not None:
            control = np.asarray(field, dtype=np.float64)
            if control.shape != (n,):
                raise InputError(f"control values must have shape ({n},), not {control.shape}")
            columns[3] = control
        return columns

    def _as_measures(self, totals: FloatArray) -> SurfaceMeasures:
        energy, area, volume = totals.tolist()
        return SurfaceMeasures(energy, area, volume if self.topology.is_closed else np.nan)

    def _scatter_loads(
        self, right_side: FloatArray, loads: FloatArray, chunk: list[Segment]
    ) -> None:
        vertices = np.concatenate(
            [part.control_points.reshape(-1) for parts in self._blocks(chunk) for part in parts]
        )
        low, high = int(vertices.min()), int(vertices.max()) + 1
        vertices = (vertices - low).astype(np.intp)
        for row, load in zip(right_side, loads, strict=True):
            row[low:high] += np.bincount(vertices, load, minlength=high - low)


class Block(NamedTuple):
    """Surface and field at the quadrature points of a block.

    Attributes
    ----------
    values : (4, n_points)
        Coordinates and the scalar field.
    metric : Metric
    curvature : (n_points,) or None
    """

    values: FloatArray
    metric: Metric
    curvature: FloatArray | None


def _evaluate(parts: list[Part], columns: FloatArray, measured: bool) -> Block:
    n_points = parts[-1].points.stop
    values = np.empty((4, n_points))
    tangents = np.empty((2, 3, n_points))
    seconds = np.empty((3, 3, n_points)) if measured else None
    for part in parts:
        tables, control = part.tables, part.control_points
        shape = (tables.n_points, control.shape[1])
        local = columns[:, control]
        np.matmul(tables.values, local, out=values[:, part.points].reshape(4, *shape))
        out = tangents[..., part.points].reshape(2, 3, *shape)
        np.matmul(tables.gradients, local[:3], out=out)
        if seconds is not None:
            out = seconds[..., part.points].reshape(3, 3, *shape)
            np.matmul(tables.second_derivatives, local[:3], out=out)
    metric = metric_at(tangents)
    curvature = mean_curvature(metric, seconds) if seconds is not None else None
    return Block(values, metric, curvature)


def _coefficients(
    block: Block,
    *,
    inverse_mass: bool,
    scaled_stiffness: bool,
    with_mass: bool,
    with_stiffness: bool,
) -> FloatArray:
    """Factors of the product table at each point, (4, n_points): t⁻¹ √g, then c √g g⁻¹."""
    metric, field = block.metric, block.values[3]
    coefficients = np.zeros((4, len(field)))
    if with_mass:
        np.divide(metric.area_element, field if inverse_mass else 1, out=coefficients[0])
    if with_stiffness:
        factor = (field if scaled_stiffness else 1) / metric.area_element
        np.multiply(metric.g22, factor, out=coefficients[1])
        np.multiply(metric.g12, -factor, out=coefficients[2])
        np.multiply(metric.g11, factor, out=coefficients[3])
    return coefficients


def _integrate_measures(parts: list[Part], block: Block) -> FloatArray:
    """Curvature energy, area and volume of a block, (3,)."""
    metric = block.metric
    integrands = np.empty((3, len(metric.area_element)))
    if block.curvature is not None:
        np.multiply(metric.area_element, np.square(block.curvature), out=integrands[0])
    integrands[1] = metric.area_element
    integrands[2] = np.einsum("dp,dp->p", block.values[:3], metric.normal) / 3
    totals = np.zeros(3)
    for part in parts:
        at_points = integrands[:, part.points].reshape(3, part.tables.n_points, -1)
        totals += at_points.sum(axis=2) @ part.tables.weights
    return totals


def _scatter_matrix(upper: FloatArray, local: FloatArray, entries: ChunkEntries) -> None:
    local[entries.doubled] *= 2
    size = entries.high - entries.low
    upper[entries.low : entries.high] += np.bincount(entries.numbers, local, minlength=size)
