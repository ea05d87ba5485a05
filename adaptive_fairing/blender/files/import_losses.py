"""Losses of Blender's importers: parts of a mesh file that they silently leave out.

They drop vertices that no face uses, faces that Blender's meshes cannot have, and digits.
"""

from __future__ import annotations

from pathlib import Path

import bpy

from ...files.inspection import inspect
from ..data.mesh_arrays import read_positions
from .far_meshes import rounding_notes


def import_notes(path: Path) -> list[str]:
    """Compare what a mesh file holds with the meshes that Blender made of it.

    Parameters
    ----------
    path
        The file that was just loaded into an empty scene.

    Returns
    -------
    list of str
        One sentence for each kind of loss; none for formats whose elements are not counted.
    """
    contents = inspect(path)
    notes = [
        note
        for mesh in bpy.data.meshes
        for note in rounding_notes(read_positions(mesh), f"coordinates of {mesh.name!r} are")
    ]
    if contents.has_faces_before_groups:
        notes.append("groups are left out: Blender cannot read them after faces without a group")
    if contents.n_vertices is None or contents.n_faces is None:
        return notes
    missing_vertices = contents.n_vertices - sum(len(mesh.vertices) for mesh in bpy.data.meshes)
    missing_faces = contents.n_faces - sum(len(mesh.polygons) for mesh in bpy.data.meshes)
    parts = []
    if missing_vertices > 0:
        parts.append(f"{missing_vertices} vertices that no face uses")
    if missing_faces > 0:
        parts.append(f"{missing_faces} faces that repeat a vertex or another face")
    return [*notes, *([f"Blender leaves out {' and '.join(parts)}"] if parts else [])]
