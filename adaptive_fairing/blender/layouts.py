"""Helpers for drawing in Blender's layouts."""

from __future__ import annotations

import textwrap

import bpy

PIXELS_PER_CHARACTER = 7.0
"""Width of an average letter at the interface's scale 1."""

MARGIN_PIXELS = 70


def draw_lines(context: bpy.types.Context, layout, text: str, *, icon: str) -> None:
    """Draw a text over as many lines as the region's width asks for: labels do not wrap."""
    scale = context.preferences.system.ui_scale
    room = context.region.width / scale - MARGIN_PIXELS
    column = layout.column(align=True)
    column.scale_y = 0.8
    for line in textwrap.wrap(text, max(int(room / PIXELS_PER_CHARACTER), 20)):
        column.label(text=line, icon=icon, translate=False)
        icon = "BLANK1"
