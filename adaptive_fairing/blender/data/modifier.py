"""Modifiers of geometry nodes that show a stored result, or the original beside it.

"Adaptive Fairing" reads the offsets from attributes of the mesh and adds the one at its strength,
so the coordinates of the mesh do not change. It works on meshes with shape keys, before Subdivision
and Armature. "Adaptive Fairing Split" moves the vertices on one side of a plane to the original
positions, which are an attribute as well.
"""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np
from numpy.typing import NDArray

from .. import compatibility
from .mesh_arrays import AttributeArray, remove_attributes, write_attribute
from .stored_path import offset_name, write_vectors

NAME, SPLIT_NAME = "Adaptive Fairing", "Adaptive Fairing Split"
STRENGTH, GROUP = "Strength", "Vertex Group"
SIDE, SPLIT_ORIGINAL = ".fairing_split", ".fairing_split_original"
_KNOTS, _SPLIT = "fairing_strengths", "fairing_split"


def find(obj: bpy.types.Object, mark: str = _KNOTS) -> bpy.types.NodesModifier | None:
    """Find the modifier of an object, even if it was renamed, by a custom property of its nodes."""
    for modifier in obj.modifiers:
        if modifier.type == "NODES" and modifier.node_group is not None:
            if mark in modifier.node_group:
                return modifier
    return None


def add(
    obj: bpy.types.Object, strengths: Sequence[float], strength: float
) -> bpy.types.NodesModifier:
    """Add the modifier before all others.

    Parameters
    ----------
    obj
        Object whose mesh has the offsets as attributes.
    strengths
        Strengths of the offsets, ascending; the first may be 0.
    strength
        Strength to show.
    """
    modifier = obj.modifiers.new(NAME, "NODES")
    modifier.node_group = _node_group(strengths)
    obj.modifiers.move(len(obj.modifiers) - 1, 0)
    set_strength(obj, strength)
    return modifier


def add_split(
    obj: bpy.types.Object, original: NDArray[np.float32], is_behind: NDArray[np.bool_]
) -> None:
    """Show the original positions (n, 3) at some vertices, (n,), of an object in Object Mode."""
    remove_split(obj)
    write_attribute(obj.data, AttributeArray(SIDE, "BOOLEAN", "POINT", is_behind))
    write_vectors(obj.data, SPLIT_ORIGINAL, original)
    place = 0 if find(obj) is None else 1
    obj.modifiers.new(SPLIT_NAME, "NODES").node_group = _split_nodes()
    obj.modifiers.move(len(obj.modifiers) - 1, place)


def remove_split(obj: bpy.types.Object) -> None:
    """Show the whole result."""
    remove(obj, _SPLIT)
    remove_attributes(obj.data, (SIDE, SPLIT_ORIGINAL))


def remove(obj: bpy.types.Object, mark: str = _KNOTS) -> None:
    """Remove the modifier that `find` finds, and unused nodes of that kind."""
    modifier = find(obj, mark)
    if modifier is not None:
        obj.modifiers.remove(modifier)
    for nodes in list(bpy.data.node_groups):
        if mark in nodes and nodes.users == 0:
            bpy.data.node_groups.remove(nodes)


def strength_of(obj: bpy.types.Object) -> float:
    """Read the strength of the modifier; 0 without one."""
    modifier = find(obj)
    if modifier is None:
        return 0.0
    return compatibility.modifier_input(modifier, _identifier(modifier, STRENGTH))


def set_strength(obj: bpy.types.Object, strength: float) -> None:
    """Set the strength of the modifier."""
    modifier = find(obj)
    compatibility.set_modifier_input(modifier, _identifier(modifier, STRENGTH), strength)
    obj.update_tag()


def set_group(obj: bpy.types.Object, name: str) -> None:
    """Let the weights of a vertex group scale the offset."""
    modifier = find(obj)
    compatibility.set_modifier_attribute(modifier, _identifier(modifier, GROUP), name)
    obj.update_tag()


def _identifier(modifier: bpy.types.NodesModifier, name: str) -> str:
    return modifier.node_group.interface.items_tree[name].identifier


