"""Geometric diffusion of a surface mesh: the paper's algorithm (section 3.4), step by step."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .assembly import LoopSpace, StepSystem
from .checks import checked_vertices, checked_weights, require_surface
from .density import mesh_density
from .diagnosis import surface_notes
from .errors import SolverError
from .geometry import SurfaceMeasures
from .linear_solver import SolveReport, conjugate_gradients
from .prepared import PreparedMesh
from .settings import FairingSettings
from .topology import checked_triangles

FloatArray = NDArray[np.float64]

# Diffusion lowers the curvature energy until a triangle, a tip or a thin part shrinks to nothing,
# where curvature has no bound: a rise by this factor over the least so far is taken as its sign.
COLLAPSE_RISE = 2.0


@dataclass(frozen=True)
class FairingStep:
    """The surface after one semi-implicit step.

    Attributes
    ----------
    index : int
        1 for the first step.
    time : float
        index · τ.
    positions : (n, 3)
        In the units of the input; vertices that are held have their input coordinates bit by bit.
    density : (n,)
        d_i after smoothing, in the [-3, 3]³ frame, as this step used it; 0 at loose vertices.
    curvature_energy, area, volume : float
        Measures of the limit surface of `positions`, see `SurfaceMeasures`.
    solve : SolveReport
    initial : SurfaceMeasures
        Measures of the surface before the first step.
    stop_reason : str or None
        None while the run goes on; otherwise "steps" (all done), "curvature" (3.11), "rate"
        (3.10), or "not_converged" (the linear solve of this step missed its tolerance).
    notes : tuple of str
        What is wrong with the input and how it was made solvable, one line each; and whether
        something has begun to collapse.
    """

    index: int
    time: float
    positions: FloatArray
    density: FloatArray
    curvature_energy: float
    area: float
    volume: float
    solve: SolveReport
    initial: SurfaceMeasures
    stop_reason: str | None = None
    notes: tuple[str, ...] = ()

    @property
    def curvature_ratio(self) -> float:
        """H(t) of the paper: curvature energy relative to that of the input surface."""
        return _ratio(self.curvature_energy, self.initial.curvature_energy)


@dataclass(frozen=True)
class FairingResult:
    """A finished run.

    Attributes
    ----------
    steps : tuple of FairingStep
    stop_reason : str
        As in the last step.
    settings : FairingSettings
    initial : SurfaceMeasures
        Measures of the input surface.
    """

    steps: tuple[FairingStep, ...]
    stop_reason: str
    settings: FairingSettings
    initial: SurfaceMeasures

    @property
    def positions(self) -> FloatArray:
        """Final positions, (n, 3)."""
        return self.steps[-1].positions

    @property
    def notes(self) -> tuple[str, ...]:
        """What is wrong with the input and how it was made solvable, one line each."""
        return self.steps[-1].notes


def fair(
    vertices: ArrayLike,
    faces: ArrayLike,
    settings: FairingSettings | None = None,
    *,
    weights: ArrayLike | None = None,
    prepared: PreparedMesh | None = None,
) -> FairingResult:
    """Run all steps of `fair_steps`, which has the parameters and errors."""
    settings = settings or FairingSettings()
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
    """Fair a triangle mesh; yield the surface after every step.

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
        Share of the local timestep (or diffusivity) that a vertex gets, in [0, 1]; a vertex of
        weight 0 stays exactly where it is.
    prepared : PreparedMesh, optional
        What an earlier solve of a mesh with the same triangles can hand on.

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
    return _run(points, triangles, settings, shares, prepared)


def _run(
    points: FloatArray,
    triangles: NDArray[np.int32],
    settings: FairingSettings,
    weights: FloatArray,
    prepared: PreparedMesh | None,
) -> Iterator[FairingStep]:
    prepared = prepared or PreparedMesh(points, triangles, settings)
    surface, space = prepared.surface, prepared.space
    topology = surface.topology
    frame = prepared.frame(points, settings.normalize)
    weights = weights[surface.vertex_of]
    is_held = (weights == 0) | topology.is_loose | surface.is_cut
    if settings.boundary == "fixed":
        is_held |= topology.on_boundary

    current = frame.inward(points)
    notes = surface_notes(current, surface)
    density, system = _system(space, current, settings, weights)
    initial = previous = system.measures
    least_energy = initial.curvature_energy
    for index in range(1, settings.steps + 1):
        try:
            current, solve = conjugate_gradients(
                system.matrix,
                system.right_side,
                current,
                is_held=is_held,
                tolerance=settings.cg_tolerance,
                max_iterations=settings.cg_max_iterations,
            )
        except SolverError as error:
            raise SolverError(f"step {index}: {error}") from error
        used_density = density
        # The system of the next step measures this step's surface on the way.
        if index < settings.steps and solve.converged:
            density, system = _system(space, current, settings, weights)
            measures = system.measures
        else:
            measures = space.measures(current)
        reason = _stop_reason(index, settings, solve, initial, previous, measures)
        least_energy = min(least_energy, measures.curvature_energy)
        outer = measures.scaled(1 / frame.scale)
        yield FairingStep(
            index=index,
            time=index * settings.tau,
            positions=frame.outward(current, points, is_held),
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


def _system(
    space: LoopSpace, current: FloatArray, settings: FairingSettings, weights: FloatArray
) -> tuple[FloatArray, StepSystem]:
    """Density of the current surface, and the linear system (3.3) of the chosen scheme."""
    density = mesh_density(space.topology, current, settings.density, settings.density_passes)
    if settings.method == "uniform":
        return density, space.step_system(current, timestep=_positive(settings.tau * weights))
    field = settings.tau * density * weights
    if settings.method == "adaptive_tensor":
        return density, space.step_system(current, diffusivity=field)
    return density, space.step_system(current, timestep=_positive(field))


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
    ratio = _ratio(current.curvature_energy, initial.curvature_energy)
    if settings.stop_curvature is not None and ratio <= settings.stop_curvature:
        return "curvature"
    change = ratio - _ratio(previous.curvature_energy, initial.curvature_energy)
    if settings.stop_rate is not None and abs(change) / settings.tau <= settings.stop_rate:
        return "rate"
    return "steps" if index == settings.steps else None


def _ratio(energy: float, initial: float) -> float:
    """H(t)/H(0); a surface that was flat from the start has nothing left to lose."""
    return energy / initial if initial > 0 else 0.0
