"""Painting the original back, with a faint overlay and a key that swaps the weights 0 and 1.

Blender's overlay of weights is opaque and would hide the surface that the user judges.  It is faint
during painting.  After that the earlier opacity comes back, except in views that were changed.
"""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ..compatibility import weight_paint_settings
from ..data.display import display_of
from ..data.object_mode import undoable_object_mode
from ..data.regions import SCULPT_MASK, sculpt_mask
from ..data.results import follow_weights
from ..data.vertex_groups import PAINT_GROUP, add_weights
from . import viewport
from .polls import busy_refusal, is_allowed
from .results import result_refusal

FAINT = 0.25
"""Opacity of the overlay while the user paints back."""

_before: dict[int, float] = {}  # opacity by the address of a view


class OBJECT_OT_adaptive_fairing_paint(bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_paint"
    bl_label = "Paint Back"
    bl_description = (
        "Change to Weight Paint with the vertex group Fairing: weight 0 brings the original back, "
        "1 shows the result; once more leaves it. In Sculpt Mode bring the original back where the "
        "mask is"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        refusal = result_refusal(context)
        if refusal is None and not display_of(context.active_object).has_weights:
            refusal = "Shape keys have no weights to paint: use the result Live or Modifier"
        elif refusal is None and _lacks_mask(context.active_object):
            refusal = "Mask where the original is to come back"
        return is_allowed(cls, refusal, busy_refusal())

    def execute(self, context):
        obj = context.active_object
        if obj.mode == "SCULPT":
            return self._take_mask(context, obj)
        if obj.mode == "WEIGHT_PAINT":
            bpy.ops.object.mode_set(mode="OBJECT")
            return {"FINISHED"}
        if obj.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        display_of(obj).paint_group()
        bpy.ops.object.mode_set(mode="WEIGHT_PAINT")
        settings = weight_paint_settings(context)
        settings.use_unified_weight, settings.weight = True, 0.0  # of every brush
        make_faint()
        self.report({"INFO"}, rpt_("Paint to bring the original back; X swaps the weights 0 and 1"))
        return {"FINISHED"}

    def _take_mask(self, context, obj):
        with undoable_object_mode(context):
            mask = sculpt_mask(obj.data)
            if mask is None or not mask.any():
                self.report({"ERROR"}, rpt_("Mask where the original is to come back"))
                return {"CANCELLED"}
            add_weights(display_of(obj).paint_group(), range(len(mask)), 1 - mask)
            follow_weights(obj)
        return {"FINISHED"}


class OBJECT_OT_adaptive_fairing_paint_swap(bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_paint_swap"
    bl_label = "Swap 0 and 1"
    bl_description = (
        "Change between painting the original back, with weight 0, and the result, with weight 1"
    )

    @classmethod
    def poll(cls, context):
        reason = None if is_painting(context) else "Only while you paint the vertex group Fairing"
        return is_allowed(cls, reason)

    def execute(self, context):
        settings = weight_paint_settings(context)
        settings.use_unified_weight = True
        settings.weight = 0.0 if settings.weight > 0.5 else 1.0
        brings_result = settings.weight > 0.5
        self.report(
            {"INFO"},
            rpt_("Painting brings the result back")
            if brings_result
            else rpt_("Painting brings the original back"),
        )
        return {"FINISHED"}


def _lacks_mask(obj: bpy.types.Object) -> bool:
    """Whether an object in Sculpt Mode has never had a mask."""
    return obj.mode == "SCULPT" and SCULPT_MASK not in obj.data.attributes


def is_painting(context: bpy.types.Context) -> bool:
    """Whether the original of a result is being painted back."""
    obj = context.view_layer.objects.active
    if obj is None or obj.mode != "WEIGHT_PAINT" or not obj.adaptive_fairing.result:
        return False
    active = obj.vertex_groups.active
    return active is not None and active.name == PAINT_GROUP


def make_faint() -> None:
    """Make the overlay of weights faint."""
    for address, space in viewport.views():
        _before.setdefault(address, space.overlay.weight_paint_mode_opacity)
        space.overlay.weight_paint_mode_opacity = FAINT


def put_back() -> None:
    """Restore the opacity of the overlay where nobody has changed it."""
    for address, space in viewport.views():
        is_ours = abs(space.overlay.weight_paint_mode_opacity - FAINT) < 1e-6
        if address in _before and is_ours:
            space.overlay.weight_paint_mode_opacity = _before[address]
    _before.clear()


@bpy.app.handlers.persistent
def _follow_mode(*_arguments) -> None:
    """Restore the overlay once painting has ended, however the mode was left."""
    if _before and not is_painting(bpy.context):
        put_back()


@bpy.app.handlers.persistent
def _leave_file(*_arguments) -> None:
    put_back()


_register_classes, _unregister_classes = bpy.utils.register_classes_factory(
    (OBJECT_OT_adaptive_fairing_paint, OBJECT_OT_adaptive_fairing_paint_swap)
)


def register() -> None:
    """Register the operators, and a handler for the end of painting."""
    _register_classes()
    bpy.app.handlers.depsgraph_update_post.append(_follow_mode)
    bpy.app.handlers.load_pre.append(_leave_file)


def unregister() -> None:
    """Unregister both, and restore the views."""
    bpy.app.handlers.load_pre.remove(_leave_file)
    bpy.app.handlers.depsgraph_update_post.remove(_follow_mode)
    put_back()
    _unregister_classes()
