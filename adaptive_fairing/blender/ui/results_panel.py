"""Panels for what a run has done: evolution, measures, the course of H; colours; comparison."""

from __future__ import annotations

import math

import bpy
from bpy.app.translations import pgettext_iface as iface_

from ..data.color_map import SIGNED_FIELDS
from ..data.run_record import evolution_keys, is_of_strengths, result_measures, shown_strength
from ..operators.animate import (
    OBJECT_OT_adaptive_fairing_animate,
    OBJECT_OT_adaptive_fairing_animate_clear,
    is_animated,
)
from ..operators.compare import OBJECT_OT_adaptive_fairing_compare
from ..operators.select_problems import OBJECT_OT_adaptive_fairing_select_problems
from ..operators.view import (
    FIELDS,
    OBJECT_OT_adaptive_fairing_view,
    OBJECT_OT_adaptive_fairing_view_end,
)
from ..properties import copy_settings, copy_solver
from . import pictures
from .layouts import draw_lines, length_text
from .settings_panel import FairingPanel

STOP_REASONS = {
    "steps": "All steps done",
    "curvature": "Curvature low enough",
    "rate": "Hardly any change left",
    "stopped": "Stopped by hand",
}


class VIEW3D_PT_adaptive_fairing_results(FairingPanel, bpy.types.Panel):
    bl_label = "Results"

    @classmethod
    def poll(cls, context):
        obj = context.active_object
        return obj is not None and obj.type == "MESH" and bool(obj.adaptive_fairing.shapes)

    def draw(self, context):
        layout = self.layout
        obj = context.active_object
        record = obj.adaptive_fairing
        if evolution_keys(obj) is not None:
            _draw_evolution(context, layout, obj)
        if is_of_strengths(record):
            _draw_estimate(context, layout, record)
        _draw_course(layout, record)
        _draw_measures(context, layout, record)
        for note in record.notes.splitlines():
            draw_lines(context, layout, note, icon="INFO")
        if record.notes:
            layout.operator(OBJECT_OT_adaptive_fairing_select_problems.bl_idname)


class VIEW3D_PT_adaptive_fairing_view(FairingPanel, bpy.types.Panel):
    bl_label = "Colors"

    def draw(self, context):
        layout = self.layout
        obj = context.active_object
        shown = obj.adaptive_fairing.view if obj is not None else ""
        grid = layout.grid_flow(row_major=True, columns=2, even_columns=True, align=True)
        for field, title, _ in FIELDS:
            button = grid.operator(
                OBJECT_OT_adaptive_fairing_view.bl_idname,
                text=iface_(title),
                depress=shown == field,
            )
            button.field = field
        if shown:
            _draw_legend(layout, obj.adaptive_fairing)
        layout.operator(OBJECT_OT_adaptive_fairing_view_end.bl_idname, icon="LOOP_BACK")


class VIEW3D_PT_adaptive_fairing_compare(FairingPanel, bpy.types.Panel):
    bl_label = "Comparison"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        operator = self.layout.operator(
            OBJECT_OT_adaptive_fairing_compare.bl_idname, icon="MOD_ARRAY"
        )
        copy_solver(context.scene.adaptive_fairing, operator)


def _draw_evolution(context, layout, obj) -> None:
    record = obj.adaptive_fairing
    n_steps = len(record.shapes) - 1
    row = layout.row()
    row.scale_y = 1.3
    row.prop(record, "evolution", slider=True)
    mark = "NONE"
    if is_of_strengths(record):
        strength = shown_strength(record)
        if math.isclose(strength, result_measures(record).strength, rel_tol=1e-4):
            mark = "CHECKMARK"
        shown = iface_("Strength {:.2f}").format(strength)
    else:
        shown = iface_("Step {:.1f} of {:d}").format(record.evolution * n_steps, n_steps)
    row = layout.row()
    row.label(text=shown, icon=mark, translate=False)
    row.prop(evolution_keys(obj), "eval_time", text=iface_("Time"))

    settings = context.scene.adaptive_fairing
    row = layout.row(align=True)
    row.prop(settings, "frame_start", text=iface_("Start"))
    row.prop(settings, "frame_end", text=iface_("End"))
    row = layout.row(align=True)
    animate = row.operator(
        OBJECT_OT_adaptive_fairing_animate.bl_idname,
        text=iface_("Animate over Frames"),
        icon="KEYFRAME_HLT" if is_animated(obj) else "KEYFRAME",
    )
    copy_settings(settings, animate, ("frame_start", "frame_end"))
    if is_animated(obj):
        row.operator(OBJECT_OT_adaptive_fairing_animate_clear.bl_idname, text="", icon="X")


