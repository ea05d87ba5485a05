"""Panel for fairing an animated object frame by frame."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_iface as iface_

from . import modal_run
from .operator_sequence import OBJECT_OT_adaptive_fairing_sequence
from .panel_settings import FairingPanel
from .properties import SOLVER_NAMES, copy_settings


class VIEW3D_PT_adaptive_fairing_sequence(FairingPanel, bpy.types.Panel):
    bl_label = "Frame Sequence"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        scene = context.scene
        settings = scene.adaptive_fairing
        layout.active = modal_run.progress() is None
        row = layout.row(align=True)
        row.prop(scene, "frame_start", text=iface_("Start"))
        row.prop(scene, "frame_end", text=iface_("End"))
        layout.prop(settings, "same_strength")
        row = layout.row()
        row.scale_y = 1.3
        n_frames = max(scene.frame_end - scene.frame_start + 1, 0)
        operator = row.operator(
            OBJECT_OT_adaptive_fairing_sequence.bl_idname,
            text=iface_("Fair {:d} Frames").format(n_frames),
            icon="RENDER_ANIMATION",
        )
        copy_settings(settings, operator, (*SOLVER_NAMES, "same_strength"))
        copy_settings(scene, operator, ("frame_start", "frame_end"))


register, unregister = bpy.utils.register_classes_factory((VIEW3D_PT_adaptive_fairing_sequence,))
