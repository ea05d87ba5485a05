"""The modifier that shows a stored result: "Adaptive Fairing", made of geometry nodes.

It reads the offsets from attributes of the mesh and adds the one at its strength, so the
coordinates of the mesh do not change. It works on meshes with shape keys, before Subdivision and
Armature.
"""

from __future__ import annotations

from collections.abc import Sequence

import bpy

from .. import compatibility

NAME = "Adaptive Fairing"
STRENGTH, GROUP = "Strength", "Vertex Group"
_KNOTS = "fairing_strengths"


def find(obj: bpy.types.Object) -> bpy.types.NodesModifier | None:
    """Find the modifier of an object, even if it was renamed."""
    return find_marked(obj, _KNOTS)


def find_marked(obj: bpy.types.Object, mark: str) -> bpy.types.NodesModifier | None:
    """Find the modifier of an object whose nodes have a custom property."""
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


def remove(obj: bpy.types.Object) -> None:
    """Remove the modifier, and its nodes if nothing else uses them."""
    remove_marked(obj, _KNOTS)


def remove_marked(obj: bpy.types.Object, mark: str) -> None:
    """Remove the modifier that `find_marked` finds, and unused nodes of that kind."""
    modifier = find_marked(obj, mark)
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
    nodes = bpy.data.node_groups.new(NAME, "GeometryNodeTree")
    nodes[_KNOTS] = knots
    nodes.is_modifier = True
    _add_sockets(nodes)
    _add_nodes(nodes, knots)
    return nodes


def _add_sockets(nodes: bpy.types.NodeTree) -> None:
    add = nodes.interface.new_socket
    add("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    add("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    strength = add(STRENGTH, in_out="INPUT", socket_type="NodeSocketFloat")
    strength.default_value, strength.min_value, strength.max_value = 1.0, 0.0, 2.0
    group = add(GROUP, in_out="INPUT", socket_type="NodeSocketFloat")
    group.default_value, group.min_value, group.max_value = 1.0, 0.0, 1.0


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
        attribute.inputs["Name"].default_value = f".fairing_offset_{index}"
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
