"""Operators that animate the evolution of an object, play it, and remove the animation."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ..data.shape_keys import (
    animate_evolution,
    animated_frames,
    clear_animation,
    evolution_keys,
)
from .polls import is_allowed

NO_EVOLUTION = "Fair the active object first, with Evolution as its result"


class _OnEvolution:
    """Mix-in of operators on the active object, which must have an evolution."""

    @classmethod
    def poll(cls, context):
        obj = context.active_object
        has_evolution = obj is not None and evolution_keys(obj) is not None
        is_ours = has_evolution and bool(obj.adaptive_fairing.shapes)
        return is_allowed(cls, None if is_ours else NO_EVOLUTION)


class _OverFrames(_OnEvolution):
    """Mix-in of operators that animate the evolution over a range of frames."""

    frame_start: bpy.props.IntProperty(
        name="From Frame", description="Frame that shows the mesh before the first step", default=1
    )
    frame_end: bpy.props.IntProperty(
        name="To Frame", description="Frame that shows the last step", default=100
    )

    def animate(self, context) -> bool:
        """Set the keyframes in place of earlier ones; False if the range of frames is invalid."""
        if self.frame_end <= self.frame_start:
            self.report({"ERROR"}, rpt_("The last frame must come after the first"))
            return False
        clear_animation(evolution_keys(context.active_object))
        animate_evolution(context.active_object, self.frame_start, self.frame_end)
        scene = context.scene
        scene.frame_end = max(scene.frame_end, self.frame_end)
        return True


class OBJECT_OT_adaptive_fairing_play(_OverFrames, bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_play"
    bl_label = "Play"
    bl_description = (
        "Play the evolution of the active object from its first frame. The first time it is put on "
        "the timeline and colored by the density"
    )
    bl_options = {"REGISTER"}  # what can be undone is pushed; starting and stopping cannot

    def execute(self, context):
        obj, scene = context.active_object, context.scene
        if animated_frames(obj) is None:
            if not self.animate(context):
                return {"CANCELLED"}
            _show_density(obj)
            if bpy.ops.ed.undo_push.poll():  # type: ignore[call-arg]  # the stubs want self
                bpy.ops.ed.undo_push(message="Animate")
        first, last = (round(frame) for frame in animated_frames(obj))
        scene.use_preview_range = True
        scene.frame_preview_start, scene.frame_preview_end = first, last
        scene.frame_set(first)
        if context.screen is not None and not context.screen.is_animation_playing:
            bpy.ops.screen.animation_play()
        return {"FINISHED"}


class OBJECT_OT_adaptive_fairing_play_end(bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_play_end"
    bl_label = "Stop Playing"
    bl_description = "Stop at the current frame, and play all frames of the scene again"
    bl_options = {"INTERNAL"}

    def execute(self, context):
        context.scene.use_preview_range = False
        if context.screen is not None and context.screen.is_animation_playing:
            bpy.ops.screen.animation_cancel(restore_frame=False)
        return {"FINISHED"}


class OBJECT_OT_adaptive_fairing_animate(_OverFrames, bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_animate"
    bl_label = "Animate"
    bl_description = "Let the timeline run through the evolution of the active object"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        if not self.animate(context):
            return {"CANCELLED"}
        context.scene.frame_set(context.scene.frame_current)
        return {"FINISHED"}


class OBJECT_OT_adaptive_fairing_animate_clear(_OnEvolution, bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_animate_clear"
    bl_label = "Clear Animation"
    bl_description = "Take the evolution of the active object off the timeline"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        clear_animation(evolution_keys(context.active_object))
        return {"FINISHED"}


def is_animated(obj: bpy.types.Object) -> bool:
    """Whether the shape keys of an object are animated."""
    animation = obj.data.shape_keys.animation_data
    return animation is not None and animation.action is not None


def _show_density(obj: bpy.types.Object) -> None:
    """Colour an object by the density, unless it already shows another field."""
    if not obj.adaptive_fairing.view and bpy.ops.object.adaptive_fairing_view.poll():
        bpy.ops.object.adaptive_fairing_view(field="DENSITY")


_CLASSES = (
    OBJECT_OT_adaptive_fairing_play,
    OBJECT_OT_adaptive_fairing_play_end,
    OBJECT_OT_adaptive_fairing_animate,
    OBJECT_OT_adaptive_fairing_animate_clear,
)
register, unregister = bpy.utils.register_classes_factory(_CLASSES)
