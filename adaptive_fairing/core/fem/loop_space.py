"""Finite elements in the Loop basis: mass and stiffness matrices, right sides, surface integrals.

Everything is a dense product with the tables of a patch class.  With K control points and q
quadrature points, M and L together need one product: the (K (K + 1) / 2, 4 q) table of products of
basis functions times the (4 q, n) coefficients.  Local matrices are scattered chunk by chunk.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from ..errors import InputError
from ..linalg.symmetric_matrix import SymmetricMatrix
from ..linalg.symmetric_pattern import SymmetricPattern, scattered
from ..loop.patches import PatchSet
from ..mesh.topology import TriangleTopology, require_topology
from ..runtime.arrays import FloatArray, RealArray
from ..runtime.lazy import cached_property
from ..runtime.precision import SINGLE, Precision
from ..runtime.threads import Workspace, ordered_map
from .blocks import Block, Chunk
from .differential_geometry import SurfaceMeasures
from .forms import Form, ScalarForm, gradient_fluxes
from .patch_tables import MASS, STIFFNESS, SUM
from .scatter import ChunkEntries, entries_of_chunks
from .surface_evaluation import evaluate, integrate_measures
from .table_cache import SpaceTables

_workspace = Workspace()


class StepSystem(NamedTuple):
    """The linear system (3.3) of one step, and the measures of the surface it starts from.

    Attributes
    ----------
    matrix : SymmetricMatrix
        M + L.
    load : (n_vertices, 3)
        -L X, the right side for what a step adds to X.
    lumped_mass : (n_vertices,)
        Row sums of M.
    measures : SurfaceMeasures
    in_double : frozenset of Block
        Blocks for which single precision did not suffice.
    """

    matrix: SymmetricMatrix
    load: FloatArray
    lumped_mass: RealArray
    measures: SurfaceMeasures
    in_double: frozenset[Block]


class LoopSpace:
    """The finite element space of the Loop basis on a triangulated surface.

    Patches, tables and the sparsity pattern depend on connectivity alone: they are computed once
    and serve every surface with this topology.

    Parameters
    ----------
    topology : TriangleTopology
    quadrature_tolerance : float
        Bound for the error of matrix entries, relative to the largest; 1e-6 to 1.
    patches : PatchSet, optional
        The patches of this topology, where they are known already.

    Raises
    ------
    SettingsError
        If the tolerance is out of range.

    Examples
    --------
    >>> from adaptive_fairing.core import LoopSpace, TriangleTopology
    >>> positions = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    >>> tetrahedron = TriangleTopology([(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)], n_vertices=4)
    >>> space = LoopSpace(tetrahedron)
    >>> mass, stiffness = space.mass_matrix(positions), space.stiffness_matrix(positions)
    >>> bool(abs(stiffness @ [1, 1, 1, 1]).max() < 1e-12)  # constants do not diffuse
    True
    >>> bool(abs(mass.sum() - space.measures(positions).area) < 1e-12)
    True
    """

    def __init__(
        self,
        topology: TriangleTopology,
        quadrature_tolerance: float = 1e-3,
        patches: PatchSet | None = None,
    ) -> None:
        require_topology(topology)
        self.topology = topology
        patches = patches or PatchSet(topology)
        tables = SpaceTables(patches, patches.quadrature(quadrature_tolerance))
        self._chunks = [Chunk(segments, tables) for segments in patches.chunks]

    @cached_property
    def pattern(self) -> SymmetricPattern:
        """Sparsity pattern of every matrix in this space."""
        return SymmetricPattern(self.topology.adjacency())

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
        form = ScalarForm(inverse_mass=timestep is not None)
        return self._assemble(form, self._columns(positions, timestep), MASS).matrices[0].full()

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
        form = ScalarForm(scaled_stiffness=diffusivity is not None)
        columns = self._columns(positions, diffusivity)
        return self._assemble(form, columns, STIFFNESS).matrices[0].full()

    def step_system(
        self,
        positions: ArrayLike,
        *,
        timestep: ArrayLike | None = None,
        diffusivity: ArrayLike | None = None,
        in_single: bool = False,
        in_double: frozenset[Block] = frozenset(),
    ) -> StepSystem:
        """Assemble M + L and -L X for one semi-implicit step, and measure the surface meanwhile.

        Parameters
        ----------
        positions : (n_vertices, 3)
            Control points X of the surface.
        timestep, diffusivity : (n_vertices,), optional
            Either may vary over the surface, not both.
        in_single : bool
            Use single precision where it suffices; for positions in [-3, 3]³.
        in_double : frozenset of Block
            Blocks for which it did not suffice in the last step; it is not tried again there.

        Source: (3.3) with (3.4) (`timestep`) or (3.9) (`diffusivity`), less M X(0) on both sides.
        """
        form = self._form(timestep, diffusivity)._replace(measured=True)
        columns = self._columns(positions, timestep if diffusivity is None else diffusivity)
        if in_single and all(SINGLE.serves_times(field) for field in columns[3:]):
            system = self._step_system(form, columns, np.float32, in_double)
            used = ~self.topology.is_loose
            if SINGLE.serves_masses(system.lumped_mass[used], system.matrix.diagonal()[used]):
                return system
        return self._step_system(form, columns, np.float64)

    def flow_matrices(
        self,
        positions: ArrayLike,
        *,
        timestep: ArrayLike | None = None,
        diffusivity: ArrayLike | None = None,
    ) -> tuple[SymmetricMatrix, SymmetricMatrix]:
        """Assemble M and L of a step together, (n_vertices, n_vertices) each.

        Parameters: as in `step_system`.
        """
        form = self._form(timestep, diffusivity)
        columns = self._columns(positions, timestep if diffusivity is None else diffusivity)
        mass, stiffness = self._assemble(form, columns, MASS, STIFFNESS).matrices
        return mass, stiffness

    def measures(self, positions: ArrayLike, in_single: bool = False) -> SurfaceMeasures:
        """Integrate curvature energy, area and volume of the limit surface of `positions`.

        `in_single` as for `step_system`.
        """
        columns = self._columns(positions, None)
        precision = np.float32 if in_single else np.float64

        def of_chunk(chunk: Chunk) -> FloatArray:
            own, totals = columns[:, chunk.low : chunk.high], np.zeros(3)
            for block in chunk.blocks:
                totals += integrate_measures(block, evaluate(block, own, True, precision))
            return totals

        totals = ordered_map(of_chunk, self._chunks)
        return self._as_measures(sum(totals, np.zeros(3)))

    @staticmethod
    def _form(timestep: ArrayLike | None, diffusivity: ArrayLike | None) -> ScalarForm:
        if timestep is not None and diffusivity is not None:
            raise InputError("give either a timestep or a diffusivity, not both")
        return ScalarForm(
            inverse_mass=timestep is not None, scaled_stiffness=diffusivity is not None
        )

    def _step_system(
        self,
        form: Form,
        columns: FloatArray,
        precision: Precision,
        in_double: frozenset[Block] = frozenset(),
    ) -> StepSystem:
        (matrix,), load, measures, in_double = self._assemble(
            form, columns, SUM, precision=precision, in_double=in_double
        )
        # The rows of L add up to 0: the row sums of M + L are those of M.
        lumped_mass = matrix.product(np.ones((1, len(load))))[0]
        return StepSystem(matrix, load, lumped_mass, measures, in_double)

    def _assemble(
        self,
        form: Form,
        columns: FloatArray,
        *terms: slice,
        precision: Precision = np.float64,
        in_double: frozenset[Block] = frozenset(),
    ) -> _Assembled:
        """Assemble a matrix for each of the `terms` of a form; MASS, STIFFNESS or SUM.

        Blocks that `precision` does not resolve are integrated in double precision.
        """
        # Made here, by all threads, and not by each of them when it needs them.
        all_entries = self._entries
        uppers = [np.zeros(self.pattern.n_upper, precision) for _ in terms]
        load = np.zeros((3, self.topology.n_vertices))
        totals = np.zeros(3)

        def contribution(index: int) -> _Contribution:
            chunk, entries = self._chunks[index], all_entries[index]
            return _integrate(chunk, entries, columns, form, terms, precision, in_double)

        contributions = ordered_map(contribution, range(len(self._chunks)))
        needed_double: list[Block] = []
        for index, added in enumerate(contributions):
            chunk, entries = self._chunks[index], all_entries[index]
            for upper, own in zip(uppers, added.entries, strict=True):
                upper[entries.low : entries.high] += own
            if form.measured:
                load[:, chunk.low : chunk.high] -= added.bending
                totals += added.totals
            needed_double += added.in_double
        matrices = [SymmetricMatrix.from_upper(self.pattern, upper) for upper in uppers]
        measures = self._as_measures(totals)
        return _Assembled(matrices, load.T, measures, frozenset(needed_double))

    @cached_property
    def _entries(self) -> list[ChunkEntries]:
        return entries_of_chunks(self._chunks, self.topology.n_triangles, self.pattern)

    def _columns(self, positions: ArrayLike, field: ArrayLike | None) -> FloatArray:
        """Stack the coordinates and a scalar field, if there is one, as rows (…, n_vertices)."""
        points = np.asarray(positions, dtype=np.float64)
        n = self.topology.n_vertices
        if points.shape != (n, 3):
            raise InputError(f"positions must have shape ({n}, 3), not {points.shape}")
        if field is None:
            return np.ascontiguousarray(points.T)
        control = np.asarray(field, dtype=np.float64)
        if control.shape != (n,):
            raise InputError(f"control values must have shape ({n},), not {control.shape}")
        return np.concatenate([points.T, control[None]])

    def _as_measures(self, totals: FloatArray) -> SurfaceMeasures:
        energy, area, volume = totals.tolist()
        return SurfaceMeasures(energy, area, volume if self.topology.is_closed else np.nan)


class _Assembled(NamedTuple):
    """Matrices of several terms of a form, what was integrated meanwhile, blocks in double."""

    matrices: list[SymmetricMatrix]
    load: FloatArray
    measures: SurfaceMeasures
    in_double: frozenset[Block]


class _Contribution(NamedTuple):
    """Contribution of a chunk to entries and to rows of L X in its range, and to the measures."""

    entries: list[RealArray]
    bending: RealArray
    totals: FloatArray
    in_double: list[Block]


def _integrate(
    chunk: Chunk,
    entries: ChunkEntries,
    columns: FloatArray,
    form: Form,
    terms: tuple[slice, ...],
    precision: Precision,
    in_double: frozenset[Block],
) -> _Contribution:
    """Integrate over a chunk; store in `precision` what is summed up, whatever blocks need."""
    own_columns = columns[:, chunk.low : chunk.high]
    local = _workspace.array("local", len(terms), chunk.n_entries, dtype=precision)
    n_loads = len(chunk.control_points) if form.measured else 0
    loads = _workspace.array("loads", 3, n_loads, dtype=precision)
    totals, needed_double = np.zeros(3), []
    for block in chunk.blocks:
        first_choice = np.float64 if block in in_double else precision
        surface = evaluate(block, own_columns, form.curved, first_choice)
        if surface.precision is not precision:
            needed_double.append(block)
        flat_coefficients = form.coefficients(surface)
        coefficients = flat_coefficients.reshape(4, block.n_points, -1)
        for segment in block.segments:
            tables = segment.tables_in(surface.precision)
            for term, entries_of_term in zip(terms, local, strict=True):
                matrices = segment.of_entries(entries_of_term)
                tables.local_matrices(coefficients[..., segment.columns], term, matrices)
        if form.measured:
            totals += integrate_measures(block, surface)
            fluxes = gradient_fluxes(surface, flat_coefficients)
            by_point = fluxes.reshape(3, 2, block.n_points, -1)
            for segment in block.segments:
                own = segment.of_control(loads[:, block.control])
                tables = segment.tables_in(surface.precision)
                tables.flux_sums(by_point[..., segment.columns], out=own)
    local[:, entries.doubled] *= 2
    bending = _summed(chunk, loads) if form.measured else np.zeros((3, 0))
    size = entries.high - entries.low
    added = [scattered(entries.numbers, own, size) for own in local]
    return _Contribution(added, bending, totals, needed_double)


def _summed(chunk: Chunk, loads: RealArray) -> RealArray:
    """Add up loads of control points (3, n_control) by vertex, in the chunk's range."""
    size = chunk.high - chunk.low
    return np.stack([scattered(chunk.control_points, load, size) for load in loads])
