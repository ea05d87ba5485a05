"""Job of a file: read it, smooth its mesh, write the result."""

from __future__ import annotations

import platform
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import scipy

from ...core import (
    DenoisePlan,
    DenoiseSettings,
    FairingError,
    FairingSettings,
    InputError,
    PreparedMesh,
    SolverError,
)
from ...files.atomic_files import remove_drafts, writable_place
from ...files.formats import BLEND, keeps_axes, splits_vertices, suffix_of
from ...files.output_words import DENOISED, FAIRED
from ...files.report import build_report, denoise_record, step_record, write_report
from ...version import program_version
from ..data.coloring import write_field
from ..data.mesh_arrays import MeshData, n_triangles, read_mesh, weld, welded, write_positions
from ..data.multires import shown_level
from ..data.refined_object import RefineOptions, refine_object
from ..data.shape_keys import animate_evolution, remove_fairing_keys, write_absolute_keys
from ..data.targets import needs_copy, writable_object
from ..files.import_losses import import_notes
from ..files.mesh_files import export_mesh, import_mesh, save_blend
from .frames import object_at_frame
from .opening_view import color_by_density, denoised_beside, frame_views
from .solve import Settings, Solve

FRAMES_PER_STEP = 10
"""Length of one step on the timeline of an output .blend, in frames."""

OnStep = Callable[[Solve], None]
OnFractionDone = Callable[[float], None]


@dataclass(frozen=True)
class FairingJob:
    """One file to process.

    Attributes
    ----------
    input, output
        Files; their suffixes choose the formats. A .blend output gets every step or strength, a
        mesh format the result alone.
    settings
        Settings of one of the algorithms, which choose it.
    object_name
        Mesh object of the input; None if it holds a single one.
    report
        File for the JSON report; None for no report.
    frame
        Frame of an animated input whose deformed shape is smoothed; the output is then a mesh
        format. None takes the mesh as it is stored, before modifiers.
    refine
        Steps of Loop subdivision of the result, onto the limit surface; 0 only moves the vertices
        there, None leaves the result as it is.
    denoised_beside
        Whether an output .blend of a mesh file gets a second object, with the result of `denoise`,
        beside that of the paper's method. A refined result gets none.
    """

    input: Path
    output: Path
    settings: Settings = field(default_factory=DenoiseSettings)
    object_name: str | None = None
    report: Path | None = None
    frame: int | None = None
    refine: int | None = None
    denoised_beside: bool = False


@dataclass(frozen=True)
class Preparation:
    """Work on a surface that is done before its solve.

    Attributes
    ----------
    mesh
        The prepared mesh.
    plan
        Plan by which `denoise` mixes its filters; None lets it find one.
    """

    mesh: PreparedMesh
    plan: DenoisePlan | None = None


Prepare = Callable[[MeshData], Preparation]
Admit = Callable[[PreparedMesh], None]


def run_job(
    job: FairingJob,
    on_step: OnStep | None = None,
    *,
    on_fraction_done: OnFractionDone | None = None,
    prepare: Prepare | None = None,
    admit: Admit | None = None,
) -> dict[str, Any]:
    """Do the job; the input file replaces everything that Blender holds.

    If a later step fails, the steps before it are written, and then the error is raised. A step
    that did not converge is not written.

    Parameters
    ----------
    job
        The job.
    on_step
        Called with the solve after every step of the paper's methods.
    on_fraction_done
        Called with the fraction of `denoise` that is done, 0 to 1; also for the object beside.
    prepare
        Returns the preparation of a surface, by default a new one; a caller of many jobs may reuse
        an earlier one.
    admit
        Called when the surface is known, before the memory for its solve is taken. An exception
        from it ends the job without an output.

    Returns
    -------
    dict
        The report, whether or not it is also written to a file.

    Raises
    ------
    FairingError
        The input has no mesh that can be smoothed, or the solver failed.
    OSError
        A file cannot be read or written.
    MemoryError
        The mesh is too large for this machine.
    """
    prepare_places(job.output, job.report)
    run = _Run(
        job,
        prepare or (lambda data: prepared_alone(data, job.settings)),
        admit or (lambda prepared: None),
    )
    try:
        run.execute(on_step or (lambda solve: None), on_fraction_done or (lambda part: None))
    except (FairingError, OSError, MemoryError) as error:
        if job.report is not None:
            write_report(job.report, run.report(str(error) or "not enough memory"))
        raise
    report = run.report(None)
    if job.report is not None:
        write_report(job.report, report)
    return report


