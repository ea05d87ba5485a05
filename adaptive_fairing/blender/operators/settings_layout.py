"""The settings of a run in a layout: for the redo panel of an operator, and for the panels."""

from __future__ import annotations

from bpy.app.translations import pgettext_iface as iface_

from ..properties import AUTO


def draw_operator(layout, operator, obj) -> None:
    """Draw all properties of the operator, for the redo panel."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    draw_method(layout.column(), operator)
    parts = [draw_output] if operator.method == AUTO else [draw_density, draw_output, draw_accuracy]
    for draw_part in parts:
        layout.separator()
        draw_part(layout, operator)
    layout.separator()
    draw_region(layout, operator, obj)


def draw_method(layout, properties) -> None:
    """Draw the method and what it needs to know."""
    layout.prop(properties, "method")
    names = ("strength", "features") if properties.method == AUTO else ("tau", "steps")
    for name in names:
        layout.prop(properties, name)


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


def draw_output(layout, properties) -> None:
    """Draw what becomes of the result."""
    column = layout.column()
    column.prop(properties, "output")
    column.prop(properties, "existing_keys")
    column.prop(properties, "store_density")


def draw_accuracy(layout, properties) -> None:
    """Draw when the paper's methods stop and how exactly they solve."""
    column = layout.column(align=True)
    column.prop(properties, "stop_curvature", text=iface_("Stop at Curvature"))
    column.prop(properties, "stop_rate", text=iface_("Stop at Rate"))
    column = layout.column(align=True)
    column.prop(properties, "cg_tolerance")
    column.prop(properties, "cg_max_iterations", text=iface_("Iterations"))
    column.prop(properties, "quadrature_tolerance", text=iface_("Integration"))
    layout.prop(properties, "normalize")
