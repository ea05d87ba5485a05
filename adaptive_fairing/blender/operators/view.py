"""Operators that colour meshes by density, displacement, curvature …, in views and in renders."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_rpt as rpt_
from bpy.app.translations import pgettext_tip as tip_

from ..data.coloring import color_by_field, end_view, take_material_off
from ..data.object_mode import undoable_object_mode
from ..data.regions import refusal, target_objects
from ..properties import fairing_settings
from ..requirements import scipy_problem
from . import viewport
from .polls import is_allowed

FIELDS = (
    (
        "DENSITY",
        "Density",
        "How dense the mesh is: dark where it is dense, bright where it is coarse and the adaptive "
        "methods smooth more",
    ),
    ("DISPLACEMENT", "Displacement", "How far the smoothing has moved each vertex"),
    (
        "CURVATURE",
        "Mean Curvature",
        "Mean curvature of the limit surface: red where it bulges outward, blue where inward",
    ),
    (
        "GAUSSIAN",
        "Gaussian Curvature",
        "Gaussian curvature of the limit surface: red on bumps and in bowls, blue on saddles, "
        "near white where it bends in one direction only",
    ),
    (
        "REMOVED",
        "Removed",
        "What the smoothing has removed, along the normals: red where it took a bump off, blue "
        "where it filled a dent; noise looks random, a shape that shows here was smoothed away",
    ),
)


class _OnFields:
    """Mix-in of operators that colour the objects to work on."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return is_allowed(cls, scipy_problem(), refusal(context))

    def color(self, context, color):
        """Call a function for every object, with settings; return whether it worked for any."""
        from ...core import FairingError

        try:
            settings = fairing_settings(context.scene.adaptive_fairing)
        except FairingError as error:
            self.report({"ERROR"}, str(error))
            return False
        is_done = False
        with undoable_object_mode(context):
            for obj in target_objects(context):
                try:
                    color(obj, settings)
                    is_done = True
                except FairingError as error:
                    self.report({"WARNING"}, f"{obj.name}: {error}")
        return is_done


class OBJECT_OT_adaptive_fairing_view(_OnFields, bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_view"
    bl_label = "Show Fairing Field"
    bl_description = (
        "Color the selected meshes, as they are shown now, by a field. Its colors are the active "
        "ones until it is hidden; then everything is as it was before"
    )

    field: bpy.props.EnumProperty(
        name="Field",
        description="What the colors mean",
        items=FIELDS,
        default="DENSITY",
    )

    @classmethod
    def description(cls, context, properties):
        texts = {identifier: text for identifier, _, text in FIELDS}
        return tip_(texts[properties.field])

    def execute(self, context):
        objects = target_objects(context)

        def color(obj, settings):
            record = obj.adaptive_fairing
            record.wants_material = record.wants_material and bool(record.view)
            color_by_field(obj, self.field, settings)

        is_done = self.color(context, color)
        # A view that renders shows the colours by itself.
        is_rendered = all(obj.adaptive_fairing.wants_material for obj in objects)
        viewport.show(None if is_rendered else _asked_view(context))
        return {"FINISHED"} if is_done else {"CANCELLED"}


class OBJECT_OT_adaptive_fairing_view_end(bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_view_end"
    bl_label = "Hide Colors"
    bl_description = "Remove the colors of the view, and the numbers behind them, from all objects"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        with undoable_object_mode(context):
            for obj in bpy.data.objects:
                if obj.type == "MESH" and obj.adaptive_fairing.view and obj.data.library is None:
                    end_view(obj)
        viewport.end_without_fields()
        return {"FINISHED"}


class OBJECT_OT_adaptive_fairing_material(_OnFields, bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_material"
    bl_label = "Render Colors"
    bl_description = (
        "Render the selected meshes in the colors that they show, or in those of the density: a "
        "material takes the place of theirs on the objects, until it is removed or the colors are "
        "hidden. The materials of the meshes stay where they are"
    )

    def execute(self, context):
        n_replaced = 0

        def color(obj, settings):
            nonlocal n_replaced
            record, was_wanted = obj.adaptive_fairing, obj.adaptive_fairing.wants_material
            n_materials = sum(slot.material is not None for slot in obj.material_slots)
            record.wants_material = True
            try:
                color_by_field(obj, record.view or "DENSITY", settings)
            except Exception:
                record.wants_material = was_wanted
                raise
            n_replaced += 0 if was_wanted else n_materials

        is_done = self.color(context, color)
        viewport.show()
        if n_replaced:
            text = rpt_("{:d} materials are hidden; Restore Materials shows them again")
            self.report({"INFO"}, text.format(n_replaced))
        return {"FINISHED"} if is_done else {"CANCELLED"}


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
        objects = [obj for obj in target_objects(context) if obj.adaptive_fairing.wants_material]
        with undoable_object_mode(context):
            for obj in objects:
                take_material_off(obj)
                obj.adaptive_fairing.wants_material = False
        return {"FINISHED"} if objects else {"CANCELLED"}


def _asked_view(context: bpy.types.Context) -> bpy.types.SpaceView3D | None:
    """Find the 3D view whose button was pressed; None for a script."""
    space = context.space_data
    return space if isinstance(space, bpy.types.SpaceView3D) else None


register, unregister = bpy.utils.register_classes_factory(
    (
        OBJECT_OT_adaptive_fairing_view,
        OBJECT_OT_adaptive_fairing_view_end,
        OBJECT_OT_adaptive_fairing_material,
        OBJECT_OT_adaptive_fairing_material_end,
    )
)
