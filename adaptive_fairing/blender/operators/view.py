"""Operators that colour meshes by density, displacement, curvature …, and hide the colours."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_tip as tip_

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


class OBJECT_OT_adaptive_fairing_view(bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_view"
    bl_label = "Show Fairing Field"
    bl_description = (
        "Color the selected meshes, as they are shown now, by a field. Its colors are the active "
        "ones until it is hidden; then everything is as it was before"
    )
    bl_options = {"REGISTER", "UNDO"}

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

    @classmethod
    def poll(cls, context):
        return is_allowed(cls, scipy_problem(), refusal(context))

    def execute(self, context):
        from ...core import FairingError
        from ..data.coloring import color_by_field

        objects = target_objects(context)
        try:
            settings = fairing_settings(context.scene.adaptive_fairing)
        except FairingError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        shown = 0
        with undoable_object_mode(context):
            for obj in objects:
                record = obj.adaptive_fairing
                record.wants_material = record.wants_material and bool(record.view)
                try:
                    color_by_field(obj, self.field, settings)
                    shown += 1
                except FairingError as error:
                    self.report({"WARNING"}, f"{obj.name}: {error}")
        # A view that renders shows the colours by itself.
        is_rendered = all(obj.adaptive_fairing.wants_material for obj in objects)
        viewport.show(None if is_rendered else _asked_view(context))
        return {"FINISHED"} if shown else {"CANCELLED"}


class OBJECT_OT_adaptive_fairing_view_end(bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_view_end"
    bl_label = "Hide Colors"
    bl_description = "Remove the colors of the view, and the numbers behind them, from all objects"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        from ..data.coloring import end_view

        with undoable_object_mode(context):
            for obj in bpy.data.objects:
                if obj.type == "MESH" and obj.adaptive_fairing.view and obj.data.library is None:
                    end_view(obj)
        viewport.end_without_fields()
        return {"FINISHED"}


def _asked_view(context: bpy.types.Context) -> bpy.types.SpaceView3D | None:
    """Find the 3D view whose button was pressed; None for a script."""
    space = context.space_data
    return space if isinstance(space, bpy.types.SpaceView3D) else None


register, unregister = bpy.utils.register_classes_factory(
    (OBJECT_OT_adaptive_fairing_view, OBJECT_OT_adaptive_fairing_view_end)
)
