"""The operator that measures what τ and the radius mean on the active mesh."""

from __future__ import annotations

import bpy

from ..requirements import scipy_problem
from . import mesh_scale
from .polls import is_allowed, no_active_mesh_refusal


class OBJECT_OT_adaptive_fairing_measure(bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_measure"
    bl_label = "Measure Mesh"
    bl_description = "Find out what τ and the radius mean on the active mesh"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context):
        problem = scipy_problem() or no_active_mesh_refusal(context)
        if problem is None and context.active_object.mode == "EDIT":
            problem = "Leave Edit Mode to measure the mesh"
        return is_allowed(cls, problem)

    def execute(self, context):
        scale = mesh_scale.measure(context.active_object, context.scene.adaptive_fairing)
        if isinstance(scale, str):
            self.report({"ERROR"}, scale)
            return {"CANCELLED"}
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((OBJECT_OT_adaptive_fairing_measure,))