class _Run:
    """State of a running job, from which its report can be written at any moment."""

    def __init__(self, job: FairingJob, prepare: Prepare, admit: Admit) -> None:
        self.job = job
        self.prepare = prepare
        self.admit = admit
        self.object_name = job.object_name
        self.mesh: Mapping[str, int] = {}
        self.written: Mapping[str, int] = {}
        self.solve: Solve | None = None
        self.notes: list[str] = []

    def execute(self, on_step: OnStep, on_fraction_done: OnFractionDone) -> None:
        job = self.job
        obj = import_mesh(job.input, job.object_name, keep_axes=keeps_axes(job.input, job.output))
        self.object_name = obj.name
        self.notes = import_notes(job.input)
        if job.frame is not None:
            obj = object_at_frame(obj, job.frame)
        elif shown_level(obj) is not None:
            raise InputError(
                f"{obj.name!r} has sculpted levels, below which only its base mesh would change: "
                "apply the multiresolution modifier, or denoise it in Blender's window"
            )
        if job.refine is not None and splits_vertices(job.input):
            weld(obj.data)
        data = read_mesh(obj.data)
        self.mesh = mesh_counts(obj.data)
        surface, surface_vertex = solved_surface(data, job.input)
        preparation = self.prepare(surface)
        self.admit(preparation.mesh)
        self.solve = solve = Solve(
            surface.vertices,
            surface.triangles,
            job.settings,
            prepared=preparation.mesh,
            plan=preparation.plan,
            on_fraction_done=on_fraction_done,
        )
        for _ in solve.run():
            on_step(solve)
        if solve.has_result:
            self._write(obj, surface_vertex)
        if isinstance(solve.failure, SolverError):
            n_steps = len(solve.steps)
            written = f"the {n_steps} before it are in {job.output}" if n_steps else "no output"
            raise SolverError(f"{solve.failure} ({written})") from solve.failure
        if solve.failure is not None:
            raise solve.failure

    def _write(self, obj: bpy.types.Object, surface_vertex: np.ndarray | slice) -> None:
        job, solve = self.job, self.solve
        is_copy = needs_copy(obj)
        obj = writable_object(obj, word=DENOISED if solve.is_denoise else FAIRED)
        if suffix_of(job.output) == BLEND:
            is_own_scene = suffix_of(job.input) != BLEND
            objects = [obj]
            is_alone = not job.denoised_beside or job.refine is not None
            if solve.steps and is_own_scene and not is_alone:
                beside, note = denoised_beside(obj, solve, surface_vertex, solve.on_fraction_done)
                self.notes.append(note)
                objects += [] if beside is None else [beside]
            shapes = [shape[surface_vertex] for shape in solve.shapes]
            write_absolute_keys(obj, shapes, solve.shown)
            if solve.steps:
                write_field(obj.data, "DENSITY", solve.steps[-1].density[surface_vertex])
                color_by_density(obj)
            self._finish(obj)
            _put_on_timeline(obj, solve.shown, extend=not is_own_scene)
            if is_own_scene:
                frame_views(objects)
            save_blend(job.output)
        else:
            remove_fairing_keys(obj)
            write_positions(obj.data, solve.positions[surface_vertex])
            self._finish(obj)
            self.notes += export_mesh(
                obj,
                job.output,
                alone=is_copy or suffix_of(job.input) == BLEND or job.frame is not None,
                keep_axes=keeps_axes(job.input, job.output),
            )

    def _finish(self, obj: bpy.types.Object) -> None:
        if self.job.refine is not None:
            self.notes += refine_object(obj, RefineOptions(self.job.refine))
        self.written = mesh_counts(obj.data)

    def report(self, error: str | None) -> dict[str, Any]:
        job, solve = self.job, self.solve
        has_result = solve is not None and solve.has_result
        result = solve.denoised if has_result else None
        return build_report(
            settings=job.settings,
            program=program_versions(),
            files={"input": job.input, "output": job.output, "object": self.object_name},
            mesh=self.mesh,
            written=self.written,
            initial=solve.measures[0] if has_result else None,
            denoise=None if result is None else denoise_record(result, solve.seconds),
            steps=[] if solve is None else _step_records(solve),
            stop_reason=None if solve is None else solve.stop_reason,
            notes=[*self.notes, *(() if solve is None else solve.notes)],
            error=error,
        )


