"""Undo steps for changes in Sculpt Mode other than strokes, and for sliders outside Object Mode.

Blender stores strokes as differences, from which it cannot undo another kind of change. So a whole
state is stored just before the change, unless the last stored state is this one. For a slider of an
object Blender stores no step at all while it is edited, sculpted or painted, so the state after it
is stored as well, once the slider is let go.
"""

from __future__ import annotations

import zlib

import bpy

from .mesh_arrays import read_values
from .shape_keys import keys_checksum

_SCULPTED = ("position", ".sculpt_mask", ".sculpt_face_set", ".hide_vert", ".hide_poly")
"""Attributes that strokes change, besides colours."""

_WITHOUT_STEPS = ("EDIT", "SCULPT", "VERTEX_PAINT", "WEIGHT_PAINT")
"""Modes in which Blender stores no step for a slider. In Texture Paint it stores images alone."""

_stored: set[int] = set()  # checksums of the whole states that Blender has stored


def keep_before(obj: bpy.types.Object | None) -> None:
    """Store the state before a change of an object, if it is in Sculpt Mode."""
    if obj is not None and obj.mode == "SCULPT" and _checksum(obj) not in _stored:
        push()


def note_state(obj: bpy.types.Object | None) -> None:
    """Note that Blender stores the present state of an object as a whole."""
    if obj is not None and obj.mode == "SCULPT":
        _stored.add(_checksum(obj))


def keep_slide(obj: bpy.types.Object) -> None:
    """Call before every change by a slider, so that all changes until it is let go are one step."""
    if obj.mode in _WITHOUT_STEPS and not bpy.app.background and not is_sliding():
        keep_before(obj)
        bpy.app.timers.register(_wait)  # an operator must not start while a field is left


def is_sliding() -> bool:
    """Whether a change by a slider is not stored yet."""
    windows = bpy.context.window_manager.windows
    names = [each.bl_idname for window in windows for each in window.modal_operators]
    is_due = any(map(bpy.app.timers.is_registered, (_wait, push)))
    return is_due or "OBJECT_OT_adaptive_fairing_slide" in names


def _wait() -> None:
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
        bpy.ops.object.adaptive_fairing_slide("INVOKE_DEFAULT")


def push() -> None:
    """Store the present state as a step of the history."""
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
        if bpy.ops.ed.undo_push.poll():  # type: ignore[call-arg]  # the stubs want self
            bpy.ops.ed.undo_push(message="Adaptive Fairing")
        note_state(bpy.context.active_object)


def forget_states() -> None:
    """Forget all states, which belong to another file or to another visit to Sculpt Mode."""
    _stored.clear()


def _checksum(obj: bpy.types.Object) -> int:
    """Checksum of everything that strokes can change on an object in Sculpt Mode."""
    mesh = obj.data
    crc = obj.session_uid
    for name in (*_SCULPTED, *mesh.color_attributes.keys()):
        if name in mesh.attributes:
            crc = zlib.crc32(read_values(mesh.attributes[name]), crc)
    return crc if mesh.shape_keys is None else keys_checksum(mesh.shape_keys, crc)
