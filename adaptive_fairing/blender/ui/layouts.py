"""Helpers for drawing in Blender's layouts."""

from __future__ import annotations

import textwrap

import bpy
from bpy.app.translations import pgettext_iface as iface_

PIXELS_PER_CHARACTER = 6.2
"""Width of an average letter at the interface's scale 1."""

MARGIN_PIXELS = 50
ICON_PIXELS = 20

UNITS = {"NONE": ("", 1.0), "METRIC": ("m", 1.0), "IMPERIAL": ("ft", 1 / 0.3048)}
"""Unit of length and what it is worth, of every system of units: a metre has that many."""


class FairingPanel:
    """Mix-in: a panel in the sidebar of the 3D view, tab "Fairing"."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Fairing"


def draw_lines(context: bpy.types.Context, layout, text: str, *, icon: str) -> None:
    """Draw a text over as many lines as the region's width asks for: labels do not wrap."""
    scale = context.preferences.system.ui_scale
    margin = MARGIN_PIXELS + (ICON_PIXELS if icon != "NONE" else 0)
    room = context.region.width / scale - margin
    column = layout.column(align=True)
    column.scale_y = 0.8
    for line in textwrap.wrap(text, max(int(room / PIXELS_PER_CHARACTER), 20)):
        column.label(text=line.strip(" ·"), icon=icon, translate=False)
        icon = "BLANK1" if icon != "NONE" else icon


def length_text(context: bpy.types.Context, length: float) -> str:
    """Write a length of the world, in three digits, in the units of the scene."""
    length = float(f"{length:.3g}")
    units = context.scene.unit_settings
    if units.system == "NONE":
        return f"{length:.3g}"
    return bpy.utils.units.to_string(
        units.system, "LENGTH", length * units.scale_length, precision=5, split_unit=False
    )


def world_length_text(
    context: bpy.types.Context, record: bpy.types.PropertyGroup, length: float
) -> str:
    """Write a length of a mesh as it is in the world, where the object may be scaled."""
    return length_text(context, length * record.id_data.matrix_world.median_scale)


def curvature_text(
    context: bpy.types.Context, record: bpy.types.PropertyGroup, value: float, power: int
) -> str:
    """Write a curvature of a mesh as it is in the world, in 1 / length to a power.

    In metres or feet where the scene has units, otherwise in Blender's units.
    """
    units = context.scene.unit_settings
    unit, scale = UNITS[units.system]
    if units.system != "NONE":
        scale *= units.scale_length
    value /= (record.id_data.matrix_world.median_scale * scale) ** power
    return f"{value:.3g} / {unit or iface_('unit')}{'²' if power == 2 else ''}"
