"""The panel that colours meshes by a field: buttons, legend, and the material for renders."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_iface as iface_

from ..data.record_properties import N_SWATCHES, swatch_name
from ..operators.view import (
    FIELDS,
    OBJECT_OT_adaptive_fairing_material,
    OBJECT_OT_adaptive_fairing_material_end,
    OBJECT_OT_adaptive_fairing_view,
    OBJECT_OT_adaptive_fairing_view_end,
)
from .layouts import FairingPanel, draw_lines, world_text

DENSITY_TITLES = {1: "Mean edge length at a vertex", 2: "Area of the triangles at a vertex"}
"""Name of the density's measure, by its power of a length."""


class VIEW3D_PT_adaptive_fairing_view(FairingPanel, bpy.types.Panel):
    bl_label = "Colors"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, obj = self.layout, context.active_object
        record = obj.adaptive_fairing if obj is not None and obj.type == "MESH" else None
        shown = record.view if record is not None else ""
        grid = layout.grid_flow(row_major=True, columns=2, even_columns=True, align=True)
        for field, *_ in FIELDS:
            draw_field_button(grid, field, shown)
        if shown:
            _draw_legend(context, layout, record)
        if record is not None and record.wants_material:
            end = OBJECT_OT_adaptive_fairing_material_end.bl_idname
            layout.operator(end, icon="MATERIAL", depress=True)
        else:
            layout.operator(OBJECT_OT_adaptive_fairing_material.bl_idname, icon="MATERIAL")


def draw_field_button(layout, field: str, shown: str) -> None:
    """Draw the button that colours by a field, or ends the colours if that field is shown."""
    title = next(iface_(title) for identifier, title, *_ in FIELDS if identifier == field)
    if field == shown:
        end = OBJECT_OT_adaptive_fairing_view_end.bl_idname
        layout.operator(end, text=title, depress=True)
    else:
        view = layout.operator(OBJECT_OT_adaptive_fairing_view.bl_idname, text=title)
        view.field = field


def _draw_legend(context, layout, record) -> None:
    """Draw the colours from high to low with their values; for the density, which end is dense."""
    low, high = record.view_range
    column = layout.box().column(align=True)
    ends = {}
    if record.view == "DENSITY":
        draw_lines(context, column, iface_(DENSITY_TITLES[record.view_power]), icon="NONE")
        ends = {N_SWATCHES - 1: iface_("coarse"), 0: iface_("dense")}
    for number in reversed(range(N_SWATCHES)):
        value = low + (high - low) * number / (N_SWATCHES - 1)
        split = column.split(factor=0.3)
        split.prop(record, swatch_name(number), text="")
        text = world_text(context, record, value, record.view_power)
        if number in ends:
            text += f"  {ends[number]}"
        split.label(text=text, translate=False)


register, unregister = bpy.utils.register_classes_factory((VIEW3D_PT_adaptive_fairing_view,))
