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
from ..problem.problem import Margin, SolverProblem
from ..problem.region import rings_around
from ..runtime.arrays import BoolArray, FloatArray
from ..runtime.precision import SINGLE
from ..runtime.threads import ordered_map
from .filters import KEEPS
from .plan import STRENGTHS, DenoisePlan
from .progress import DenoiseProgress, ProgressReport
from .result import DenoiseResult
from .settings import DenoiseSettings
from .triangle_surface import TriangleSurface
from .whole_run import whole_run
from .wide_noise import denoised_surfaces

# Filters go on around a part so far that its border does not show in it. On a noisy torus 1.68,
# 1.32, 1.02 and 1.07 of the error of the whole run were left with 4, 8, 12 and 16 rings.
FILTERED = Margin(12)

# With the plan of a whole mesh a run on the whole differs by the tolerance of the filters' solves,
# which end by residuals of all vertices: by 1 to 4 % of what is removed, up to 12 % on very uneven
# meshes. With solves five times as exact it is 0.3 to 1 % at so many rings, 0.4 to 4 % at 12, 1 to
# 13 % at 8; but the whole then costs 1.06 to 1.19 times as much,
# for no clear gain.
FILTERED_AS_PLANNED = Margin(16)

# Largest part of creases among the edges of a mesh that is said to be smooth.  Of 25 shapes the
# smooth ones had at most 0.008 (one with slivers 0.027), those with creases at least 0.016.
MOST_CREASES = 0.01

# Rings for each edge of width, for noise of a given width.
RINGS_OF_WIDTH = 4

# The noise is judged only from the vertices that may move, because an earlier run may have removed
# it next to them.  Measured on 41,000 vertices, of which 1 % were denoised after their neighbours:
# with 4 rings around them, 20 to 95 % of the noise was found; from them alone 99 to 101 %.  The
# ring that `rings_around` leaves out is the first one.  Fewer vertices would tell little.
JUDGED = Margin(1, 300)


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
        it is. If most weights are 0, the others go where a run on the whole mesh moves them; such
        a run is made once for each `prepared`. Where the noise is unlike that of the whole, or the
        mesh was edited since, it is judged from the vertices that move, as if most weights were
        not 0, and the filters cover some rings around them.
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
    vertex_of = prepared.surface.vertex_of
    n_vertices = len(vertex_of)
    if plan is not None and len(plan.noise) != n_vertices:
        raise InputError(f"the plan is of a mesh of {len(plan.noise)} vertices, not {n_vertices}")
    margin = _filtered(settings.width, plan)
    problem = SolverProblem.posed(
        mesh, prepared, "denoise", boundary=settings.boundary, margin=margin
    )
    report = ProgressReport(progress, has_plan=plan is not None)
    not_judged = _not_judged(problem)
    run = outcome = None
    if problem.is_part and plan is None:
        now = mesh.points[vertex_of]
        run = whole_run(problem, prepared, now, settings, report)
        outcome = None if run is None else run.at_part(problem, now, ~not_judged)
    if outcome is None:
        part = problem.whole.part
        own_plan = plan.at(part) if plan is not None and problem.is_part else plan
        outcome = denoised_surfaces(
            problem.space.topology,
            problem.start,
            not_judged,
            settings,
            plan=own_plan,
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

    def moved(move: FloatArray) -> FloatArray:
        return limited(frame.displaced(mesh.points, move), mesh.points, settings.max_deviation)

    noise = outcome.plan.noise
    denoised = TriangleSurface(topology, outcome.positions[STRENGTHS.index(1.0)])
    result = DenoiseResult(
        strengths=settings.strength * np.array(STRENGTHS),
        shapes=np.stack(list(ordered_map(moved, moves))),
        start=mesh.points,
        noise=problem.whole.to_caller(noise, np.zeros(n_vertices)),
        noise_level=_median_where(noise > 0, noise),
        noise_length=_median_where(noise > 0, noise * denoised.spacing) / frame.scale,
        radius=outcome.plan.radius,
        sharp_part=_sharp_part(outcome.plan),
        crease_part=denoised.crease_part,
        is_sharp=settings.features == "sharp"
        or (settings.features == "auto" and denoised.crease_part > MOST_CREASES),
        initial=initial,
        measures=tuple(measures),
        solve=outcome.solve,
        notes=problem.notes + outcome.notes,
        other_readings=outcome.other_readings,
        settings=settings,
        plan=plan or (run or outcome).plan,
    )
    if run is not None:
        run.note_result(result.positions[vertex_of], mesh.weights[vertex_of])
    report.finish()
    return result


def _filtered(width: str | float, plan: DenoisePlan | None) -> Margin | None:
    """Margin around a part that filters need for noise of a width; None for the whole mesh.

    A plan with a coarse level needs the whole mesh.
    """
    if plan is not None:
        return FILTERED_AS_PLANNED if plan.level is None else None
    if width == "auto":
        return FILTERED
    return Margin(max(FILTERED.n_rings, round(RINGS_OF_WIDTH * float(width))))


def _not_judged(problem: SolverProblem) -> BoolArray:
    """Vertices from which noise and risk are not judged, besides those of the boundary.

    Returns
    -------
    (n,) bool
        Vertices on cuts and vertices of weight 0, except a few around the moving ones.
    """
    is_cut, moves = problem.frame.surface.is_cut, problem.weights > 0
    if moves.all():
        return is_cut
    return is_cut | ~rings_around(problem.space.topology, moves, *JUDGED)


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