def _node_group(strengths: Sequence[float]) -> bpy.types.NodeTree:
    """Find the nodes for these strengths, or make them."""
    knots = [float(strength) for strength in strengths]
    for nodes in bpy.data.node_groups:
        if nodes.library is None and list(nodes.get(_KNOTS, ())) == knots:
            return nodes
    nodes = _new_nodes(NAME, _KNOTS, knots)
    for name, largest in ((STRENGTH, 2.0), (GROUP, 1.0)):
        socket = nodes.interface.new_socket(name, in_out="INPUT", socket_type="NodeSocketFloat")
        socket.default_value, socket.min_value, socket.max_value = 1.0, 0.0, largest
    _add_nodes(nodes, knots)
    return nodes


def _new_nodes(name: str, mark: str, value: object) -> bpy.types.NodeTree:
    """Make nodes of a modifier, with nothing but the sockets for geometry."""
    nodes = bpy.data.node_groups.new(name, "GeometryNodeTree")
    nodes[mark], nodes.is_modifier = value, True
    for in_out in ("OUTPUT", "INPUT"):
        nodes.interface.new_socket("Geometry", in_out=in_out, socket_type="NodeSocketGeometry")
    return nodes


def _split_nodes() -> bpy.types.NodeTree:
    nodes = _new_nodes(SPLIT_NAME, _SPLIT, True)
    entry, leave = nodes.nodes.new("NodeGroupInput"), nodes.nodes.new("NodeGroupOutput")
    move = nodes.nodes.new("GeometryNodeSetPosition")
    nodes.links.new(entry.outputs["Geometry"], move.inputs["Geometry"])
    nodes.links.new(move.outputs["Geometry"], leave.inputs["Geometry"])
    for name, kind, socket in (
        (SIDE, "BOOLEAN", "Selection"),
        (SPLIT_ORIGINAL, "FLOAT_VECTOR", "Position"),
    ):
        attribute = nodes.nodes.new("GeometryNodeInputNamedAttribute")
        attribute.data_type = kind
        attribute.inputs["Name"].default_value = name
        nodes.links.new(attribute.outputs["Attribute"], move.inputs[socket])
    return nodes


def _add_nodes(nodes: bpy.types.NodeTree, knots: Sequence[float]) -> None:
    """Nodes that mix from one offset to the next; each mix ends where the following one begins."""

    def add(kind, column, row=0):
        node = nodes.nodes.new(kind)
        node.location = (200 * column, -180 * row)
        return node

    link = nodes.links.new
    entry, leave = add("NodeGroupInput", 0), add("NodeGroupOutput", len(knots) + 5)
    low, offset = 0.0, None
    for index, high in enumerate(knots, start=1):
        attribute = add("GeometryNodeInputNamedAttribute", index, 3)
        attribute.data_type = "FLOAT_VECTOR"
        attribute.inputs["Name"].default_value = offset_name(index)
        if high == 0:
            offset = attribute.outputs["Attribute"]
            continue
        part = add("ShaderNodeMapRange", index, 1)
        link(entry.outputs[STRENGTH], part.inputs["Value"])
        part.inputs["From Min"].default_value = low
        part.inputs["From Max"].default_value = high
        mix = add("ShaderNodeMix", index + 1, 2)
        mix.data_type = "VECTOR"
        factor, before, after = (
            next(each for each in mix.inputs if each.enabled and each.name == name)
            for name in ("Factor", "A", "B")
        )
        link(part.outputs["Result"], factor)
        if offset is not None:
            link(offset, before)
        link(attribute.outputs["Attribute"], after)
        offset = next(each for each in mix.outputs if each.enabled)
        low = high
    scale = add("ShaderNodeVectorMath", len(knots) + 3, 1)
    scale.operation = "SCALE"
    link(offset, scale.inputs[0])
    link(entry.outputs[GROUP], scale.inputs["Scale"])
    move = add("GeometryNodeSetPosition", len(knots) + 4)
    link(entry.outputs["Geometry"], move.inputs["Geometry"])
    link(scale.outputs["Vector"], move.inputs["Offset"])
    link(move.outputs["Geometry"], leave.inputs["Geometry"])
