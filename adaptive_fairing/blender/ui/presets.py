"""Presets of the panel, in Blender's own preset system."""

from __future__ import annotations

from pathlib import Path

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

from ..properties import SOLVER_NAMES

SUBDIRECTORY = "adaptive_fairing"
_SHIPPED = str(Path(__file__).with_name("shipped"))  # holds the folder "presets"


class VIEW3D_PT_adaptive_fairing_presets(PresetPanel, bpy.types.Panel):
    bl_space_type = "VIEW_3D"
    bl_label = "Fairing Presets"
    preset_subdir = SUBDIRECTORY
    preset_operator = "script.execute_preset"
    preset_add_operator = "object.adaptive_fairing_preset_add"


class OBJECT_OT_adaptive_fairing_preset_add(AddPresetBase, bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_preset_add"
    bl_label = "Add Fairing Preset"
    bl_description = "Add a preset with the settings of the panel, or remove one"
    preset_menu = "VIEW3D_PT_adaptive_fairing_presets"
    preset_subdir = SUBDIRECTORY
    preset_defines = ("settings = bpy.context.scene.adaptive_fairing",)
    preset_values = tuple(f"settings.{name}" for name in SOLVER_NAMES)


_register_classes, _unregister_classes = bpy.utils.register_classes_factory(
    (VIEW3D_PT_adaptive_fairing_presets, OBJECT_OT_adaptive_fairing_preset_add)
)


def register() -> None:
    """Offer the presets that come with the add-on, and the user's own."""
    _register_classes()
    bpy.utils.register_preset_path(_SHIPPED)


def unregister() -> None:
    """Withdraw the presets."""
    bpy.utils.unregister_preset_path(_SHIPPED)
    _unregister_classes()
