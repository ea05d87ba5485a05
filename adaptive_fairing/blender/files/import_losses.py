"""What Blender's importers leave out of a mesh file without a word: counted, to be told.

They drop vertices that no face uses and faces that no mesh of Blender can have.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy

from ...files.formats import suffix_of


def import_notes(path: Path) -> list[str]:
    """Compare what a mesh file holds with the meshes that Blender made of it.

    Parameters
    ----------
    path
        The file that was just loaded into an empty scene.

    Returns
    -------
    list of str
        One sentence if something is missing; none for formats that cannot be counted here.
    """
    count = _COUNTERS.get(suffix_of(path))
    if count is None:
        return []
    n_vertices, n_faces = count(path)
    missing_vertices = n_vertices - sum(len(mesh.vertices) for mesh in bpy.data.meshes)
    missing_faces = n_faces - sum(len(mesh.polygons) for mesh in bpy.data.meshes)
    parts = []
    if missing_vertices > 0:
        parts.append(f"{missing_vertices} vertices that no face uses")
    if missing_faces > 0:
        parts.append(f"{missing_faces} faces that repeat a vertex or another face")
    return [f"Blender leaves out {' and '.join(parts)}"] if parts else []


def _count_obj(path: Path) -> tuple[int, int]:
    n_vertices = n_faces = 0
    with path.open("rb") as stream:
        for line in stream:
            words = line.split(None, 1)
            if words:
                n_vertices += words[0] == b"v"
                n_faces += words[0] == b"f"
    return n_vertices, n_faces


def _count_ply(path: Path) -> tuple[int, int]:
    counts = {b"vertex": 0, b"face": 0}
    with path.open("rb") as stream:
        for line in stream:
            words = line.split()
            if words[:1] == [b"end_header"]:
                break
            if len(words) == 3 and words[0] == b"element" and words[1] in counts:
                counts[words[1]] = int(words[2])
    return counts[b"vertex"], counts[b"face"]


_COUNTERS: dict[str, Callable[[Path], tuple[int, int]]] = {".obj": _count_obj, ".ply": _count_ply}
