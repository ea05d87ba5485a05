"""Validation of an imported mesh by Blender, without its silent or random repairs.

`Mesh.validate` turns coordinates that are not numbers into 0; here they are refused. Of several
faces with the same vertices it keeps the one that a thread happens to reach first; here the first
face of the mesh is kept.
"""

from __future__ import annotations

import bpy
import numpy as np

from ...core import InputError
from ...core.errors import listed
from ...files.inspection.contents import repeated
from ..data.mesh_arrays import read_positions


def validate(mesh: bpy.types.Mesh) -> None:
    """Remove elements that are invalid in Blender, such as faces that repeat a vertex.

    Raises
    ------
    InputError
        Coordinates are not finite numbers, or faces name vertices that do not exist.
    """
    _refuse(
        np.flatnonzero(~np.isfinite(read_positions(mesh)).all(axis=1)),
        f"vertices of mesh {mesh.name!r} have coordinates that are not finite numbers",
    )
    corners = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    _refuse(
        np.flatnonzero((corners < 0) | (corners >= len(mesh.vertices))),
        f"corners of faces of mesh {mesh.name!r} name vertices that are not there",
    )
    starts = np.empty(len(mesh.polygons) + 1, dtype=np.int32)
    mesh.polygons.foreach_get("loop_start", starts[:-1])
    starts[-1] = len(corners)
    again = repeated(corners, starts)
    if len(again):
        # Faces that name one vertex only are removed in order, unlike faces that are equal.
        corners[starts[again] + 1] = corners[starts[again]]
        mesh.loops.foreach_set("vertex_index", corners)
    mesh.validate(clean_customdata=False)


def _refuse(bad: np.ndarray, what: str) -> None:
    if len(bad):
        raise InputError(f"{len(bad)} {what}: {listed(bad)}; delete or repair them")
