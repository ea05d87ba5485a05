"""Shown level of a multiresolution sculpture, read as a mesh of its own and written back.

Blender moves the finer levels along; the base mesh and the coarser levels do not change.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy
import numpy as np
from bpy.app.translations import pgettext_rpt as rpt_

from .mesh_arrays import MeshData, is_shared, read_mesh, write_positions


def shown_level(obj: bpy.types.Object) -> bpy.types.Modifier | None:
    """Find the modifier whose sculpted level an object shows; None if it shows its base mesh."""
    levels = (each for each in obj.modifiers if each.type == "MULTIRES" and each.show_viewport)
    return next((each for each in levels if each.levels > 0), None)


def read_level(obj: bpy.types.Object) -> MeshData:
    """Read the shown level of an object in Object Mode, without its other modifiers.

    Raises
    ------
    FairingError
        The level could not be written back.
    """
    from ...core import FairingError  # enabling the add-on does not load the core

    mesh = obj.data
    if mesh.shape_keys is not None:
        raise FairingError(
            rpt_("has shape keys below its sculpted levels: apply or remove them first")
        )
    if is_shared(mesh) or mesh.library is not None or obj.library is not None:
        raise FairingError(
            rpt_("shares its sculpted levels with other objects: make its data single-user first")
        )
    level = _level_mesh(obj)
    try:
        return read_mesh(level)
    finally:
        bpy.data.meshes.remove(level)


def write_level(obj: bpy.types.Object, start: np.ndarray, positions: np.ndarray) -> None:
    """Write new positions to the shown level.

    Parameters
    ----------
    obj
        Mesh object in Object Mode.
    start, positions
        (n, 3) positions that were read, and the new ones.

    Raises
    ------
    FairingError
        The level was changed after it was read.
    """
    from ...core import FairingError

    modifier = shown_level(obj)
    if modifier is None or not np.array_equal(read_level(obj).vertices, start):
        raise FairingError(rpt_("the mesh was changed during the run; nothing was written"))
    level = _level_mesh(obj)
    write_positions(level, positions)
    shape = bpy.data.objects.new(level.name, level)
    bpy.context.scene.collection.objects.link(shape)
    try:
        with (
            _only_levels(obj),
            bpy.context.temp_override(
                object=obj, active_object=obj, selected_editable_objects=[obj, shape]
            ),
        ):
            bpy.context.view_layer.update()
            bpy.ops.object.multires_reshape(modifier=modifier.name)
    finally:
        bpy.data.batch_remove([shape, level])


def _level_mesh(obj: bpy.types.Object) -> bpy.types.Mesh:
    """Make a mesh of the shown level."""
    with _only_levels(obj):
        graph = bpy.context.evaluated_depsgraph_get()
        return bpy.data.meshes.new_from_object(obj.evaluated_get(graph), depsgraph=graph)


@contextmanager
def _only_levels(obj: bpy.types.Object) -> Iterator[None]:
    """Turn off all other modifiers, and the scene's simplification."""
    render, modifier = bpy.context.scene.render, shown_level(obj)
    others = [each for each in obj.modifiers if each != modifier and each.show_viewport]
    is_simplified = render.use_simplify
    render.use_simplify = False
    for each in others:
        each.show_viewport = False
    try:
        yield
    finally:
        render.use_simplify = is_simplified
        for each in others:
            each.show_viewport = True
