"""Attributes of ours that exporters skip: their names begin with a dot, as Blender's own do.

Files that were saved before have them without. There they get it when the file is opened.
"""

from __future__ import annotations

import bpy

_STARTS = ("fairing_original", "fairing_offset_", "fairing_split")


def hide() -> None:
    """Rename the attributes of the open file, and what refers to them."""
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
