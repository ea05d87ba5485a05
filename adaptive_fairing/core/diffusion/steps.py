"""Geometric diffusion of a surface mesh: the paper's algorithm (section 3.4), step by step."""

from __future__ import annotations

from collections.abc import Iterator

from numpy.typing import ArrayLike

from ..errors import SolverError
from ..fem.blocks import Block
from ..fem.differential_geometry import SurfaceMeasures, energy_ratio
from ..fem.loop_space import LoopSpace, StepSystem
from ..linalg.conjugate_gradients import SolveReport, conjugate_gradients
from ..linalg.successive_solves import SuccessiveSolves
from ..problem.caller_mesh import CallerMesh
from ..problem.deviation import limited
from ..problem.prepared_mesh import PreparedMesh
from ..problem.problem import SolverProblem
from ..problem.setting_checks import checked_settings
from ..runtime.arrays import FloatArray
from ..runtime.precision import SINGLE
from .local_density import initial_density, margin_of_run, next_density
from .result import FairingResult, FairingStep
from .settings import FairingSettings
from .smoothing_radius import tau_of_run
from .timestep_field import local_times, scheme_fields
from .volume import VolumeKeeper

# Diffusion lowers the curvature energy until a triangle, a tip or a thin part shrinks to nothing,
# where curvature has no bound: a rise by this factor over the least so far is taken as its sign.
COLLAPSE_RISE = 2.0


def fair(
    vertices: ArrayLike,
    faces: ArrayLike,
    settings: FairingSettings | None = None,
    *,
    weights: ArrayLike | None = None,
    prepared: PreparedMesh | None = None,
) -> FairingResult:
    """Run all steps of `fair_steps`; parameters and errors are described there.

    Returns
    -------
    FairingResult
        `positions` (n, 3) after the last step, and all `steps`.

    Examples
    --------
    >>> from adaptive_fairing.core import FairingSettings, fair
    >>> corners = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    >>> upper = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4)]
    >>> lower = [(b, a, 5) for a, b, _ in upper]
    >>> result = fair(corners, upper + lower, FairingSettings(steps=2))
    >>> bool(result.steps[1].volume < result.steps[0].volume)  # diffusion shrinks
    True
    """
    settings = checked_settings(settings, FairingSettings)
    steps = tuple(fair_steps(vertices, faces, settings, weights=weights, prepared=prepared))
    last = steps[-1]
    return FairingResult(steps, last.stop_reason or "steps", settings, last.initial)


def fair_steps(
    vertices: ArrayLike,
    faces: ArrayLike,
    settings: FairingSettings | None = None,
    *,
    weights: ArrayLike | None = None,
    prepared: PreparedMesh | None = None,
) -> Iterator[FairingStep]:
    """Fair a triangle mesh by diffusion; yield the surface after every step.

    The arrays are checked at the call.  All other work, including the one-time set-up, is done when
    a step is asked for.  The arguments are not changed.

    Parameters
    ----------
    vertices : (n, 3) float
        Control points of the Loop surface.  Vertices without a triangle stay where they are.
    faces : (m, 3) int
        Triangles of one or several pieces, open or closed.  Where they are not an oriented
        manifold, the solve cuts them apart and holds the vertices there, see `manifold`.
    settings : FairingSettings
    weights : (n,) float, optional
        Factor in [0, 1] of the local timestep (or diffusivity) at a vertex; a vertex of weight 0
        stays exactly where it is.
    prepared : PreparedMesh, optional
        Preparation from an earlier solve of a mesh with the same triangles.

    Yields
    ------
    FairingStep
        `positions` (n, 3) of the vertices in their order, the density that the step used, and
        measures of the surface.  The last step says why the run ended.

    Raises
    ------
    SettingsError
        The settings are of another type.
    InputError
        Arrays have the wrong shape or type, coordinates are not finite, indices or weights are out
        of range, there is no triangle, or the preparation does not fit.
    MemoryNeededError
        The solve does not fit into memory; raised by the first step.
    SolverError
        A linear system is not positive definite or not finite; raised by its step, which the
        message names.

    Source: section 3.4 of the paper.
    """
    settings = checked_settings(settings, FairingSettings)
    mesh = CallerMesh.checked(vertices, faces, weights)
    if prepared is not None:
        prepared.require(mesh.triangles, len(mesh.points), settings.quadrature_tolerance)
    return _steps(mesh, settings, prepared)


