"""Visit to Object Mode from any other mode."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy

from .sculpt_undo import keep_before, note_state


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


@contextmanager
def undoable_object_mode(context: bpy.types.Context) -> Iterator[None]:
    """Visit Object Mode for a change that one undo step reverts exactly, in Sculpt Mode too.

    For the body of an operator with an undo step.
    """
    keep_before(context.active_object)
    with object_mode(context):
        yield
    note_state(context.active_object)
