"""Operator that turns the shape keys of an earlier file into a result."""

from __future__ import annotations

import bpy

from ..data.earlier_files import has_earlier_keys, take_keys
from ..data.object_mode import undoable_object_mode
from .polls import busy_refusal, is_allowed, linked_refusal, no_active_mesh_refusal


class OBJECT_OT_adaptive_fairing_take_keys(bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_take_keys"
    bl_label = "Make Them a Result"
    bl_description = (
        "Give the shape keys of an earlier run a slider, Before, Split, Apply and Discard. "
        "Strengths are stored without keys, unless they are animated"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        refusal, obj = no_active_mesh_refusal(context), context.active_object
        if refusal is None and not has_earlier_keys(obj):
            refusal = "The active object has no shape keys of an earlier run"
        elif refusal is None:
            refusal = linked_refusal(obj)
        return is_allowed(cls, refusal, busy_refusal())

    def execute(self, context):
        with undoable_object_mode(context):
            take_keys(context.active_object)
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((OBJECT_OT_adaptive_fairing_take_keys,))
