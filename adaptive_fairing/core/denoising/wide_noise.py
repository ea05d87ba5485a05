"""Wide noise: removed on a coarser level of the surface, where it spans few edges.

There the filters reach as far as the noise, creases and flat faces are found as on any mesh, and a
run takes a fraction of the time.  The displacement of the level is carried back as a smooth field,
so everything finer than the level, including creases, does not change.  The field has all three
coordinates: heights along the normals of the finer mesh would turn triangles over at its creases.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse import csgraph

from ..mesh.topology import TriangleTopology
from ..runtime.arrays import BoolArray, FloatArray
from .bounds import unfolded
from .coarse_level import CoarseLevel, most_hops
from .mixing import MixedSurfaces, mixed_surfaces
from .parameters import parameters
from .plan import DenoisePlan
from .progress import ProgressReport
from .settings import DenoiseSettings
from .triangle_surface import TriangleSurface


def denoised_surfaces(
    topology: TriangleTopology,
    positions: FloatArray,
    is_still: BoolArray,
    settings: DenoiseSettings,
    *,
    plan: DenoisePlan | None = None,
    progress: ProgressReport,
) -> MixedSurfaces:
    """Denoise positions on the solver's mesh, for all of `STRENGTHS`; wide noise on a level.

    Parameters as in `mixed_surfaces`.
    """
    width = None if settings.width == "auto" else float(settings.width)
    fine = TriangleSurface(topology, positions)
    level = plan.level if plan is not None else level_of_width(fine, width)
    if level is None:
        return mixed_surfaces(
            topology, positions, is_still, settings, width=width, plan=plan, progress=progress
        )
    start = positions[level.vertices]
    outcome = mixed_surfaces(
        level.topology,
        start,
        level.surface.is_cut | is_still[level.vertices],
        settings,
        width=None if width is None else width / level.ratio,
        plan=None if plan is None else plan.on_level,
        progress=progress,
    )
    moves = np.concatenate([each - start for each in outcome.positions], axis=1)
    field = level.carried_back(moves, fine)
    if settings.boundary == "fixed":
        field *= _away_from_boundary(topology, 2 * level.ratio)[:, None]
    counted = ~(topology.on_boundary | topology.is_loose | is_still)
    of_level = outcome.plan.noise
    typical = np.median(of_level[of_level > 0], keepdims=True) if of_level.any() else np.zeros(1)
    noise = np.where(counted, level.ratio * typical, 0)
    results = [positions + each for each in np.split(field, len(outcome.positions), axis=1)]
    return replace(
        outcome,
        positions=[unfolded(each, fine, noise > 0, counted) for each in results],
        plan=outcome.plan.carried_to(level, noise),
    )


def level_of_width(fine: TriangleSurface, width: float | None) -> CoarseLevel | None:
    """Make the coarsest level on which noise of a width, in edges, spans enough edges.

    None if that is the surface itself, or if every level would have too few vertices: on those the
    shape looks like noise.
    """
    if width is None:
        return None
    tuned = parameters()
    for hops in range(most_hops(width / tuned.level_edges_of_width), 0, -1):
        level = CoarseLevel.over(fine, hops)
        if np.count_nonzero(level.is_known) >= tuned.fewest_to_tell_smooth:
            return level
    return None


def _away_from_boundary(topology: TriangleTopology, far: float) -> FloatArray:
    """Weights (n,) by the distance from boundaries, which stay: 0 there, up to 1 at `far` edges."""
    boundary = topology.boundary_vertices
    if not len(boundary):
        return np.ones(topology.n_vertices)
    edges = csgraph.dijkstra(
        topology.adjacency(), indices=boundary, min_only=True, unweighted=True, limit=far
    )
    part = np.minimum(edges / far, 1)
    smooth: FloatArray = part**2 * (3 - 2 * part)
    return smooth
