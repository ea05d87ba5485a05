"""Job of a file that does not smooth its shape: refinement, or fairing of an attribute."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy

from ...core import FairingError, FairingSettings
from ...files.formats import BLEND, keeps_axes, splits_vertices, suffix_of
from ...files.output_words import FAIRED, REFINED
from ...files.report import settings_record, write_report
from ..data.mesh_arrays import weld
from ..data.refined_object import RefineOptions, refine_object
from ..data.shape_keys import shown_positions
from ..data.targets import writable_object
from ..files.import_losses import import_notes
from ..files.mesh_files import export_mesh, import_mesh, save_blend
from .fair_attribute import fair_attribute
from .file_job import mesh_counts, prepare_places, program_versions


@dataclass(frozen=True)
class Files:
    """Files and object of a job.

    Attributes
    ----------
    input, output, object_name, report
        As in `FairingJob`.
    """

    input: Path
    output: Path
    object_name: str | None = None
    report: Path | None = None


def refine_file(files: Files, levels: int) -> dict[str, Any]:
    """Refine a mesh onto its limit surface; with 0 levels its vertices only move there.

    The input file replaces everything that Blender holds.

    Returns
    -------
    dict
        The report, whether or not it is also written to a file.

    Raises
    ------
    FairingError
        The input has no mesh that can be changed in this way.
    OSError
        A file cannot be read or written.
    MemoryError
        The mesh or the result is too large for this machine.
    """
    record = {"algorithm": "refine", "settings": {"levels": levels}}
    return _change(files, record, lambda obj: refine_object(obj, RefineOptions(levels)))


def fair_attribute_of_file(files: Files, name: str, settings: FairingSettings) -> dict[str, Any]:
    """Fair a colour, a vertex group or another attribute of a mesh, whose vertices stay.

    The input file replaces everything that Blender holds. Returns and errors as in `refine_file`.
    """

    def change(obj: bpy.types.Object) -> list[str]:
        shown = shown_positions(obj.data)
        faired = fair_attribute(obj, name, settings, positions=shown)
        if not faired.n_limited:
            return []
        return [f"{faired.n_limited} of {faired.n_values} values were cut off at 0 or 1"]

    return _change(files, {**settings_record(settings), "attribute": name}, change)


def _change(
    files: Files, record: dict[str, Any], change: Callable[[bpy.types.Object], Iterable[str]]
) -> dict[str, Any]:
    prepare_places(files.output, files.report)
    report: dict[str, Any] = {
        "program": program_versions(),
        "input": files.input,
        "output": files.output,
        "object": files.object_name,
        **record,
        "mesh": {},
        "written": {},
        "notes": [],
        "error": None,
    }
    try:
        _read_change_write(files, report, change)
    except (FairingError, OSError, MemoryError) as error:
        report["error"] = str(error) or "not enough memory"
        if files.report is not None:
            write_report(files.report, report)
        raise
    if files.report is not None:
        write_report(files.report, report)
    return report


def _read_change_write(
    files: Files, report: dict[str, Any], change: Callable[[bpy.types.Object], Iterable[str]]
) -> None:
    as_in_file = keeps_axes(files.input, files.output)
    obj = import_mesh(files.input, files.object_name, keep_axes=as_in_file)
    report["object"] = obj.name
    report["notes"] = import_notes(files.input)
    report["mesh"] = mesh_counts(obj.data)
    if splits_vertices(files.input):
        weld(obj.data)
    word = REFINED if report["algorithm"] == "refine" else FAIRED
    obj = writable_object(obj, in_place=True, word=word)
    report["notes"] += change(obj)
    report["written"] = mesh_counts(obj.data)
    if suffix_of(files.output) == BLEND:
        save_blend(files.output)
        return
    is_of_scene = suffix_of(files.input) == BLEND
    report["notes"] += export_mesh(obj, files.output, alone=is_of_scene, keep_axes=as_in_file)
