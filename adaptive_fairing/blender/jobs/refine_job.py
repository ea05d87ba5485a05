"""One file in, its mesh refined onto the smooth limit surface, one file out. Nothing is faired."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...core import FairingError
from ...files.formats import BLEND, keeps_axes, splits_vertices, suffix_of
from ...files.report import write_report
from ..data.refined_object import RefineOptions, refine_object
from ..data.targets import writable_object
from ..data.weld import weld
from ..files.import_losses import import_notes
from ..files.mesh_files import export_mesh, import_mesh, save_blend
from .file_job import mesh_counts, prepare_places, program_versions


@dataclass(frozen=True)
class RefineJob:
    """What to do.

    Attributes
    ----------
    input, output, object_name, report
        As in `FairingJob`.
    levels
        Steps of Loop subdivision; 0 moves the vertices to the limit surface without new ones.
    """

    input: Path
    output: Path
    levels: int = 1
    object_name: str | None = None
    report: Path | None = None


def refine_file(job: RefineJob) -> dict[str, Any]:
    """Do the job. Everything that Blender holds is replaced by the input file.

    Returns
    -------
    dict
        The report, whether or not it is also written to a file.

    Raises
    ------
    FairingError
        The input is no mesh that can be refined.
    OSError
        A file cannot be read or written.
    MemoryError
        The refined mesh is too large for this machine.
    """
    prepare_places(job.output, job.report)
    report: dict[str, Any] = {
        "program": program_versions(),
        "input": job.input,
        "output": job.output,
        "object": job.object_name,
        "algorithm": "refine",
        "settings": {"levels": job.levels},
        "mesh": {},
        "written": {},
        "notes": [],
        "error": None,
    }
    try:
        _refine(job, report)
    except (FairingError, OSError, MemoryError) as error:
        report["error"] = str(error) or "not enough memory"
        if job.report is not None:
            write_report(job.report, report)
        raise
    if job.report is not None:
        write_report(job.report, report)
    return report


def _refine(job: RefineJob, report: dict[str, Any]) -> None:
    as_in_file = keeps_axes(job.input, job.output)
    obj = import_mesh(job.input, job.object_name, keep_axes=as_in_file)
    report["object"] = obj.name
    report["notes"] = import_notes(job.input)
    report["mesh"] = mesh_counts(obj.data)
    if splits_vertices(job.input):
        weld(obj.data)
    obj = writable_object(obj, in_place=True)
    report["notes"] += refine_object(obj, RefineOptions(job.levels))
    report["written"] = mesh_counts(obj.data)
    if suffix_of(job.output) == BLEND:
        save_blend(job.output)
        return
    is_of_scene = suffix_of(job.input) == BLEND
    report["notes"] += export_mesh(obj, job.output, alone=is_of_scene, keep_axes=as_in_file)
