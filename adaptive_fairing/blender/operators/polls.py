"""Polls shared by operators: reasons for a greyed-out button."""

from __future__ import annotations

import bpy

from .modal_run import progress


def is_allowed(operator: type[bpy.types.Operator], *reasons: str | None) -> bool:
    """Decide an operator's poll: False if there is a reason, of which the first is shown."""
    message = next((reason for reason in reasons if reason is not None), None)
    if message is not None:
        operator.poll_message_set(message)
    return message is None


def no_active_mesh_refusal(context: bpy.types.Context) -> str | None:
    """Message that the active object has no mesh; None if it has."""
    obj = context.active_object
    return "Make a mesh object active" if obj is None or obj.type != "MESH" else None


def linked_refusal(obj: bpy.types.Object) -> str | None:
    """Say that the mesh of an object belongs to another file; None if it does not."""
    if obj.library is None and obj.data.library is None:
        return None
    return "The mesh is linked from another file: it cannot be edited here"


def busy_refusal() -> str | None:
    """Message that a run is going on, so that no other can start; None if none is."""
    if progress() is None:
        return None
    return "A run is going on: wait for it, or stop it with Esc"