def _steps(
    mesh: CallerMesh, settings: FairingSettings, prepared: PreparedMesh | None
) -> Iterator[FairingStep]:
    normalize = settings.normalize
    prepared = prepared or PreparedMesh.of(
        mesh,
        quadrature_tolerance=settings.quadrature_tolerance,
        normalize=normalize,
    )
    problem = SolverProblem.posed(
        mesh,
        prepared,
        "fair",
        boundary=settings.boundary,
        normalize=normalize,
        margin=margin_of_run(settings),
    )
    space, frame, whole, is_held = problem.space, problem.frame, problem.whole, problem.is_held
    start = current = problem.start
    limit = settings.max_deviation
    # Sizes of residuals must depend neither on where the mesh lies nor on how it is turned.
    centre = whole.start[~whole.topology.is_loose].mean(axis=0)
    at_start = initial_density(problem, settings)
    tau = tau_of_run(whole.topology, whole.start, settings, at_start)
    times = tau * problem.weights
    keeper = None
    if settings.keep_volume:
        keeper = VolumeKeeper(space.topology, start, is_held)
    solves = SuccessiveSolves()
    density = at_start[whole.part]
    in_single = _serves_single(space, settings)
    system = _system(space, current, settings, times, density, in_single)
    initial = previous = system.measures
    least_energy = initial.curvature_energy
    for index in range(1, settings.steps + 1):
        # The surface goes on much as it went: a start from the last steps spares iterations.
        try:
            increment, solve = conjugate_gradients(
                system.matrix,
                system.load,
                solves.start(system.load),
                is_held=is_held,
                tolerance=settings.cg_tolerance,
                max_iterations=settings.cg_max_iterations,
                # M X(0), the right side of (3.3); its masses lumped are enough for a norm.
                relative_to=system.lumped_mass[:, None] * (current - centre),
            )
        except SolverError as error:
            raise SolverError(f"step {index}: {error}") from error
        solves.add(increment, system.load)
        current = current + increment
        if keeper is not None:
            current = keeper.restored(current, local_times(settings, times, density))
        within = limited(current, start, limit and limit * frame.scale)
        limit_notes = keeper.notes_on_limit(current, within) if keeper is not None else ()
        current = within
        used_density = density
        # The system of the next step measures this step's surface on the way.
        if index < settings.steps and solve.converged:
            # Where single precision did not suffice it is not tried again.
            in_single, in_double = system.matrix.is_single, system.in_double
            density = next_density(problem, current, settings, density)
            system = _system(space, current, settings, times, density, in_single, in_double)
            measures = system.measures
        else:
            measures = space.measures(current, system.matrix.is_single)
        reason = _stop_reason(index, settings, tau, solve, initial, previous, measures)
        least_energy = min(least_energy, measures.curvature_energy)
        outer = measures.scaled(1 / frame.scale)
        yield FairingStep(
            index=index,
            tau=tau,
            time=index * tau,
            positions=limited(frame.outward(current, mesh.points, is_held), mesh.points, limit),
            density=whole.to_caller(used_density, at_start),
            curvature_energy=outer.curvature_energy,
            area=outer.area,
            volume=outer.volume,
            solve=solve,
            initial=initial.scaled(1 / frame.scale),
            stop_reason=reason,
            notes=problem.notes
            + (keeper.notes if keeper is not None else ())
            + limit_notes
            + _collapse_notes(measures.curvature_energy, least_energy),
        )
        if reason is not None:
            return
        previous = measures


def _system(
    space: LoopSpace,
    current: FloatArray,
    settings: FairingSettings,
    times: FloatArray,
    density: FloatArray,
    in_single: bool,
    in_double: frozenset[Block] = frozenset(),
) -> StepSystem:
    """Linear system (3.3) of the chosen scheme; `times` (n,) are τ times the weights."""
    fields = scheme_fields(settings, local_times(settings, times, density))
    return space.step_system(current, **fields, in_single=in_single, in_double=in_double)


def _serves_single(space: LoopSpace, settings: FairingSettings) -> bool:
    """Whether single precision is enough for a mesh, if its surfaces and times allow it."""
    return SINGLE.serves_mesh(
        space.topology.n_triangles, settings.quadrature_tolerance, settings.normalize is not False
    )


def _collapse_notes(energy: float, least: float) -> tuple[str, ...]:
    if not energy > COLLAPSE_RISE * least > 0:
        return ()
    return (
        f"the curvature energy is {energy / least:.3g} times its least so far: single triangles, "
        "tips or thin parts are collapsing; a smaller radius or tau avoids that",
    )


def _stop_reason(
    index: int,
    settings: FairingSettings,
    tau: float,
    solve: SolveReport,
    initial: SurfaceMeasures,
    previous: SurfaceMeasures,
    current: SurfaceMeasures,
) -> str | None:
    if not solve.converged:
        return "not_converged"
    ratio = energy_ratio(current.curvature_energy, initial.curvature_energy)
    if settings.stop_curvature is not None and ratio <= settings.stop_curvature:
        return "curvature"
    change = ratio - energy_ratio(previous.curvature_energy, initial.curvature_energy)
    if settings.stop_rate is not None and abs(change) / tau <= settings.stop_rate:
        return "rate"
    return "steps" if index == settings.steps else None