def _draw_estimate(context, layout, record) -> None:
    """Draw what "auto" has found and chosen."""
    noise = _world_length_text(context, record, record.noise_length)
    chosen = iface_("{:d} of {:d}, strength {:.4g}").format(
        record.shown, len(record.shapes) - 1, result_measures(record).strength
    )
    rows = [
        ("Chosen", chosen),
        ("Noise found", iface_("{:.3g} edges  ·  {:s}").format(record.noise, noise)),
        ("Radius used", iface_("{:.2f} edges").format(record.radius)),
        ("Treated as", iface_("Sharp") if record.is_sharp else iface_("Smooth")),
    ]
    _draw_table(layout.box(), rows)


def _draw_course(layout, record) -> None:
    """Draw H over the steps, with its first value and that of the result beside it."""
    energies = [shape.curvature_energy for shape in record.shapes]
    after = result_measures(record).curvature_energy
    split = layout.box().split(factor=0.55)
    split.template_icon(icon_value=pictures.plot_icon(energies), scale=6.5)
    column = split.column(align=True)
    column.label(text="Curvature H")
    column.label(text=iface_("Before  {:.4g}").format(energies[0]), translate=False)
    column.label(text=iface_("After  {:.4g}").format(after), translate=False)
    if energies[0] > 0:
        share = after / energies[0]
        left = iface_("{:.1f} % left").format(100 * share) if share < 10 else f"× {share:.3g}"
        column.label(text=left, translate=False)


def _draw_measures(context, layout, record) -> None:
    first, last = record.shapes[0], result_measures(record)
    how = []
    if not is_of_strengths(record):
        how = [
            ("Steps", f"{len(record.shapes) - 1}  ·  τ = {record.tau:.4g}"),
            ("Ended by", iface_(STOP_REASONS.get(record.stop_reason, record.stop_reason))),
        ]
    rows = [
        *how,
        ("Time", iface_("{:.2f} s, {:d} iterations").format(record.seconds, record.iterations)),
        ("Volume", _change(first.volume, last.volume)),
        ("Area", _change(first.area, last.area)),
        ("Largest move", _world_length_text(context, record, last.displacement)),
    ]
    _draw_table(layout, rows)


def _world_length_text(context, record, length: float) -> str:
    """Write a length of the mesh as it is in the world, where the object may be scaled."""
    return length_text(context, length * record.id_data.matrix_world.median_scale)


def _draw_table(layout, rows) -> None:
    split = layout.split(factor=0.4)
    titles, values = split.column(align=True), split.column(align=True)
    titles.alignment = "RIGHT"
    for title, value in rows:
        titles.label(text=title)
        values.label(text=value, translate=False)


def _change(before: float, after: float) -> str:
    """Write a relative change; an open surface has no volume, which is stored as NaN."""
    if before != before or before == 0:
        return "–"
    return f"{100 * (after - before) / abs(before):+.2f} %"


def _draw_legend(layout, record) -> None:
    low, high = record.view_range
    split = layout.box().split(factor=0.48)
    scale = pictures.scale_icon(is_signed=record.view in SIGNED_FIELDS)
    split.template_icon(icon_value=scale, scale=pictures.SCALE_TICKS)
    column = split.column(align=True)
    for index in reversed(range(pictures.SCALE_TICKS)):
        value = low + (high - low) * index / (pictures.SCALE_TICKS - 1)
        column.label(text=f"{value:.4g}", translate=False)


register, unregister = bpy.utils.register_classes_factory(
    (
        VIEW3D_PT_adaptive_fairing_results,
        VIEW3D_PT_adaptive_fairing_view,
        VIEW3D_PT_adaptive_fairing_compare,
    )
)
