"""Helpers for drawing in Blender's layouts."""

from __future__ import annotations

import re
import textwrap

import bpy
from bpy.app.translations import pgettext_iface as iface_

PIXELS_PER_CHARACTER = 6.2
"""Width of an average letter at the interface's scale 1."""

MARGIN_PIXELS = 50
ICON_PIXELS = 20

UNITS = {"NONE": ("", 1.0), "METRIC": ("m", 1.0), "IMPERIAL": ("ft", 1 / 0.3048)}
"""Unit of length of every system of units, and how many of them a metre has."""


class FairingPanel:
    """Mix-in: a panel in the sidebar of the 3D view, tab "Fairing"."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Fairing"


def draw_lines(context: bpy.types.Context, layout, text: str, *, icon: str) -> None:
    """Draw a text in as many lines as the region's width requires, because labels do not wrap."""
    scale = context.preferences.system.ui_scale
    margin = MARGIN_PIXELS + (ICON_PIXELS if icon != "NONE" else 0)
    room = context.region.width / scale - margin
    column = layout.column(align=True)
    column.scale_y = 0.8
    for line in textwrap.wrap(text, max(int(room / PIXELS_PER_CHARACTER), 20)):
        column.label(text=line.strip(" ·"), icon=icon, translate=False)
        icon = "BLANK1" if icon != "NONE" else icon


def length_text(context: bpy.types.Context, value: float, power: int = 1) -> str:
    """Text of a length in the world, or of an area, in three digits and the units of the scene.

    Parameters
    ----------
    context
    value
        Length in Blender's units, or area in their squares.
    power
        1 for a length, 2 for an area.
    """
    units = context.scene.unit_settings
    if units.system == "NONE":
        return f"{value:.3g}"
    kind = "LENGTH" if power == 1 else "AREA"
    value *= units.scale_length**power
    text = bpy.utils.units.to_string(units.system, kind, value, precision=5, split_unit=False)
    # Its precision counts the digits after the point.
    return re.sub(r"[\d.]+", lambda number: f"{float(f'{float(number[0]):.3g}'):g}", text)


def world_length_text(
    context: bpy.types.Context, record: bpy.types.PropertyGroup, length: float
) -> str:
    """Text of a length of a mesh, as it is in the world with the object's scale."""
    return world_text(context, record, length, 1)


def world_text(
    context: bpy.types.Context, record: bpy.types.PropertyGroup, value: float, power: int
) -> str:
    """Text of a power of a mesh's length, as it is in the world with the object's scale.

    Lengths and areas are in the units of the scene; curvatures are per metre or foot, or per
    Blender unit in a scene without units.
    """
    value *= record.id_data.matrix_world.median_scale**power
    if power > 0:
        return length_text(context, value, power)
    units = context.scene.unit_settings
    unit, scale = UNITS[units.system]
    if units.system != "NONE":
        scale *= units.scale_length
    return f"{value * scale**power:.3g} / {unit or iface_('unit')}{'²' if power == -2 else ''}"
