"""Operators that put the evolution of an object on the timeline, and that take it off."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ..data.run_record import evolution_keys
from .polls import is_allowed

NO_EVOLUTION = "Fair the active object first, with Evolution as its result"


class _OnEvolution:
    """Mix-in: works on the active object, which must have an evolution."""

    @classmethod
    def poll(cls, context):
        obj = context.active_object
        has_evolution = obj is not None and evolution_keys(obj) is not None
        is_ours = has_evolution and bool(obj.adaptive_fairing.shapes)
        return is_allowed(cls, None if is_ours else NO_EVOLUTION)


class OBJECT_OT_adaptive_fairing_animate(_OnEvolution, bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_animate"
    bl_label = "Animate"
    bl_description = "Let the timeline run through the evolution of the active object"
    bl_options = {"REGISTER", "UNDO"}

    frame_start: bpy.props.IntProperty(
        name="From Frame", description="Frame that shows the mesh before the first step", default=1
    )
    frame_end: bpy.props.IntProperty(
        name="To Frame", description="Frame that shows the last step", default=100
    )

    def execute(self, context):
        from ..data.shape_keys import animate_evolution

        if self.frame_end <= self.frame_start:
            self.report({"ERROR"}, rpt_("The last frame must come after the first"))
            return {"CANCELLED"}
        _clear_animation(evolution_keys(context.active_object))
        animate_evolution(context.active_object, self.frame_start, self.frame_end)
        scene = context.scene
        scene.frame_end = max(scene.frame_end, self.frame_end)
        scene.frame_set(scene.frame_current)
        return {"FINISHED"}


class OBJECT_OT_adaptive_fairing_animate_clear(_OnEvolution, bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_animate_clear"
    bl_label = "Clear Animation"
    bl_description = "Take the evolution of the active object off the timeline"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        _clear_animation(evolution_keys(context.active_object))
        return {"FINISHED"}


def is_animated(obj: bpy.types.Object) -> bool:
    """Whether the timeline runs through the shape keys of an object."""
    animation = obj.data.shape_keys.animation_data
    return animation is not None and animation.action is not None


def _clear_animation(keys: bpy.types.Key) -> None:
    action = keys.animation_data.action if keys.animation_data is not None else None
    keys.animation_data_clear()
    if action is not None and action.users == 0:
        bpy.data.actions.remove(action)


register, unregister = bpy.utils.register_classes_factory(
    (OBJECT_OT_adaptive_fairing_animate, OBJECT_OT_adaptive_fairing_animate_clear)
)
