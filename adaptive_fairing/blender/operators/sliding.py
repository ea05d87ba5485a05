"""The operator that waits in the background until a slider is let go, see `sculpt_undo`."""

from __future__ import annotations

import bpy

from ..data.sculpt_undo import push

PASSING = ("MOUSEMOVE", "INBETWEEN_MOUSEMOVE", "WINDOW_DEACTIVATE")
"""Events that happen while a slider is dragged, besides timers and modifier keys."""

CANCELLING = ("ESC", "RIGHTMOUSE")
"""Events by which Blender puts a dragged slider back."""

MODIFIERS = ("LEFT_SHIFT", "RIGHT_SHIFT", "LEFT_CTRL", "RIGHT_CTRL", "LEFT_ALT", "RIGHT_ALT")


class OBJECT_OT_adaptive_fairing_slide(bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_slide"
    bl_label = "Adaptive Fairing"
    bl_description = "Store what a slider has changed as a step of the history"
    bl_options = {"INTERNAL"}

    def invoke(self, context, event):
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type in (*PASSING, *MODIFIERS) or event.type.startswith("TIMER"):
            return {"PASS_THROUGH"}
        if event.value == "RELEASE" or event.type in CANCELLING:
            bpy.app.timers.register(push)  # after the slider has had this event
        else:
            push()  # before the event changes something else, or undoes
        return {"FINISHED", "PASS_THROUGH"}


register, unregister = bpy.utils.register_classes_factory((OBJECT_OT_adaptive_fairing_slide,))
