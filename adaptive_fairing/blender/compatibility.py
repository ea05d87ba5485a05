"""Differences between the supported Blenders, 4.2 to 5.2, in one place."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import bpy


def fcurves(datablock: bpy.types.ID) -> Iterable[bpy.types.FCurve]:
    """Animation curves of the action of a datablock; empty without one.

    Actions have layers since Blender 4.4, and Blender 5.0 has removed the flat list
    `Action.fcurves`.
    """
    animation = datablock.animation_data
    if animation is None or animation.action is None:
        return []
    action = animation.action
    if hasattr(action, "fcurves"):
        return action.fcurves
    return [
        curve
        for layer in action.layers
        for strip in layer.strips
        for bag in strip.channelbags
        if bag.slot_handle == animation.action_slot_handle
        for curve in bag.fcurves
    ]


def known_options(operator: Callable[..., set[str]], options: dict[str, Any]) -> dict[str, Any]:
    """Keep the options that this Blender's version of an operator has.

    Importers and exporters gain options over the years; an option that this version lacks stands
    for behaviour that it lacks too.
    """
    properties = operator.get_rna_type().properties.keys()
    return {name: value for name, value in options.items() if name in properties}


def modifier_input(modifier: bpy.types.NodesModifier, identifier: str) -> float:
    """Read a number that a Geometry Nodes modifier passes to its nodes.

    The inputs are custom properties up to Blender 5.1, and properties of their own in 5.2.
    """
    if hasattr(modifier, "properties"):
        return getattr(modifier.properties.inputs, identifier).value
    return modifier[identifier]


def set_modifier_input(modifier: bpy.types.NodesModifier, identifier: str, value: float) -> None:
    """Set a number that a Geometry Nodes modifier passes to its nodes."""
    if hasattr(modifier, "properties"):
        getattr(modifier.properties.inputs, identifier).value = value
    else:
        modifier[identifier] = value


def set_modifier_attribute(modifier: bpy.types.NodesModifier, identifier: str, name: str) -> None:
    """Connect an attribute or a vertex group to an input of a Geometry Nodes modifier."""
    if hasattr(modifier, "properties"):
        socket = getattr(modifier.properties.inputs, identifier)
        socket.type, socket.attribute_name = "ATTRIBUTE", name
    else:
        modifier[f"{identifier}_use_attribute"] = True
        modifier[f"{identifier}_attribute_name"] = name


def weight_paint_settings(context: bpy.types.Context) -> bpy.types.UnifiedPaintSettings:
    """Return the settings of the brush in Weight Paint; since 5.0 every mode has its own."""
    tools = context.tool_settings
    return (
        getattr(tools, "unified_paint_settings", None) or tools.weight_paint.unified_paint_settings
    )


def sculpt_brush_radius(context: bpy.types.Context) -> tuple[float, bool]:
    """Radius of the brush in Sculpt Mode, and whether it is a length instead of pixels.

    Since Blender 5.0 the size is the diameter, and every mode has settings of its own.
    """
    tools = context.tool_settings
    unified = getattr(tools, "unified_paint_settings", None) or tools.sculpt.unified_paint_settings
    brush = tools.sculpt.brush
    owner = unified if brush is None or unified.use_unified_size else brush
    is_diameter = hasattr(owner, "unprojected_size")
    if owner.use_locked_size == "SCENE":
        return (owner.unprojected_size / 2 if is_diameter else owner.unprojected_radius), True
    return owner.size / 2 if is_diameter else owner.size, False


def show_scene(scene: bpy.types.Scene) -> None:
    """Show a scene in the present window, if there is one.

    The window is reached through its manager: in Blender 4.2 the window of the context has no
    owner, and setting its scene may crash.
    """
    for window in bpy.context.window_manager.windows:
        if window == bpy.context.window:
            window.scene = scene
