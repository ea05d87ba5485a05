"""Functions on a surface, faired by the matrices that fair the surface itself.

A colour, a weight or a measured field has a value at every vertex and is the function
v(x) = Σ v_i φ_i(x) on the limit surface.  It diffuses as the paper's coordinates do, (M + L) v(T)
= M v(0), while the surface stays: the matrices are assembled once for all steps.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csgraph

from ..errors import InputError, SolverError, listed
from ..linalg.conjugate_gradients import conjugate_gradients
from ..linalg.successive_solves import SuccessiveSolves
from ..mesh.input_checks import plain_array
from ..mesh.topology import TriangleTopology
from ..problem.caller_mesh import CallerMesh
from ..problem.prepared_mesh import PreparedMesh
from ..problem.problem import SolverProblem
from ..problem.setting_checks import checked_settings
from ..runtime.arrays import BoolArray, FloatArray, IntArray
from .local_density import initial_density, margin_of_run
from .settings import FairingSettings
from .smoothing_radius import tau_of_run
from .timestep_field import local_times, scheme_fields


def fair_values(
    vertices: ArrayLike,
    faces: ArrayLike,
    values: ArrayLike,
    settings: FairingSettings | None = None,
    *,
    weights: ArrayLike | None = None,
) -> FloatArray:
    """Fair functions on the surface of a triangle mesh, whose vertices stay where they are.

    A constant does not change.  On a closed surface without held vertices the mean of a function
    does not change either: ∫ v with "uniform" and "adaptive_tensor", and ∫ v / T, T = τ D, with
    "adaptive_timestep", which is slower where the mesh is dense.  Finite elements have no maximum
    principle: values next to a sharp step may overshoot it by a few percent of its height.

    Parameters
    ----------
    vertices : (n, 3) float
    faces : (m, 3) int
        As in `fair_steps`.
    values : (n, k) float
        k functions, one in each column; they do not influence one another.
    settings : FairingSettings
        Method, time, density, steps, boundary ("fixed" holds the values of boundary vertices) and
        accuracy count.  Settings about positions do not: `keep_volume`, `max_deviation` and the
        stopping rules.
    weights : (n,) float, optional
        Factor in [0, 1] of the local time; a vertex of weight 0 keeps its values exactly.

    Returns
    -------
    (steps, n, k)
        Values after every step.  Loose vertices keep their values.

    Raises
    ------
    InputError
        Arrays of the wrong shape or type, numbers that are not finite or out of range, no
        triangle at all.
    MemoryNeededError
        The solve does not fit into memory.
    SolverError
        A step did not converge; the message names it.

    Examples
    --------
    >>> from adaptive_fairing.core import fair_values
    >>> corners = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    >>> upper = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4)]
    >>> lower = [(b, a, 5) for a, b, _ in upper]
    >>> height = [[z] for _, _, z in corners]
    >>> faired = fair_values(corners, upper + lower, height)
    >>> faired.shape
    (4, 6, 1)
    >>> bool(0 < faired[3, 4, 0] < faired[0, 4, 0] < 1)  # the top comes down, step by step
    True

    Source: section 3.4 of the paper, with functions instead of coordinates.
    """
    settings = checked_settings(settings, FairingSettings)
    mesh = CallerMesh.checked(vertices, faces, weights)
    given = _checked_values(values, len(mesh.points))
    prepared = PreparedMesh.of(
        mesh,
        quadrature_tolerance=settings.quadrature_tolerance,
        normalize=settings.normalize,
    )
    problem = SolverProblem.posed(
        mesh,
        prepared,
        "fair",
        boundary=settings.boundary,
        normalize=settings.normalize,
        margin=margin_of_run(settings),
    )
    # Every function in [-1, 1], so that all count alike in the residual; a constant becomes 0.
    low, high = given.min(axis=0), given.max(axis=0)
    centre, spread = low / 2 + high / 2, high / 2 - low / 2
    spread[spread == 0] = 1.0
    vertex_of = problem.frame.surface.vertex_of
    inner = (given[vertex_of] - centre) / spread
    moves = ~problem.is_held
    results = np.repeat(given[None], settings.steps, axis=0)
    for result, values_now in zip(results, _evolution(problem, inner, settings), strict=True):
        result[vertex_of[moves]] = centre + spread * values_now[moves]
    return results


def _checked_values(values: ArrayLike, n_vertices: int) -> FloatArray:
    checked = plain_array(values, "values").astype(np.float64)
    if checked.ndim != 2 or len(checked) != n_vertices:
        raise InputError(f"values must have shape ({n_vertices}, k), not {checked.shape}")
    bad = np.flatnonzero(~np.isfinite(checked).all(axis=1))
    if len(bad):
        raise InputError(
            f"{len(bad)} vertices have values that are not finite numbers: {listed(bad)}; "
            "replace them first"
        )
    return checked


def _evolution(
    problem: SolverProblem, start: FloatArray, settings: FairingSettings
) -> list[FloatArray]:
    """Values (n, k) of the solver's vertices after every step."""
    space, topology, points = problem.space, problem.space.topology, problem.start
    whole = problem.whole
    at_start = initial_density(problem, settings)
    times = tau_of_run(whole.topology, whole.start, settings, at_start) * problem.weights
    density = at_start[whole.part]
    fields = scheme_fields(settings, local_times(settings, times, density))
    mass, stiffness = space.flow_matrices(points, **fields)
    matrix = mass.plus(1.0, stiffness)
    lumped_mass = mass.product(np.ones((1, topology.n_vertices)))[0]
    part = _free_parts(topology, problem.is_held)
    solves, current, evolution = SuccessiveSolves(), start, []
    for index in range(1, settings.steps + 1):
        load = -stiffness.product(current.T).T
        try:
            increment, solve = conjugate_gradients(
                matrix,
                load,
                solves.start(load),
                is_held=problem.is_held,
                tolerance=settings.cg_tolerance,
                max_iterations=settings.cg_max_iterations,
                relative_to=lumped_mass[:, None] * current,
            )
        except SolverError as error:
            raise SolverError(f"step {index}: {error}") from error
        if not solve.converged:
            raise SolverError(
                f"step {index} did not converge: residual {solve.residual:.3g} after "
                f"{solve.iterations} iterations; choose a smaller radius or tau"
            )
        increment -= _drift(increment, lumped_mass, part)
        solves.add(increment, load)
        current = current + increment
        evolution.append(current)
    return evolution


def _free_parts(topology: TriangleTopology, is_held: BoolArray) -> IntArray:
    """Assign numbers to the connected parts without a held vertex, (n,); -1 elsewhere."""
    n_parts, part = csgraph.connected_components(topology.adjacency(), directed=False)
    has_held = np.bincount(part[is_held], minlength=n_parts) > 0
    numbered: IntArray = np.where(has_held[part], -1, part)
    return numbered


def _drift(increment: FloatArray, lumped_mass: FloatArray, part: IntArray) -> FloatArray:
    """Mean of what a step adds in every free part, which is 0 up to the solver's tolerance."""
    n_parts = part.max(initial=-1) + 1
    inside = part >= 0
    mass = np.bincount(part[inside], lumped_mass[inside], n_parts)
    drift = np.zeros_like(increment)
    for column, own in zip(increment.T, drift.T, strict=True):
        added = np.bincount(part[inside], (lumped_mass * column)[inside], n_parts)
        mean = np.divide(added, mass, out=np.zeros(n_parts), where=mass > 0)
        own[inside] = mean[part[inside]]
    return drift
