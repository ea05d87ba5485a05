"""The settings of a run in a layout: for the redo panel of an operator, and for the panels."""

from __future__ import annotations

from bpy.app.translations import pgettext_iface as iface_

from ..choices import AUTO
from ..properties import CONTEXT
from .tau import OBJECT_OT_adaptive_fairing_suggest_tau


def draw_operator(layout, operator, obj) -> None:
    """Draw all properties of the operator that its method has, for the redo panel."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    layout.prop(operator, "method")
    if operator.method == AUTO:
        layout.prop(operator, "strength")
    else:
        layout.prop(operator, "tau")
        layout.prop(operator, "steps")
        draw_density(layout, operator)
        draw_accuracy(layout, operator)
    layout.separator()
    draw_options(layout, operator, obj)


def draw_method(layout, settings, live_record=None) -> None:
    """Draw the method and what decides most: the strength, or the radius and the steps.

    An object that has a result of Denoise is changed by the strength at once: `live_record`.
    """
    layout.prop(settings, "method")
    if settings.method == AUTO:
        row = layout.row()
        row.enabled = live_record is None or live_record.id_data.mode != "EDIT"
        row.prop(live_record or settings, "strength", slider=live_record is not None)
        return
    row = layout.row(align=True)
    row.prop(settings, "radius")
    row.operator(OBJECT_OT_adaptive_fairing_suggest_tau.bl_idname, text="", icon="CHECKMARK")
    layout.prop(settings, "steps")


def draw_options(layout, properties, obj) -> None:
    """Draw where a run works, what it starts from, and what becomes of the result."""
    if properties.method == AUTO:
        layout.prop(properties, "features")
        layout.prop(properties, "clean")
    draw_region(layout, properties, obj)
    draw_output(layout, properties)


def draw_density(layout, properties) -> None:
    """Draw how the density is measured."""
    column = layout.column()
    column.active = properties.method != "uniform"
    column.prop(properties, "density")
    column.prop(properties, "density_passes")


def draw_region(layout, properties, obj) -> None:
    """Draw where the smoothing works."""
    layout.prop(properties, "use_region")
    row = layout.row(align=True)
    if obj is not None and obj.type == "MESH":
        row.prop_search(properties, "vertex_group", obj, "vertex_groups")
    else:
        row.prop(properties, "vertex_group")
    row.prop(properties, "invert_vertex_group", text="", icon="ARROW_LEFTRIGHT")
    layout.prop(properties, "boundary")
    layout.prop(properties, "hold_sharp")


def draw_output(layout, properties) -> None:
    """Draw what a run starts from and what becomes of the result."""
    column = layout.column()
    if properties.method == AUTO:
        column.prop(properties, "result")
        column.prop(properties, "store_density")
    else:
        column.prop(properties, "output")
    column.prop(properties, "from_original")
    column.prop(properties, "existing_keys")


def draw_accuracy(layout, properties) -> None:
    """Draw when the paper's methods stop and how exactly they solve."""
    column = layout.column(align=True)
    column.prop(properties, "stop_curvature", text=iface_("Stop at Curvature"))
    column.prop(properties, "stop_rate", text=iface_("Stop at Rate"))
    column = layout.column(align=True)
    column.prop(properties, "cg_tolerance")
    column.prop(properties, "cg_max_iterations", text=iface_("Iterations", CONTEXT))
    column.prop(properties, "quadrature_tolerance", text=iface_("Integration"))
    layout.prop(properties, "normalize")
