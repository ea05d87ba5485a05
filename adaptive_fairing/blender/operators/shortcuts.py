"""Keyboard shortcuts of the operators."""

from __future__ import annotations

import bpy

from .brush import OBJECT_OT_adaptive_fairing_brush
from .painting import OBJECT_OT_adaptive_fairing_paint_swap
from .results import OBJECT_OT_adaptive_fairing_before

# Keymap and its space, operator, key, whether with Alt.
_SHORTCUTS = (
    ("3D View", "VIEW_3D", OBJECT_OT_adaptive_fairing_before, "B", True),
    ("Sculpt", "EMPTY", OBJECT_OT_adaptive_fairing_brush, "N", True),
    ("Weight Paint", "EMPTY", OBJECT_OT_adaptive_fairing_paint_swap, "X", False),
)

_registered: list[tuple[bpy.types.KeyMap, bpy.types.KeyMapItem]] = []


def register() -> None:
    """Register the shortcuts."""
    configuration = bpy.context.window_manager.keyconfigs.addon
    if configuration is None:  # without a window
        return
    for name, space, operator, key, alt in _SHORTCUTS:
        keymap = configuration.keymaps.new(name, space_type=space)
        item = keymap.keymap_items.new(operator.bl_idname, key, "PRESS", alt=alt)
        _registered.append((keymap, item))


def unregister() -> None:
    """Unregister everything that `register` has added."""
    while _registered:
        keymap, item = _registered.pop()
        keymap.keymap_items.remove(item)