def _step_records(solve: Solve) -> list[dict[str, Any]]:
    """Make records of the steps of the paper's methods, including one that did not converge."""
    if solve.is_denoise:
        return []
    tried = [*solve.steps, *([] if solve.failed_step is None else [solve.failed_step])]
    return [
        step_record(step, solve.vertices, seconds)
        for step, seconds in zip(tried, solve.step_seconds, strict=True)
    ]


def prepared_alone(data: MeshData, settings: Settings, scale: float | None = None) -> Preparation:
    """Prepare a surface that shares at most the scale with others."""
    options = {}
    if isinstance(settings, FairingSettings):
        options["quadrature_tolerance"] = settings.quadrature_tolerance
        options["normalize"] = settings.normalize
    return Preparation(PreparedMesh(data.vertices, data.triangles, scale=scale, **options))


def solved_surface(data: MeshData, source: Path) -> tuple[MeshData, np.ndarray | slice]:
    """Surface to solve on for a mesh from a file, and the mesh's vertices as vertices of it."""
    return welded(data) if splits_vertices(source) else (data, slice(None))


def _put_on_timeline(obj: bpy.types.Object, shown: int, *, extend: bool) -> None:
    """Animate the keys from the scene's first frame on.

    Parameters
    ----------
    obj
        Object with absolute keys.
    shown
        Index of the step to show.
    extend
        Whether to only lengthen the scene's frame range, which other animation may need, instead of
        fitting it.
    """
    scene = obj.users_scene[0]
    blocks = obj.data.shape_keys.key_blocks[1:]  # without the Basis
    first = scene.frame_start
    last = first + FRAMES_PER_STEP * len(blocks)
    animate_evolution(obj, first, last)
    obj.data.shape_keys.eval_time = blocks[shown].frame
    scene.frame_end = max(scene.frame_end, last) if extend else last
    scene.frame_current = first + FRAMES_PER_STEP * (range(len(blocks))[shown] + 1)


def prepare_places(*paths: Path | None) -> None:
    """Check that files can be written, and remove drafts that killed runs have left there.

    Raises
    ------
    OSError
        A file cannot be written; the message says in one line why not.
    """
    for path in paths:
        if path is not None:
            writable_place(path)
            remove_drafts(path)


def mesh_counts(mesh: bpy.types.Mesh) -> dict[str, int]:
    """Count the elements of a mesh."""
    return {
        "vertices": len(mesh.vertices),
        "edges": len(mesh.edges),
        "polygons": len(mesh.polygons),
        "triangles": n_triangles(mesh),
    }


def program_versions() -> dict[str, str]:
    """Names and versions of the programs, for the report."""
    return {
        "name": "adaptive-fairing",
        "version": program_version(),
        "blender": bpy.app.version_string,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
    }
