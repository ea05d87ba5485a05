"""Panel for fairing an animated object frame by frame."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_iface as iface_

from ..operators import modal_run
from ..operators.fair import run_label
from ..operators.sequence import OBJECT_OT_adaptive_fairing_sequence
from ..properties import copy_settings, copy_solver
from .layouts import FairingPanel


class VIEW3D_PT_adaptive_fairing_sequence(FairingPanel, bpy.types.Panel):
    bl_label = "Frame Sequence"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        scene = context.scene
        settings = scene.adaptive_fairing
        current = modal_run.progress()
        column = layout.column()
        column.active = current is None
        row = column.row(align=True)
        row.prop(scene, "frame_start", text=iface_("Start"))
        row.prop(scene, "frame_end", text=iface_("End"))
        column.prop(settings, "same_strength")
        row = layout.row()
        row.scale_y = 1.3
        if current is not None:
            # A button that is greyed out under the pointer would stay so after the run.
            row.enabled = not current.worker.is_stopping
            text = iface_("Stop, Keep Frames")
            row.operator("object.adaptive_fairing_stop", text=text, icon="CANCEL")
            return
        n_frames = max(scene.frame_end - scene.frame_start + 1, 0)
        operator = row.operator(
            OBJECT_OT_adaptive_fairing_sequence.bl_idname,
            text=iface_("{:s} {:d} Frames").format(run_label(settings.algorithm), n_frames),
            icon="RENDER_ANIMATION",
        )
        copy_solver(settings, operator)
        operator.same_strength = settings.same_strength
        copy_settings(scene, operator, ("frame_start", "frame_end"))


register, unregister = bpy.utils.register_classes_factory((VIEW3D_PT_adaptive_fairing_sequence,))
