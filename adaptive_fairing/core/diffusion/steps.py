"""Geometric diffusion of a surface mesh: the paper's algorithm (section 3.4), step by step."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..denoise.denoise import auto_surfaces
from ..denoise.plan import AutoPlan
from ..errors import SolverError
from ..fem.differential_geometry import SurfaceMeasures
from ..fem.loop_space import LoopSpace, StepSystem
from ..linalg.conjugate_gradients import SolveReport, conjugate_gradients
from ..mesh.density import mesh_density
from ..mesh.input_checks import checked_vertices, checked_weights, require_surface
from ..mesh.solver_mesh import SolverFrame, SolverSurface
from ..mesh.topology import checked_triangles
from ..problem.diagnosis import surface_notes
from ..problem.prepared_mesh import PreparedMesh
from ..results import FairingResult, FairingStep, energy_ratio
from ..runtime.precision import SINGLE
from ..settings import FairingSettings

FloatArray = NDArray[np.float64]

# Diffusion lowers the curvature energy until a triangle, a tip or a thin part shrinks to nothing,
# where curvature has no bound: a rise by this factor over the least so far is taken as its sign.
COLLAPSE_RISE = 2.0

# Share of the last step's displacement that is added to the start of the next solve.
EXTRAPOLATED_SHARE = 0.25


def fair(
    vertices: ArrayLike,
    faces: ArrayLike,
    settings: FairingSettings | None = None,
    *,
    weights: ArrayLike | None = None,
    prepared: PreparedMesh | None = None,
    plan: AutoPlan | None = None,
    progress: Callable[[float], None] | None = None,
) -> FairingResult:
    """Run all steps of `fair_steps`, which has the parameters and errors."""
    settings = settings or FairingSettings()
    run = fair_steps(
        vertices,
        faces,
        settings,
        weights=weights,
        prepared=prepared,
        plan=plan,
        progress=progress,
    )
    steps = tuple(run)
    last = steps[-1]
    return FairingResult(steps, last.stop_reason or "steps", settings, last.initial)


def fair_steps(
    vertices: ArrayLike,
    faces: ArrayLike,
    settings: FairingSettings | None = None,
    *,
    weights: ArrayLike | None = None,
    prepared: PreparedMesh | None = None,
    plan: AutoPlan | None = None,
    progress: Callable[[float], None] | None = None,
) -> Iterator[FairingStep]:
    """Fair a triangle mesh; yield the surface after every step, or for every strength of "auto".

    The arrays are checked at the call; the work, including the one-time set-up, is done as the
    steps are asked for.  Nothing handed over is changed.

    Parameters
    ----------
    vertices : (n, 3) float
        Control points of the Loop surface.  Vertices without a triangle stay where they are.
    faces : (m, 3) int
        Triangles of one or several pieces, open or closed.  Where they are not an oriented
        manifold, the solve cuts them apart and holds the vertices there, see `manifold`.
    settings : FairingSettings
    weights : (n,) float, optional
        Share of the local timestep (or diffusivity, or with "auto" the displacement) that a vertex
        gets, in [0, 1]; a vertex of weight 0 stays exactly where it is.
    prepared : PreparedMesh, optional
        What an earlier solve of a mesh with the same triangles can hand on.
    plan : AutoPlan, optional
        How "auto" mixed its filters on another frame of this surface (`FairingStep.auto.plan`),
        to mix them alike on this one; needs the same `prepared`.
    progress : callable, optional
        Called with the share of the run that is done, in (0, 1]; may raise to end the run.

    Raises
    ------
    InputError
        Arrays of the wrong shape or type, coordinates that are not finite, indices or weights out
        of range, no triangle at all; a preparation for something else.
    MemoryNeededError
        The mesh cannot fit into memory; raised by the first step.
    SolverError
        A linear system that is not positive definite or not finite; raised by its step, which the
        message names.

    Source: section 3.4 of the paper.
    """
    settings = settings or FairingSettings()
    points = checked_vertices(vertices)
    shares = checked_weights(weights, len(points))
    # Copies: the caller may change the arrays between two steps.
    triangles = checked_triangles(np.array(faces), len(points))
    require_surface(points, triangles)
    if prepared is not None:
        prepared.require(triangles, len(points), settings.quadrature_tolerance)
    problem = _Problem(points, triangles, settings, shares, prepared)
    if settings.method == "auto":
        return _auto_steps(problem, plan, progress)
    return _diffusion_steps(problem, progress)


@dataclass(frozen=True)
class _Problem:
    """Arguments of `fair_steps`, checked, and what both kinds of runs make of them first."""

    points: FloatArray
    triangles: NDArray[np.int32]
    settings: FairingSettings
    shares: FloatArray
    prepared: PreparedMesh | None

    def posed(self) -> _Posed:
        """Go over to the solver's mesh."""
        settings = self.settings
        prepared = self.prepared or PreparedMesh(self.points, self.triangles, settings)
        surface, topology = prepared.surface, prepared.surface.topology
        frame = prepared.frame(self.points, settings.normalize)
        weights = self.shares[surface.vertex_of]
        is_held = (weights == 0) | topology.is_loose | surface.is_cut
        if settings.boundary == "fixed":
            is_held |= topology.on_boundary
        start = frame.inward(self.points)
        return _Posed(
            prepared.space, surface, frame, start, weights, is_held, surface_notes(start, surface)
        )


