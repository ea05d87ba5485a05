"""Panels with the settings of a run, its progress, and what τ means on the mesh at hand."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_iface as iface_

from ..data.regions import refusal, target_objects
from ..operators import mesh_scale, modal_run
from ..operators.fair import OBJECT_OT_adaptive_fairing
from ..operators.settings_layout import (
    draw_accuracy,
    draw_density,
    draw_method,
    draw_output,
    draw_region,
)
from ..operators.tau import (
    OBJECT_OT_adaptive_fairing_measure,
    OBJECT_OT_adaptive_fairing_suggest_tau,
)
from ..properties import AUTO, OUTPUT_NAMES, copy_settings, copy_solver
from ..requirements import scipy_problem
from .layouts import draw_lines
from .presets import VIEW3D_PT_adaptive_fairing_presets


class FairingPanel:
    """Mix-in: a panel in the sidebar of the 3D view, tab "Fairing"."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Fairing"


class VIEW3D_PT_adaptive_fairing(FairingPanel, bpy.types.Panel):
    bl_label = "Adaptive Fairing"

    def draw_header_preset(self, context):
        VIEW3D_PT_adaptive_fairing_presets.draw_panel_header(self.layout)

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = context.scene.adaptive_fairing
        problem = scipy_problem()
        if problem is not None:
            draw_lines(context, layout, problem, icon="ERROR")
        column = layout.column()
        column.active = modal_run.progress() is None
        draw_method(column, settings)
        if problem is None and settings.method != AUTO:
            _draw_radius(context, layout, settings)
        current = modal_run.progress()
        if current is None:
            _draw_run(context, layout, settings)
        else:
            _draw_progress(layout, current)


class _SettingsPanel(FairingPanel):
    """Mix-in: a part of the settings, closed at first."""

    bl_parent_id = "VIEW3D_PT_adaptive_fairing"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.active = modal_run.progress() is None
        self.draw_settings(context, layout, context.scene.adaptive_fairing)


class VIEW3D_PT_adaptive_fairing_density(_SettingsPanel, bpy.types.Panel):
    bl_label = "Density"

    @classmethod
    def poll(cls, context):
        return context.scene.adaptive_fairing.method != AUTO

    def draw_settings(self, context, layout, settings):
        draw_density(layout, settings)


class VIEW3D_PT_adaptive_fairing_region(_SettingsPanel, bpy.types.Panel):
    bl_label = "Region and Boundary"

    def draw_settings(self, context, layout, settings):
        draw_region(layout, settings, context.active_object)


class VIEW3D_PT_adaptive_fairing_output(_SettingsPanel, bpy.types.Panel):
    bl_label = "Result"

    def draw_settings(self, context, layout, settings):
        draw_output(layout, settings)


class VIEW3D_PT_adaptive_fairing_accuracy(_SettingsPanel, bpy.types.Panel):
    bl_label = "Stopping and Accuracy"

    @classmethod
    def poll(cls, context):
        return context.scene.adaptive_fairing.method != AUTO

    def draw_settings(self, context, layout, settings):
        draw_accuracy(layout, settings)


def _draw_radius(context, layout, settings) -> None:
    """Draw what τ means: smoothing radii in edges, and the way back from a radius to τ."""
    box = layout.box()
    obj = context.active_object
    head = box.row(align=True)
    head.label(text="Smoothing Radius in Edges", icon="PROP_ON")
    measure = OBJECT_OT_adaptive_fairing_measure.bl_idname
    head.operator(measure, text="", icon="FILE_REFRESH", emboss=False)
    if obj is None or obj.type != "MESH":
        box.label(text="Make a mesh object active")
        return
    scale = mesh_scale.known_scale(obj, settings)
    if scale is None:
        is_coming = mesh_scale.measure_soon(obj, settings)
        box.label(text="Measuring…" if is_coming else "Not measured yet")
    elif isinstance(scale, str):
        draw_lines(context, box, scale, icon="ERROR")
    else:
        _draw_radii(box, scale, settings)
    row = box.row(align=True)
    row.use_property_split = False
    row.prop(settings, "radius")
    row.operator(OBJECT_OT_adaptive_fairing_suggest_tau.bl_idname)


def _draw_radii(layout, scale, settings) -> None:
    """Draw a table: densest and coarsest part, one step and all of them."""
    one = scale.radii(settings.tau)
    total = scale.radii(settings.tau * settings.steps)
    titles = [iface_(text) for text in ("Densest", "Typical", "Coarsest")]
    rows = [("", titles)]
    for name, radii in ((iface_("Step"), one), (iface_("Run"), total)):
        rows.append((name, [f"{radius:.2f}" for radius in radii]))
    column = layout.column(align=True)
    for name, cells in rows:
        split = column.split(factor=0.19)
        split.label(text=name, translate=False)
        row = split.row()
        for cell in cells:
            row.label(text=cell, translate=False)


def _draw_run(context, layout, settings) -> None:
    message = refusal(context)
    n_objects = len(target_objects(context)) if message is None else 0
    text = iface_("Fair") if n_objects < 2 else iface_("Fair {:d} Objects").format(n_objects)
    row = layout.row()
    row.scale_y = 1.6
    draw_run_button(row, settings, text=text, icon="MOD_SMOOTH")


def draw_run_button(layout, settings, **appearance) -> None:
    """Draw a button that runs with the settings of the scene."""
    operator = layout.operator(OBJECT_OT_adaptive_fairing.bl_idname, **appearance)
    copy_solver(settings, operator)
    copy_settings(settings, operator, OUTPUT_NAMES)


def _draw_progress(layout, current) -> None:
    column = layout.column(align=True)
    column.progress(factor=current.factor, text=current.describe_step())
    details = current.solver_details()
    if details:
        column.label(text=details, translate=False)
    row = layout.row()
    row.scale_y = 1.6
    row.enabled = not current.worker.is_stopping
    text = iface_("Stop") if current.solve.is_denoise else iface_("Stop, Keep Steps")
    if current.worker.is_stopping:
        text = iface_("Stopping…")
    row.operator("object.adaptive_fairing_stop", text=text, icon="CANCEL")


register, unregister = bpy.utils.register_classes_factory(
    (
        VIEW3D_PT_adaptive_fairing,
        VIEW3D_PT_adaptive_fairing_density,
        VIEW3D_PT_adaptive_fairing_region,
        VIEW3D_PT_adaptive_fairing_output,
        VIEW3D_PT_adaptive_fairing_accuracy,
    )
)
