"""Panels of a finished run: animation, statistics, comparison."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_iface as iface_

from ..data.results import is_of_strengths, result_measures
from ..data.shape_keys import evolution_keys
from ..operators.animate import (
    OBJECT_OT_adaptive_fairing_animate,
    OBJECT_OT_adaptive_fairing_animate_clear,
    is_animated,
)
from ..operators.compare import OBJECT_OT_adaptive_fairing_compare, comparison_of
from ..operators.select_problems import OBJECT_OT_adaptive_fairing_select_problems
from ..properties import copy_settings, copy_solver
from ..run_properties import CONTEXT
from .layouts import FairingPanel, draw_lines, world_length_text

STOP_REASONS = {
    "steps": "All steps done",
    "curvature": "Curvature low enough",
    "rate": "Hardly any change left",
    "stopped": "Stopped by hand",
}


def active_record(context: bpy.types.Context) -> bpy.types.PropertyGroup | None:
    """Record of the active mesh object, if a run has left one."""
    obj = context.active_object
    if obj is None or obj.type != "MESH" or not obj.adaptive_fairing.shapes:
        return None
    return obj.adaptive_fairing


class VIEW3D_PT_adaptive_fairing_animation(FairingPanel, bpy.types.Panel):
    bl_label = "Animation"
    bl_parent_id = "VIEW3D_PT_adaptive_fairing"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        record = active_record(context)
        return record is not None and evolution_keys(record.id_data) is not None

    def draw(self, context):
        layout, obj = self.layout, context.active_object
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


class VIEW3D_PT_adaptive_fairing_statistics(FairingPanel, bpy.types.Panel):
    bl_label = "Statistics"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return active_record(context) is not None

    def draw(self, context):
        layout, record = self.layout, active_record(context)
        draw_energies(layout, record)
        _draw_measures(context, layout, record)
        for note in record.notes.splitlines():
            draw_lines(context, layout, note, icon="INFO")
        if record.notes:
            layout.operator(OBJECT_OT_adaptive_fairing_select_problems.bl_idname)


class VIEW3D_PT_adaptive_fairing_compare(FairingPanel, bpy.types.Panel):
    bl_label = "Comparison"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        is_shown = comparison_of(context.scene) is not None
        text = iface_("Remove Comparison") if is_shown else iface_("Compare with Uniform")
        name = OBJECT_OT_adaptive_fairing_compare.bl_idname
        operator = self.layout.operator(name, text=text, icon="MOD_ARRAY", depress=is_shown)
        copy_solver(context.scene.adaptive_fairing, operator)


def draw_energies(layout, record) -> None:
    """Draw the curvature energy H of every shape as a bar, relative to the largest."""
    energies = [shape.curvature_energy for shape in record.shapes]
    largest = max(energies) or 1.0
    column = layout.column(align=True)
    column.label(text="Curvature Energy H")
    for number, (shape, energy) in enumerate(zip(record.shapes, energies, strict=True)):
        if number == 0:
            name = iface_("Before")
        elif is_of_strengths(record):
            name = iface_("Strength {:.2f}").format(shape.strength)
        else:
            name = iface_("Step {:d}").format(number)
        text = f"{name}   {energy:.4g}"
        if number and energies[0] > 0:
            text += f"   {100 * energy / energies[0]:.1f} %"
        column.progress(factor=energy / largest, text=text)


def _draw_measures(context, layout, record) -> None:
    first, last = record.shapes[0], result_measures(record)
    if is_of_strengths(record):
        noise = world_length_text(context, record, record.noise_length)
        how = [
            ("Noise", iface_("{:.3g} edges  ·  {:s}").format(record.noise, noise)),
            ("Radius used", iface_("{:.2f} edges").format(record.radius)),
            ("Treated as", iface_("Sharp" if record.is_sharp else "Smooth", CONTEXT)),
        ]
    else:
        how = [
            ("Steps", f"{len(record.shapes) - 1}  ·  τ = {record.tau:.4g}"),
            ("Ended by", iface_(STOP_REASONS.get(record.stop_reason, record.stop_reason))),
        ]
    rows = [
        *how,
        ("Time", iface_("{:.2f} s, {:d} iterations").format(record.seconds, record.iterations)),
        ("Volume", change_text(first.volume, last.volume)),
        ("Area", change_text(first.area, last.area)),
        ("Largest move", world_length_text(context, record, last.displacement)),
    ]
    split = layout.split(factor=0.4)
    titles, values = split.column(align=True), split.column(align=True)
    titles.alignment = "RIGHT"
    for title, value in rows:
        titles.label(text=iface_(title, CONTEXT), translate=False)
        values.label(text=value, translate=False)


def change_text(before: float, after: float) -> str:
    """Text of a relative change; a dash for the volume of an open surface, stored as NaN."""
    if before != before or before == 0:
        return "–"
    return f"{100 * (after - before) / abs(before):+.2f} %"


register, unregister = bpy.utils.register_classes_factory(
    (
        VIEW3D_PT_adaptive_fairing_animation,
        VIEW3D_PT_adaptive_fairing_statistics,
        VIEW3D_PT_adaptive_fairing_compare,
    )
)
