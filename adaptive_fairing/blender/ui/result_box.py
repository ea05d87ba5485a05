"""Result below the main button: its sliders and its operators."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_iface as iface_

from ..choices import DENOISE
from ..compatibility import weight_paint_settings
from ..data.display import display_of
from ..data.earlier_files import has_earlier_keys
from ..data.results import is_of_strengths, result_measures
from ..operators.animate import (
    OBJECT_OT_adaptive_fairing_play,
    OBJECT_OT_adaptive_fairing_play_end,
)
from ..operators.painting import (
    OBJECT_OT_adaptive_fairing_paint,
    OBJECT_OT_adaptive_fairing_paint_swap,
)
from ..operators.results import (
    OBJECT_OT_adaptive_fairing_apply,
    OBJECT_OT_adaptive_fairing_before,
    OBJECT_OT_adaptive_fairing_discard,
    OBJECT_OT_adaptive_fairing_forget,
    OBJECT_OT_adaptive_fairing_split,
    OBJECT_OT_adaptive_fairing_surface,
    OBJECT_OT_adaptive_fairing_take_keys,
    result_objects,
    surface_name,
)
from ..properties import copy_settings
from .colors_panel import draw_field_button
from .finished_run_panels import active_record, change_text, draw_energies
from .layouts import draw_lines, world_length_text

LARGEST_RADIUS = 100
"""Radius in edges from which on it says only that nothing of the vertices' own noise is kept."""


def live_record(context: bpy.types.Context) -> bpy.types.PropertyGroup | None:
    """Record of the active object, if it has a slider for its strength."""
    record = active_record(context)
    if record is None:
        return None
    display = display_of(record.id_data)
    return record if display.slider == "strength" and display.is_whole else None


def draw_result(context: bpy.types.Context, layout) -> None:
    """Draw the slider, one line of numbers, and the buttons."""
    obj = context.active_object
    if obj is not None and obj.type == "MESH" and has_earlier_keys(obj):
        text = iface_("The shape keys are of a run by an earlier version")
        draw_lines(context, layout, text, icon="INFO")
        layout.operator(OBJECT_OT_adaptive_fairing_take_keys.bl_idname, icon="CHECKMARK")
        return
    record = active_record(context)
    if record is None or not record.result or obj.use_dynamic_topology_sculpting:
        return
    display = display_of(obj)
    column = layout.column()
    if not display.is_whole:
        text = iface_(
            "The mesh was changed since the last run. The next one starts from what is shown"
        )
        draw_lines(context, column, text, icon="INFO")
        row = column.row(align=True)
        row.operator(OBJECT_OT_adaptive_fairing_forget.bl_idname, icon="CHECKMARK")
        row.operator(OBJECT_OT_adaptive_fairing_discard.bl_idname, icon="X")
        return
    elif not display.goes_on:
        text = iface_(
            "The mesh was changed since the last run. The slider moves what was not touched"
        )
        draw_lines(context, column, text, icon="INFO")
    if display.slider != "strength" or context.scene.adaptive_fairing.algorithm != DENOISE:
        _draw_slider(context, column, display)
    draw_lines(context, column, result_text(context, record), icon="NONE")
    row = column.row(align=True)
    row.operator(OBJECT_OT_adaptive_fairing_before.bl_idname, depress=record.is_before)
    row.operator(OBJECT_OT_adaptive_fairing_split.bl_idname, depress=record.is_split)
    if display.has_weights:
        text = iface_("Mask Back") if obj.mode == "SCULPT" else iface_("Paint Back")
        is_painting = obj.mode == "WEIGHT_PAINT"
        paint = OBJECT_OT_adaptive_fairing_paint.bl_idname
        row.operator(paint, text=text, depress=is_painting)
        if is_painting:
            _draw_painted(context, column)
    split = column.split(factor=0.35)
    split.label(text="Surface")
    name = OBJECT_OT_adaptive_fairing_surface.bl_idname
    split.operator_menu_enum(name, "surface", text=iface_(surface_name(record)))
    _draw_ends(context, column)


def _draw_painted(context, column) -> None:
    """Draw a button that says what painting brings back, and swaps it."""
    brings_result = weight_paint_settings(context).weight > 0.5
    text = iface_("Painting: Result (1)") if brings_result else iface_("Painting: Original (0)")
    swap = OBJECT_OT_adaptive_fairing_paint_swap.bl_idname
    column.operator(swap, text=text, icon="ARROW_LEFTRIGHT")


def _draw_ends(context, column) -> None:
    """Draw the buttons that end results, with the number of objects."""
    n_objects = len(result_objects(context))
    buttons = column.row(align=True) if n_objects == 1 else column.column(align=True)
    for operator, icon in (
        (OBJECT_OT_adaptive_fairing_apply, "CHECKMARK"),
        (OBJECT_OT_adaptive_fairing_discard, "X"),
    ):
        text = iface_(operator.bl_label)
        if n_objects > 1:
            text = iface_("{:s} {:d} Objects").format(text, n_objects)
        buttons.operator(operator.bl_idname, text=text, icon=icon)
    if len({each.data for each in result_objects(context)}) > 1:
        hint = iface_("Hold Alt while you move a slider to move it on all selected objects")
        draw_lines(context, column, hint, icon="INFO")


def _draw_slider(context, column, display) -> None:
    """Draw the slider of the result and, for an evolution, what belongs to it."""
    if not display.slider:
        return
    record = display.obj.adaptive_fairing
    row = column.row()
    row.scale_y = 1.3
    row.prop(record, display.slider, slider=True)
    if display.slider == "evolution":
        n_steps = len(record.shapes) - 1
        shown = iface_("Step {:.1f} of {:d}").format(display.place, n_steps)
        column.label(text=shown, translate=False)
        _draw_evolution(context, column, record)


def _draw_evolution(context, column, record) -> None:
    """Draw the buttons that play an evolution, colour it and plot its energy H."""
    settings = context.scene.adaptive_fairing
    row = column.row(align=True)
    if context.screen is not None and context.screen.is_animation_playing:
        end = OBJECT_OT_adaptive_fairing_play_end.bl_idname
        row.operator(end, text=iface_("Stop"), icon="PAUSE", depress=True)
    else:
        play = row.operator(OBJECT_OT_adaptive_fairing_play.bl_idname, icon="PLAY")
        copy_settings(settings, play, ("frame_start", "frame_end"))
    draw_field_button(row, "DENSITY", record.view)
    narrow = row.row(align=True)
    narrow.ui_units_x = 1.5
    narrow.prop(settings, "show_energy", toggle=True)
    if settings.show_energy:
        draw_energies(column, record)


def result_text(context: bpy.types.Context, record: bpy.types.PropertyGroup) -> str:
    """Line of text with the findings of a run and its effect."""
    first, last = record.shapes[0], result_measures(record)
    parts = []
    if is_of_strengths(record):
        length = world_length_text(context, record, record.noise_length)
        parts.append(iface_("Noise {:s}").format(length))
        if record.radius < LARGEST_RADIUS:
            parts.append(iface_("smoothed {:.2g} edges").format(record.radius))
    else:
        parts.append(iface_("{:d} steps").format(len(record.shapes) - 1))
    volume = change_text(first.volume, last.volume)
    if volume != "–":
        parts.append(iface_("volume {:s}").format(volume))
    # Lines break between the parts, not within them.
    return " · ".join(part.replace(" ", "\N{NO-BREAK SPACE}") for part in parts)
