"""Objects that show a field in colours, and what a view of it must leave as it was. Needs bpy."""

import bpy
import numpy as np

from support.meshes import noisy_ball
from support.objects import add_object

ENDS = {
    "hidden": lambda: bpy.ops.object.adaptive_fairing_view_end(),
    "applied": lambda: bpy.ops.object.adaptive_fairing_apply(),
    "discarded": lambda: bpy.ops.object.adaptive_fairing_discard(),
}
"""How the colours of a field may end."""


def add_denoised():
    """Add a denoised object with two colour layers, materials, and one of the object alone."""
    vertices, faces = noisy_ball(2, 0.05)
    obj = add_object(vertices, faces)
    mesh = obj.data
    for name in ("First", "Scan", "Paint"):  # the first one is not used for anything
        mesh.color_attributes.new(name, "BYTE_COLOR", "CORNER")
    mesh.attributes.active_color_name, mesh.attributes.default_color_name = "Paint", "Scan"
    for name in ("Red", "Blue"):
        mesh.materials.append(bpy.data.materials.new(name))
    obj.material_slots[1].link = "OBJECT"
    obj.material_slots[1].material = bpy.data.materials.new("Own")
    mesh.polygons.foreach_set("material_index", np.arange(len(mesh.polygons)) % 2)
    obj.select_set(True)
    bpy.ops.object.adaptive_fairing(clean="denoise")
    return obj


def state(obj):
    """Return everything that a view must leave as it was."""
    mesh = obj.data
    return {
        "active": mesh.attributes.active_color_name,
        "rendered": mesh.attributes.default_color_name,
        "attribute": mesh.attributes.active_index,
        "names": sorted(name for name in mesh.attributes.keys() if "offset" not in name),
        # Before Blender 5.0 the extension's own record is among them.
        "custom": sorted(set(mesh.keys()) - {"adaptive_fairing"}),
        "slots": [(slot.link, slot.material) for slot in obj.material_slots],
        "of the mesh": list(mesh.materials),
        "materials": sorted(each.name for each in bpy.data.materials),
        "shading": shadings(),
    }


def shadings():
    """Return type, colour and light of every 3D view of the file."""
    return [
        (space.shading.type, space.shading.color_type, space.shading.light) for space in views()
    ]


def views():
    """Return every 3D view of the file."""
    return [
        space
        for screen in bpy.data.screens
        for area in screen.areas
        for space in area.spaces
        if space.type == "VIEW_3D"
    ]


def show(field="DENSITY"):
    """Colour the selected objects by a field."""
    assert bpy.ops.object.adaptive_fairing_view(field=field) == {"FINISHED"}
