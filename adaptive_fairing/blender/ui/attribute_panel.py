"""Panel for fairing an attribute, beside the settings of the paper and in Blender's own menus.

The menus are those of colour attributes, attributes and vertex groups in the properties of a mesh,
and those of the paint modes.
"""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_iface as iface_

from ..choices import FAIR
from ..data.coloring import is_of_field, own_color
from ..operators.fair_attribute import draw_attribute_button
from .layouts import FairingPanel


class VIEW3D_PT_adaptive_fairing_attribute(FairingPanel, bpy.types.Panel):
    bl_label = "Fair Attribute"
    bl_parent_id = "VIEW3D_PT_adaptive_fairing"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return context.scene.adaptive_fairing.algorithm == FAIR

    def draw(self, context):
        obj = context.active_object
        if obj is None or obj.type != "MESH":
            self.layout.label(text="Make a mesh object active")
            return
        group = obj.vertex_groups.active
        column = self.layout.column(align=True)
        name = "" if group is None else group.name
        self._draw(context, column, "COLOR", own_color(obj.data), "Active Color", "GROUP_VCOL")
        self._draw(context, column, "GROUP", name, "Active Vertex Group", "GROUP_VERTEX")
        name = _active_attribute(obj.data)
        self._draw(context, column, "NAMED", name, "Active Attribute", "SPREADSHEET")

    def _draw(self, context, layout, source, name, title, icon):
        """Draw the button for the mesh's attribute, greyed out if it has none."""
        row = layout.row()
        row.enabled = bool(name)
        text = f"{iface_(title)}: {name}" if name else iface_(title)
        settings = context.scene.adaptive_fairing
        draw_attribute_button(row, settings, source, name, text=text, icon=icon)


def _active_attribute(mesh: bpy.types.Mesh) -> str:
    """Name of the active attribute; empty without one, or if it belongs to a field."""
    active = mesh.attributes.active
    return "" if active is None or is_of_field(active.name) else active.name


def _draw_of_colors(self, context) -> None:
    draw_attribute_button(self.layout, context.scene.adaptive_fairing, "COLOR", icon="MOD_SMOOTH")


def _draw_of_groups(self, context) -> None:
    draw_attribute_button(self.layout, context.scene.adaptive_fairing, "GROUP", icon="MOD_SMOOTH")


def _draw_of_attributes(self, context) -> None:
    name = _active_attribute(context.object.data)
    settings = context.scene.adaptive_fairing
    draw_attribute_button(self.layout, settings, "NAMED", name, icon="MOD_SMOOTH")


_ENTRIES = (
    ("MESH_MT_color_attribute_context_menu", _draw_of_colors),
    ("MESH_MT_vertex_group_context_menu", _draw_of_groups),
    ("MESH_MT_attribute_context_menu", _draw_of_attributes),
    ("VIEW3D_MT_paint_vertex", _draw_of_colors),
    ("VIEW3D_MT_paint_weight", _draw_of_groups),
)

_register_class, _unregister_class = bpy.utils.register_classes_factory(
    (VIEW3D_PT_adaptive_fairing_attribute,)
)


def register() -> None:
    """Register the panel, and add the menu entries."""
    _register_class()
    for menu, draw in _ENTRIES:
        getattr(bpy.types, menu).append(draw)


def unregister() -> None:
    """Unregister everything that `register` has added."""
    for menu, draw in _ENTRIES:
        getattr(bpy.types, menu).remove(draw)
    _unregister_class()
