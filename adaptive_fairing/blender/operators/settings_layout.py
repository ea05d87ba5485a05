"""Layout of the settings of a run, for the redo panel of an operator and for the panels."""

from __future__ import annotations

from bpy.app.translations import pgettext_iface as iface_

from ..choices import DENOISE
from ..properties import has_width, names_of, uses_tau


def draw_operator(layout, operator, obj) -> None:
    """Draw the operator's properties for its algorithm, in the redo panel."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    draw_main(layout, operator)  # without the algorithm: the settings are those of one
    if operator.algorithm != DENOISE:
        draw_density(layout, operator)
        draw_accuracy(layout, operator)
    layout.separator()
    draw_options(layout, operator, obj)


def draw_main(layout, settings, live_record=None) -> None:
    """Draw the most important settings of an algorithm.

    On an object with a result of Denoise, the strength takes effect at once, see `live_record`.
    """
    if settings.algorithm == DENOISE:
        layout.prop(live_record or settings, "strength", slider=live_record is not None)
        row = layout.row()
        row.prop(settings, "width", slider=True)
        if not has_width(settings):
            row.label(text="Automatic")
        return
    draw_amount(layout, settings)
    layout.prop(settings, "keep_volume")


def draw_amount(layout, settings) -> None:
    """Draw the scheme of the paper, the amount of smoothing and the number of steps."""
    layout.prop(settings, "scheme")
    row = layout.row(align=True)
    row.prop(settings, "tau" if uses_tau(settings) else "radius")
    narrow = row.row(align=True)
    narrow.ui_units_x = 1.5
    narrow.prop(settings, "use_tau", text=iface_("τ"), toggle=True)
    layout.prop(settings, "steps")


def draw_options(layout, properties, obj) -> None:
    """Draw the region of a run, its start and the kind of its result."""
    if properties.algorithm == DENOISE:
        layout.prop(properties, "features")
        layout.prop(properties, "clean")
    draw_region(layout, properties, obj)
    if "max_deviation" in names_of(properties.algorithm):
        layout.prop(properties, "max_deviation")
    draw_output(layout, properties)


def draw_density(layout, properties) -> None:
    """Draw the settings of the density."""
    column = layout.column(align=True)
    column.active = properties.scheme != "UNIFORM"
    column.prop(properties, "density", text=iface_("Density"))
    column.prop(properties, "density_passes")


def draw_region(layout, properties, obj) -> None:
    """Draw the region of the smoothing."""
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
    """Draw the start of a run and the kind of its result."""
    column = layout.column()
    if properties.algorithm == DENOISE:
        column.prop(properties, "result")
        column.prop(properties, "store_density")
    else:
        column.prop(properties, "output")
    column.prop(properties, "from_original")
    column.prop(properties, "existing_keys")


def draw_accuracy(layout, properties) -> None:
    """Draw the stopping rules of the steps and the accuracy of their solves."""
    column = layout.column(align=True)
    column.prop(properties, "stop_curvature")
    column.prop(properties, "stop_rate")
    column = layout.column(align=True)
    column.prop(properties, "cg_tolerance")
    column.prop(properties, "cg_max_iterations")
    column.prop(properties, "quadrature_tolerance")
    layout.prop(properties, "normalize")
