"""Split view by a modifier: the original on one side of a plane, the result on the other.

The modifier moves the vertices of that side to the original positions, an attribute of the mesh.
"""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from . import modifier
from .attribute_arrays import remove_attributes
from .stored_path import write_vectors

NAME = "Adaptive Fairing Split"
SIDE, ORIGINAL = ".fairing_split", ".fairing_split_original"
_MARK = "fairing_split"


def add(obj: bpy.types.Object, original: NDArray[np.float32], is_behind: NDArray[np.bool_]) -> None:
    """Show the original behind the plane.

    Parameters
    ----------
    obj
        Mesh object in Object Mode.
    original
        (n, 3) positions.
    is_behind
        (n,) whether each vertex shows the original.
    """
    remove(obj)
    side = obj.data.attributes.new(SIDE, "BOOLEAN", "POINT")
    side.data.foreach_set("value", is_behind)
    write_vectors(obj.data, ORIGINAL, original)
    place = 0 if modifier.find(obj) is None else 1
    obj.modifiers.new(NAME, "NODES").node_group = _node_group()
    obj.modifiers.move(len(obj.modifiers) - 1, place)


def remove(obj: bpy.types.Object) -> None:
    """Show the whole result."""
    modifier.remove_marked(obj, _MARK)
    remove_attributes(obj.data, (SIDE, ORIGINAL))


def _node_group() -> bpy.types.NodeTree:
    nodes = bpy.data.node_groups.new(NAME, "GeometryNodeTree")
    nodes[_MARK] = True
    nodes.is_modifier = True
    for in_out in ("OUTPUT", "INPUT"):
        nodes.interface.new_socket("Geometry", in_out=in_out, socket_type="NodeSocketGeometry")
    entry, leave = nodes.nodes.new("NodeGroupInput"), nodes.nodes.new("NodeGroupOutput")
    move = nodes.nodes.new("GeometryNodeSetPosition")
    nodes.links.new(entry.outputs["Geometry"], move.inputs["Geometry"])
    nodes.links.new(move.outputs["Geometry"], leave.inputs["Geometry"])
    for name, kind, socket in (
        (SIDE, "BOOLEAN", "Selection"),
        (ORIGINAL, "FLOAT_VECTOR", "Position"),
    ):
        attribute = nodes.nodes.new("GeometryNodeInputNamedAttribute")
        attribute.data_type = kind
        attribute.inputs["Name"].default_value = name
        nodes.links.new(attribute.outputs["Attribute"], move.inputs[socket])
    return nodes
