"""Panel with the findings on a mesh before a run: noise, parts, holes, defects."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_iface as iface_

from ..operators import modal_run
from ..operators.check import OBJECT_OT_adaptive_fairing_check, check_of
from ..operators.select_problems import OBJECT_OT_adaptive_fairing_select_problems
from .layouts import FairingPanel, draw_lines, world_length_text


class VIEW3D_PT_adaptive_fairing_check(FairingPanel, bpy.types.Panel):
    bl_label = "Check"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, obj = self.layout, context.active_object
        if modal_run.progress() is None:
            layout.operator(OBJECT_OT_adaptive_fairing_check.bl_idname, icon="VIEWZOOM")
        else:  # a button that is greyed out under the pointer would stay so after the run
            layout.operator("object.adaptive_fairing_stop", text=iface_("Stop"), icon="CANCEL")
        found = check_of(obj)
        if found is None:
            return
        column = layout.column(align=True)
        if found.is_clean:
            column.label(text="Looks clean", icon="CHECKMARK")
        else:
            length = world_length_text(context, obj.adaptive_fairing, found.noise_length)
            text = iface_("Noise: {:.2g} edges  ·  {:s}").format(found.noise_level, length)
            column.label(text=text, icon="MOD_NOISE", translate=False)
        for note in found.notes:
            draw_lines(context, layout, note, icon="INFO")
        _draw_counts(layout.column(align=True), found)
        if len(found.problems.vertices):
            layout.operator(OBJECT_OT_adaptive_fairing_select_problems.bl_idname)


def _draw_counts(column, found) -> None:
    """Draw the number of parts of the mesh, and the counts of its defects."""
    counts, problems = found.counts, found.problems
    _draw_count(column, iface_("Parts: {:d}"), counts.n_parts, is_good=counts.n_parts == 1)
    if counts.n_parts > 1:
        text = iface_("the largest has {:.1f} %").format(100 * counts.largest_part)
        column.label(text=text, icon="BLANK1", translate=False)
    _draw_count(column, iface_("Holes and outer boundaries: {:d}"), counts.n_boundaries)
    _draw_count(column, iface_("Edges with more than two faces: {:d}"), counts.n_crowded_edges)
    _draw_count(column, iface_("Vertices that are held: {:d}"), len(problems.held))
    _draw_count(column, iface_("Vertices of doubled faces: {:d}"), len(problems.left_out))
    _draw_count(column, iface_("Vertices of faces without area: {:d}"), len(problems.thin))


def _draw_count(column, text, number, is_good=None) -> None:
    """Draw a count, with a check mark if it has the right value, by default 0."""
    is_good = number == 0 if is_good is None else is_good
    icon = "CHECKMARK" if is_good else "INFO"
    column.label(text=text.format(number), icon=icon, translate=False)


register, unregister = bpy.utils.register_classes_factory((VIEW3D_PT_adaptive_fairing_check,))
