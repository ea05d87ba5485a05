"""Panels with the settings of a run, its progress, and the scale of τ on the active mesh."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_iface as iface_

from ..choices import DENOISE, FAIR
from ..data.regions import refusal, target_objects
from ..operators import mesh_scale, modal_run
from ..operators.fair import OBJECT_OT_adaptive_fairing, run_label
from ..operators.mesh_scale import OBJECT_OT_adaptive_fairing_measure
from ..operators.questions import hints
from ..operators.readings import reading_of
from ..operators.settings_layout import (
    draw_accuracy,
    draw_density,
    draw_main,
    draw_options,
)
from ..properties import OUTPUT_NAMES, copy_settings, copy_solver, has_width, uses_tau
from ..requirements import scipy_problem
from ..run_properties import CONTEXT
from .layouts import FairingPanel, draw_lines
from .presets import VIEW3D_PT_adaptive_fairing_presets
from .result_box import draw_result, live_record


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
        current = modal_run.progress()
        column = layout.column()
        column.active = current is None
        doors = column.row(align=True)
        doors.use_property_split = False
        doors.scale_y = 1.2
        doors.prop(settings, "algorithm", expand=True)
        draw_main(column, settings, live_record(context))
        if settings.algorithm == FAIR and uses_tau(settings):
            _draw_meaning(context, column, settings)
        elif settings.algorithm == DENOISE and has_width(settings):
            _draw_length(context, column, settings)
        if current is not None:
            _draw_progress(layout, current)
            return
        _draw_run(context, layout, settings)
        layout.use_property_split = False
        draw_result(context, layout)


class _SettingsPanel(FairingPanel):
    """Mix-in of panels with a part of the settings, closed at first."""

    bl_parent_id = "VIEW3D_PT_adaptive_fairing"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.active = modal_run.progress() is None
        self.draw_settings(context, layout, context.scene.adaptive_fairing)


class VIEW3D_PT_adaptive_fairing_options(_SettingsPanel, bpy.types.Panel):
    bl_label = "Options"

    def draw_settings(self, context, layout, settings):
        draw_options(layout, settings, context.active_object)


class VIEW3D_PT_adaptive_fairing_advanced(_SettingsPanel, bpy.types.Panel):
    bl_label = "Advanced"

    @classmethod
    def poll(cls, context):
        return context.scene.adaptive_fairing.algorithm == FAIR

    def draw_settings(self, context, layout, settings):
        draw_density(layout, settings)
        draw_accuracy(layout, settings)
        if scipy_problem() is None:
            _draw_radii(context, layout, settings)


def _draw_meaning(context, layout, settings) -> None:
    """Draw the smoothing radius that the paper's τ gives on the active mesh."""
    scale = _scale(context, settings)
    if scale is not None and not isinstance(scale, str):
        radius = scale.radii(settings.tau * settings.steps)[1]
        column = layout.column()
        column.alignment = "RIGHT"
        text = iface_("Radius on this mesh: {:.2f} edges").format(radius)
        column.label(text=text, translate=False)


def _draw_length(context, layout, settings) -> None:
    """Draw the size of the noise, which is given in edges, as a length on the active mesh."""
    scale = _scale(context, settings)
    if scale is not None and not isinstance(scale, str):
        units = context.scene.unit_settings
        length = mesh_scale.noise_length(context.active_object, settings, scale)
        shown = bpy.utils.units.to_string(units.system, "LENGTH", length * units.scale_length)
        column = layout.column()
        column.alignment = "RIGHT"
        column.label(text=iface_("On this mesh: {:s}").format(shown), translate=False)


def _scale(context, settings):
    """Look up the scale of τ on the active mesh, or have it measured; None while it is unknown."""
    obj = context.active_object
    if scipy_problem() is not None or obj is None or obj.type != "MESH":
        return None
    scale = mesh_scale.known_scale(obj, settings)
    if scale is None:
        mesh_scale.measure_soon(obj, settings)
    return scale


def _draw_radii(context, layout, settings) -> None:
    """Draw τ, and the smoothing radii in edges in the densest, typical and coarsest parts."""
    box = layout.box()
    box.label(text="Smoothing Radius in Edges")
    obj = context.active_object
    if obj is None or obj.type != "MESH":
        box.label(text="Make a mesh object active")
        return
    scale = _scale(context, settings)
    if scale is None:
        box.operator(OBJECT_OT_adaptive_fairing_measure.bl_idname)
    elif isinstance(scale, str):
        draw_lines(context, box, scale, icon="ERROR")
    else:
        _draw_table(box, scale, settings)


def _draw_table(layout, scale, settings) -> None:
    """Draw a table: densest and coarsest part, one step and all of them."""
    from ...core.diffusion.smoothing_radius import suggest_tau  # not while enabling the add-on

    tau = settings.tau
    if not uses_tau(settings):
        tau = suggest_tau(scale, settings.radius, settings.steps)
    titles = [iface_(text) for text in ("Densest", "Typical", "Coarsest")]
    rows = [("", titles)]
    for name, time in ((iface_("Step", CONTEXT), tau), (iface_("Run"), tau * settings.steps)):
        rows.append((name, [f"{radius:.2f}" for radius in scale.radii(time)]))
    column = layout.column(align=True)
    for name, cells in rows:
        split = column.split(factor=0.19)
        split.label(text=name, translate=False)
        row = split.row()
        for cell in cells:
            row.label(text=cell, translate=False)
    column.label(text=f"τ = {tau:.4g}", translate=False)


def _draw_run(context, layout, settings) -> None:
    message = refusal(context)
    objects = target_objects(context) if message is None else []
    row = layout.row()
    row.scale_y = 1.6
    text = run_label(settings.algorithm)
    if len(objects) > 1:
        text = iface_("{:s} {:d} Objects").format(text, len(objects))
    draw_run_button(row, settings, text=text, icon="MOD_SMOOTH")
    # Without this Blender would draw the next line as the progress bar that was under the pointer.
    layout.separator(factor=0.01)
    for hint in [message] if message else hints(objects, settings):
        draw_lines(context, layout, iface_(hint), icon="INFO")
    _draw_reading(context, layout, settings)


def _draw_reading(context, layout, settings) -> None:
    """Draw the notes of the last run, with a button for the other reading of the surface."""
    reading = reading_of(context.active_object)
    if reading is None or reading.algorithm != settings.algorithm:
        return
    for note in reading.notes:
        draw_lines(context, layout, note, icon="INFO")
    texts = {"denoise": iface_("Denoise Anyway"), "detail": iface_("Keep Fine Detail")}
    for clean in reading.others:
        operator = draw_run_button(layout, settings, text=texts[clean])
        operator.clean = clean
        if clean == "detail":  # the detail is in the original alone
            operator.from_original = True


def draw_run_button(layout, settings, algorithm=None, **appearance):
    """Draw a button that runs an algorithm with the settings of the scene."""
    operator = layout.operator(OBJECT_OT_adaptive_fairing.bl_idname, **appearance)
    copy_solver(settings, operator, algorithm)
    copy_settings(settings, operator, OUTPUT_NAMES)
    return operator


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
        VIEW3D_PT_adaptive_fairing_options,
        VIEW3D_PT_adaptive_fairing_advanced,
    )
)
