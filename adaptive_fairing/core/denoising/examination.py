"""Examination of a mesh before a run: its noise, its parts, its defects."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..linalg.conjugate_gradients import SolveReport
from ..problem.caller_mesh import CallerMesh
from ..problem.diagnosis import MeshProblems, find_problems
from ..problem.mesh_counts import MeshCounts, mesh_counts
from ..problem.prepared_mesh import PreparedMesh
from .noise_verdict import noise_verdict
from .progress import DenoiseProgress, ProgressReport
from .settings import DenoiseSettings
from .stage import Stage
from .triangle_surface import TriangleSurface
from .wide_noise import level_of_width


class Examination(NamedTuple):
    """Noise that `denoise` would find in a mesh, and the parts and defects of the mesh.

    Attributes
    ----------
    noise_level, noise_length : float
        As in `DenoiseResult`.
    is_clean : bool
        Whether there is nothing to remove.
    notes : tuple of str
        Remarks on the kind of roughness, if there are any.
    counts : MeshCounts
    problems : MeshProblems
    """

    noise_level: float
    noise_length: float
    is_clean: bool
    notes: tuple[str, ...]
    counts: MeshCounts
    problems: MeshProblems


def examine(
    vertices: ArrayLike,
    faces: ArrayLike,
    settings: DenoiseSettings | None = None,
    *,
    progress: Callable[[DenoiseProgress], None] | None = None,
) -> Examination:
    """Measure the noise of a mesh without removing it, and count its parts and defects.

    `denoise` does the same before it filters.  After filtering, it may still find that the removed
    part is not like noise.

    Parameters
    ----------
    vertices : (n, 3) float
    faces : (m, 3) int
    settings : DenoiseSettings, optional
    progress : callable, optional
        As of `denoise`.

    Raises
    ------
    InputError
        As `denoise`.
    """
    settings = settings or DenoiseSettings()
    mesh = CallerMesh.checked(vertices, faces)
    prepared = PreparedMesh.of(mesh)
    surface, frame = prepared.surface, prepared.frame(mesh.points, "box")
    report = ProgressReport(progress, has_plan=False)
    report.begin("noise")

    def on_solve(_solve: SolveReport) -> None:
        report.again()

    topology, positions, is_still = surface.topology, frame.inward(mesh.points), surface.is_cut
    width = None if settings.width == "auto" else float(settings.width)
    level = level_of_width(TriangleSurface(topology, positions), width)
    if level is not None:
        topology, positions = level.topology, positions[level.vertices]
        is_still = level.surface.is_cut | is_still[level.vertices]
    ratio = 1.0 if level is None else level.ratio
    stage = Stage(topology, positions, is_still, on_solve)
    of_level = None if width is None else width / ratio
    verdict = noise_verdict(stage, settings.clean, of_level)
    noise = verdict.whole(verdict.level) if verdict.level.any() else verdict.level
    found, spacing = noise > 0, verdict.stage.frame.spacing
    size, length = (
        float(np.median(each[found])) if found.any() else 0.0 for each in (noise, noise * spacing)
    )
    return Examination(
        noise_level=ratio * size,
        noise_length=length / frame.scale,
        is_clean=not (verdict.impulsive.any() or noise.any()),
        notes=verdict.notes,
        counts=mesh_counts(mesh.triangles),
        problems=find_problems(mesh.points, mesh.triangles, surface),
    )
