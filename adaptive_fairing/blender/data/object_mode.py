"""Visit to Object Mode from any other mode."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy

from .sculpt_undo import keep_before


@contextmanager
def object_mode(context: bpy.types.Context) -> Iterator[None]:
    """Change to Object Mode and, if the active object is still visible, back again.

    Only there can positions, shape keys and attributes be read and written.
    """
    active = context.active_object
    mode = active.mode if active is not None else "OBJECT"
    if mode == "OBJECT":
        yield
        return
    uid = active.session_uid
    bpy.ops.object.mode_set(mode="OBJECT")
    try:
        yield
    finally:
        active = context.view_layer.objects.active
        if active is not None and active.session_uid == uid and active.visible_get():
            bpy.ops.object.mode_set(mode=mode)
        # A step of Edit Mode's history is the edited mesh alone. Blender keeps a whole state beside
        # it if data were made since the last one.
        bpy.data.meshes.remove(bpy.data.meshes.new(""))


def prepare_undo(context: bpy.types.Context) -> None:
    """Call before a change, so that one undo step reverts it exactly, in Sculpt Mode too."""
    keep_before(context.active_object)