class _Posed(NamedTuple):
    """The problem on the solver's mesh; arrays (n, ...) in the order of its vertices."""

    space: LoopSpace
    surface: SolverSurface
    frame: SolverFrame
    start: FloatArray
    weights: FloatArray
    is_held: NDArray[np.bool_]
    notes: tuple[str, ...]


def _diffusion_steps(
    problem: _Problem, progress: Callable[[float], None] | None
) -> Iterator[FairingStep]:
    settings = problem.settings
    space, _, frame, current, weights, is_held, notes = problem.posed()
    increment = np.zeros_like(current)
    density, system = _system(space, current, settings, weights, _serves_single(space, settings))
    initial = previous = system.measures
    least_energy = initial.curvature_energy
    for index in range(1, settings.steps + 1):
        # The surface goes on as it went: this much of the last step spares an iteration or two.
        try:
            increment, solve = conjugate_gradients(
                system.matrix,
                system.load,
                EXTRAPOLATED_SHARE * increment,
                is_held=is_held,
                tolerance=settings.cg_tolerance,
                max_iterations=settings.cg_max_iterations,
                # M X(0), the right side of (3.3); its masses lumped are enough for a norm.
                relative_to=system.lumped_mass[:, None] * current,
            )
        except SolverError as error:
            raise SolverError(f"step {index}: {error}") from error
        current = current + increment
        used_density = density
        # The system of the next step measures this step's surface on the way.
        if index < settings.steps and solve.converged:
            # Where single precision did not serve it is not tried again.
            in_single = system.matrix.is_single
            density, system = _system(space, current, settings, weights, in_single)
            measures = system.measures
        else:
            measures = space.measures(current, system.matrix.is_single)
        reason = _stop_reason(index, settings, solve, initial, previous, measures)
        least_energy = min(least_energy, measures.curvature_energy)
        outer = measures.scaled(1 / frame.scale)
        if progress is not None:
            progress(1.0 if reason else index / settings.steps)
        yield FairingStep(
            index=index,
            time=index * settings.tau,
            positions=frame.outward(current, problem.points, is_held),
            density=frame.to_caller(used_density),
            curvature_energy=outer.curvature_energy,
            area=outer.area,
            volume=outer.volume,
            solve=solve,
            initial=initial.scaled(1 / frame.scale),
            stop_reason=reason,
            notes=notes + _collapse_notes(measures.curvature_energy, least_energy),
        )
        if reason is not None:
            return
        previous = measures


def _auto_steps(
    problem: _Problem, plan: AutoPlan | None, progress: Callable[[float], None] | None
) -> Iterator[FairingStep]:
    settings = problem.settings
    space, surface, frame, start, weights, is_held, notes = problem.posed()
    outcome = auto_surfaces(
        space,
        start,
        surface.is_cut,
        strength=settings.strength,
        features=settings.features,
        plan=plan,
        progress=progress,
    )
    density = mesh_density(space.topology, start, settings.density, settings.density_passes)
    in_single = _serves_single(space, settings)
    initial = space.measures(start, in_single).scaled(1 / frame.scale)
    n_strengths = len(outcome.positions)
    for index, (faired, estimate) in enumerate(
        zip(outcome.positions, outcome.estimates, strict=True), start=1
    ):
        displacement = weights[:, None] * (faired - start)
        displacement[is_held] = 0
        measures = space.measures(start + displacement, in_single).scaled(1 / frame.scale)
        reason = None if outcome.solve.converged else "not_converged"
        yield FairingStep(
            index=index,
            time=float("nan"),
            positions=frame.displaced(problem.points, displacement),
            density=frame.to_caller(density),
            curvature_energy=measures.curvature_energy,
            area=measures.area,
            volume=measures.volume,
            solve=outcome.solve,
            initial=initial,
            stop_reason=reason or ("steps" if index == n_strengths else None),
            auto=replace(estimate, noise_length=estimate.noise_length / frame.scale),
            notes=notes + outcome.notes,
        )


def _system(
    space: LoopSpace,
    current: FloatArray,
    settings: FairingSettings,
    weights: FloatArray,
    in_single: bool,
) -> tuple[FloatArray, StepSystem]:
    """Density of the current surface, and the linear system (3.3) of the chosen scheme."""
    density = mesh_density(space.topology, current, settings.density, settings.density_passes)
    field = settings.tau * weights
    if settings.method != "uniform":
        field *= density
    if settings.method == "adaptive_tensor":
        return density, space.step_system(current, diffusivity=field, in_single=in_single)
    return density, space.step_system(current, timestep=_positive(field), in_single=in_single)


def _serves_single(space: LoopSpace, settings: FairingSettings) -> bool:
    """Whether single precision is enough for a mesh, if its surfaces and times allow it."""
    return SINGLE.serves_mesh(
        space.topology.n_triangles, settings.quadrature_tolerance, settings.normalize
    )


def _collapse_notes(energy: float, least: float) -> tuple[str, ...]:
    if not energy > COLLAPSE_RISE * least > 0:
        return ()
    return (
        f"the curvature energy is {energy / least:.3g} times its least so far: single triangles, "
        "tips or thin parts are collapsing; a smaller tau or fewer steps avoid that",
    )


def _positive(timestep: FloatArray) -> FloatArray:
    """Keep the timestep positive where it is 0: only in the equations of held vertices."""
    return np.maximum(timestep, 1e-12 * timestep.max(initial=0) or 1.0)


def _stop_reason(
    index: int,
    settings: FairingSettings,
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
    if settings.stop_rate is not None and abs(change) / settings.tau <= settings.stop_rate:
        return "rate"
    return "steps" if index == settings.steps else None
