"""Operators that render the colours of a field, and that restore the materials."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ..data.object_mode import undoable_object_mode
from ..data.regions import refusal, target_objects
from ..properties import fairing_settings
from ..requirements import scipy_problem
from . import viewport
from .polls import is_allowed


class OBJECT_OT_adaptive_fairing_material(bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_material"
    bl_label = "Render Colors"
    bl_description = (
        "Render the selected meshes in the colors that they show, or in those of the density: a "
        "material takes the place of theirs on the objects, until it is removed or the colors are "
        "hidden. The materials of the meshes stay where they are"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return is_allowed(cls, scipy_problem(), refusal(context))

    def execute(self, context):
        from ...core import FairingError
        from ..data.coloring import color_by_field

        try:
            settings = fairing_settings(context.scene.adaptive_fairing)
        except FairingError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        objects = target_objects(context)
        n_replaced, n_done = 0, 0
        with undoable_object_mode(context):
            for obj in objects:
                record = obj.adaptive_fairing
                n_materials = sum(slot.material is not None for slot in obj.material_slots)
                is_new, record.wants_material = not record.wants_material, True
                try:
                    color_by_field(obj, record.view or "DENSITY", settings)
                except FairingError as error:
                    record.wants_material = not is_new
                    self.report({"WARNING"}, f"{obj.name}: {error}")
                    continue
                n_done += 1
                n_replaced += n_materials if is_new else 0
        viewport.show()
        if n_replaced:
            text = rpt_("{:d} materials are hidden; Restore Materials shows them again")
            self.report({"INFO"}, text.format(n_replaced))
        return {"FINISHED"} if n_done else {"CANCELLED"}


class OBJECT_OT_adaptive_fairing_material_end(bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_material_end"
    bl_label = "Restore Materials"
    bl_description = (
        "Give the selected meshes back the materials that they had before Render Colors"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return is_allowed(cls, refusal(context))

    def execute(self, context):
        from ..data import color_material

        objects = [obj for obj in target_objects(context) if obj.adaptive_fairing.wants_material]
        with undoable_object_mode(context):
            for obj in objects:
                color_material.take_off(obj)
                obj.adaptive_fairing.wants_material = False
        return {"FINISHED"} if objects else {"CANCELLED"}


register, unregister = bpy.utils.register_classes_factory(
    (OBJECT_OT_adaptive_fairing_material, OBJECT_OT_adaptive_fairing_material_end)
)
