"""Operators around the meaning of τ: measure the mesh, and set τ from a wanted radius."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ..requirements import scipy_problem
from . import mesh_scale
from .object_mode import object_mode
from .polls import is_allowed, no_active_mesh_refusal


class _OnActiveMesh:
    """Mix-in: works on the active mesh object."""

    @classmethod
    def poll(cls, context):
        return is_allowed(cls, scipy_problem(), no_active_mesh_refusal(context))

    def measured(self, context):
        """Measure the active mesh; report and give None if that is not possible."""
        with object_mode(context):
            scale = mesh_scale.measure(context.active_object, context.scene.adaptive_fairing)
        if isinstance(scale, str):
            self.report({"ERROR"}, scale)
            return None
        return scale


class OBJECT_OT_adaptive_fairing_measure(_OnActiveMesh, bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_measure"
    bl_label = "Measure Mesh"
    bl_description = "Find out what τ means on the active mesh, anew if it was known"
    bl_options = {"INTERNAL"}

    def execute(self, context):
        return {"CANCELLED"} if self.measured(context) is None else {"FINISHED"}


class OBJECT_OT_adaptive_fairing_suggest_tau(_OnActiveMesh, bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_suggest_tau"
    bl_label = "Suggest τ"
    bl_description = (
        "Set τ so that all steps together smooth over the wanted radius in a typical part of the "
        "active mesh"
    )
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        from ...core.diffusion.smoothing_radius import suggest_tau

        settings = context.scene.adaptive_fairing
        scale = mesh_scale.known_scale(context.active_object, settings)
        if scale is None or isinstance(scale, str):
            scale = self.measured(context)
        if scale is None:
            return {"CANCELLED"}
        settings.tau = suggest_tau(scale, settings.radius, settings.steps)
        self.report({"INFO"}, rpt_("τ = {:.4g}").format(settings.tau))
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory(
    (OBJECT_OT_adaptive_fairing_measure, OBJECT_OT_adaptive_fairing_suggest_tau)
)
