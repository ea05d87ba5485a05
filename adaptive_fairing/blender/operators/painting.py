"""Painting the original back: a faint overlay, and a key that swaps the weights 0 and 1.

Blender's overlay of weights is opaque and would hide the surface that the user judges.  It is faint
during painting.  After that the earlier opacity comes back, except in views that were changed.
"""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ..compatibility import weight_paint_settings
from ..data.paint_group import PAINT_GROUP
from . import viewport
from .polls import is_allowed

FAINT = 0.25
"""Opacity of the overlay while the user paints back."""

_before: dict[int, float] = {}  # opacity by the address of a view


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


_register_class, _unregister_class = bpy.utils.register_classes_factory(
    (OBJECT_OT_adaptive_fairing_paint_swap,)
)


def register() -> None:
    """Register the operator, and a handler for the end of painting."""
    _register_class()
    bpy.app.handlers.depsgraph_update_post.append(_follow_mode)
    bpy.app.handlers.load_pre.append(_leave_file)


def unregister() -> None:
    """Unregister both, and restore the views."""
    bpy.app.handlers.load_pre.remove(_leave_file)
    bpy.app.handlers.depsgraph_update_post.remove(_follow_mode)
    put_back()
    _unregister_class()
