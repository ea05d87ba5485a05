"""Entry point of the automatic method: denoising without a parameter."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError, SolverError
from ..linalg.conjugate_gradients import SolveReport
from ..problem.caller_mesh import CallerMesh
from ..problem.deviation import limited
from ..problem.prepared_mesh import PreparedMesh
from ..problem.problem import SolverProblem
from ..runtime.arrays import BoolArray, FloatArray
from ..runtime.precision import SINGLE
from .filter_family import KEEPS
from .parameters import parameters
from .plan import STRENGTHS, DenoisePlan
from .progress import DenoiseProgress, ProgressReport
from .region import filtered, not_judged
from .result import DenoiseResult
from .settings import DenoiseSettings
from .triangle_surface import TriangleSurface
from .wide_noise import denoised_surfaces


def denoise(
    vertices: ArrayLike,
    faces: ArrayLike,
    settings: DenoiseSettings | None = None,
    *,
    weights: ArrayLike | None = None,
    prepared: PreparedMesh | None = None,
    plan: DenoisePlan | None = None,
    progress: Callable[[DenoiseProgress], None] | None = None,
) -> DenoiseResult:
    """Remove noise from a triangle mesh, after estimating from the mesh how much there is.

    The arguments are not changed.

    Parameters
    ----------
    vertices : (n, 3) float
        Positions. Vertices without a triangle stay where they are.
    faces : (m, 3) int
        Triangles of one or several pieces, open or closed. Where they are not an oriented
        manifold, the solve cuts them apart and holds the vertices there, see `manifold`.
    settings : DenoiseSettings, optional
    weights : (n,) float, optional
        Factor in [0, 1] of the displacement of a vertex. A vertex of weight 0 stays exactly where
        it is, and noise is not judged from it. If most weights are 0, the filters cover only some
        rings around the other vertices.
    prepared : PreparedMesh, optional
        Preparation from an earlier run on a mesh with the same triangles.
    plan : DenoisePlan, optional
        Plan of another frame of this whole surface (`DenoiseResult.plan`), made with the same
        `prepared`. Then nothing is estimated, and the filters are mixed as in that frame.
    progress : callable, optional
        Called with `DenoiseProgress` now and then, from any thread, but by one at a time. It may
        raise an exception to end the run.

    Returns
    -------
    DenoiseResult
        `positions` (n, 3) of the vertices in their order, at the chosen strength; the shapes at
        other strengths; the estimated noise; notes.

    Raises
    ------
    InputError
        Arrays have the wrong shape or type, coordinates are not finite, indices or weights are out
        of range, there is no triangle, or the preparation or the plan does not fit.
    MemoryNeededError
        The solve does not fit into memory.
    SolverError
        A linear system is not positive definite, not finite, or was not solved.

    Examples
    --------
    >>> import numpy as np
    >>> from adaptive_fairing.core import denoise
    >>> x, y = np.meshgrid(np.arange(30.0), np.arange(30.0))
    >>> height = np.random.default_rng(0).normal(0, 0.2, x.size)
    >>> plane = np.column_stack([x.ravel(), y.ravel(), height])
    >>> corner = np.arange(870)[np.arange(870) % 30 < 29]
    >>> left = np.column_stack([corner, corner + 1, corner + 30])
    >>> result = denoise(plane, np.vstack([left, left[:, ::-1] + [0, 0, 31]]))
    >>> bool(result.positions[:, 2].std() < height.std())
    True
    """
    settings = settings or DenoiseSettings()
    mesh = CallerMesh.checked(vertices, faces, weights)
    if prepared is None:
        prepared = PreparedMesh.of(mesh)
    else:
        prepared.require(mesh.triangles, len(mesh.points))
    n_vertices = len(prepared.surface.vertex_of)
    if plan is not None and len(plan.noise) != n_vertices:
        raise InputError(f"the plan is of a mesh of {len(plan.noise)} vertices, not {n_vertices}")
    margin = filtered(settings.width, plan)
    problem = SolverProblem.posed(
        mesh, prepared, "denoise", boundary=settings.boundary, margin=margin
    )
    if plan is not None and problem.is_part:
        plan = plan.at(problem.whole.part)
    report = ProgressReport(progress, has_plan=plan is not None)
    outcome = denoised_surfaces(
        problem.space.topology,
        problem.start,
        not_judged(problem),
        settings,
        plan=plan,
        progress=report,
    )
    _require_converged(outcome.solve)
    report.begin("measure")
    frame, topology = problem.frame, problem.space.topology
    moves = [problem.weights[:, None] * (faired - problem.start) for faired in outcome.positions]
    for move in moves:
        move[problem.is_held] = 0
    surfaces = (problem.start, *(problem.start + move for move in moves))
    in_single = SINGLE.serves_mesh(topology.n_triangles, prepared.quadrature_tolerance, True)
    initial, *measures = (
        problem.space.measures(each, in_single).scaled(1 / frame.scale) for each in surfaces
    )
    plan, noise = outcome.plan, outcome.plan.noise
    denoised = TriangleSurface(topology, outcome.positions[STRENGTHS.index(1.0)])
    creases = denoised.crease_part()
    result = DenoiseResult(
        strengths=settings.strength * np.array(STRENGTHS),
        shapes=np.stack(
            [
                limited(frame.displaced(mesh.points, move), mesh.points, settings.max_deviation)
                for move in moves
            ]
        ),
        start=mesh.points,
        noise=problem.whole.to_caller(noise, np.zeros(n_vertices)),
        noise_level=_median_where(noise > 0, noise),
        noise_length=_median_where(noise > 0, noise * denoised.spacing) / frame.scale,
        radius=plan.radius,
        sharp_part=_sharp_part(plan),
        crease_part=creases,
        is_sharp=(
            creases > parameters().smooth_crease_fraction
            if settings.features == "auto"
            else settings.features == "sharp"
        ),
        initial=initial,
        measures=tuple(measures),
        solve=outcome.solve,
        notes=problem.notes + outcome.notes,
        other_readings=outcome.other_readings,
        settings=settings,
        plan=plan,
    )
    report.finish()
    return result


def _require_converged(solve: SolveReport) -> None:
    if not solve.converged:
        raise SolverError(
            f"a linear system was not solved: residual {solve.residual:.3g} after "
            f"{solve.iterations} iterations in all; repair or remesh thin triangles"
        )


def _median_where(judged: BoolArray, values: FloatArray) -> float:
    return float(np.median(values[judged])) if judged.any() else 0.0


def _sharp_part(plan: DenoisePlan) -> float:
    """Fraction of the coefficients at strength 1 that belongs to filters that keep creases."""
    if plan.is_idle:
        return 0.0
    mixture = plan.mixtures[STRENGTHS.index(1.0)]
    totals = {index: float(mixture.coefficients(index).sum()) for index in mixture.used}
    keeping = (total for index, total in totals.items() if plan.filters[index].creases == KEEPS)
    # A part of a surface may have no use for filters that the rest has.
    total = sum(totals.values())
    return sum(keeping) / total if total else 0.0
