"""Files saved by an earlier state of the add-on, brought to this one when they are opened.

Attributes of ours have names that begin with a dot, as Blender's own do, so that exporters skip
them; they had none. What a mesh shows is noted on the mesh; it was noted on the object.
"""

from __future__ import annotations

import bpy

from .mesh_arrays import checksum, read_mesh_coordinates

_STARTS = ("fairing_original", "fairing_offset_", "fairing_split")


def adopt() -> None:
    """Bring the open file to the present state."""
    _hide_attributes()
    for obj in bpy.data.objects:
        record = obj.adaptive_fairing
        if record.checksum and obj.type == "MESH" and obj.data.is_editable:
            shown = obj.data.adaptive_fairing
            shown.checksum, shown.strength = record.checksum, record.stored_strength
            if record.control is not None:
                coordinates = read_mesh_coordinates(record.control)
                record.control.adaptive_fairing.checksum = checksum(coordinates)
            record.checksum = ""


def _hide_attributes() -> None:
    """Rename the attributes, and what refers to them."""
    for mesh in bpy.data.meshes:
        for name in [name for name in mesh.attributes.keys() if name.startswith(_STARTS)]:
            if mesh.is_editable:
                mesh.attributes[name].name = f".{name}"
    for tree in bpy.data.node_groups:
        for node in tree.nodes:
            if node.bl_idname == "GeometryNodeInputNamedAttribute" and tree.is_editable:
                name = node.inputs["Name"]
                if name.default_value.startswith(_STARTS):
                    name.default_value = f".{name.default_value}"
