"""Entries in Blender's own menus, which the search finds too."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_iface as iface_

from ..choices import DENOISE, FAIR
from ..operators.compare import OBJECT_OT_adaptive_fairing_compare
from ..operators.loop_subdivide import OBJECT_OT_adaptive_fairing_loop_subdivide
from ..properties import copy_solver
from .settings_panel import draw_run_button


def draw_object_menu(self, context) -> None:
    """Add the runs and the comparison to the Object menu, with the settings of the scene."""
    self.layout.separator()
    draw_mode_menu(self, context)
    compare = self.layout.operator(OBJECT_OT_adaptive_fairing_compare.bl_idname)
    copy_solver(context.scene.adaptive_fairing, compare)
    draw_loop_subdivide(self, context)


def draw_mode_menu(self, context) -> None:
    """Add both algorithms, with the settings of the scene, in words that users search for."""
    settings = context.scene.adaptive_fairing
    denoise = iface_("Denoise Scan (Fair, Smooth Noise)")
    draw_run_button(self.layout, settings, DENOISE, text=denoise, icon="MOD_SMOOTH")
    fair = iface_("Adaptive Fairing (Diffuse, Smooth by the Paper)")
    draw_run_button(self.layout, settings, FAIR, text=fair, icon="MOD_SMOOTH")


def draw_loop_subdivide(self, context) -> None:
    """Add the refinement, which does not smooth."""
    self.layout.operator(OBJECT_OT_adaptive_fairing_loop_subdivide.bl_idname, icon="MOD_SUBSURF")


_ENTRIES = (
    ("VIEW3D_MT_object", draw_object_menu),
    ("VIEW3D_MT_edit_mesh", draw_loop_subdivide),
    ("VIEW3D_MT_edit_mesh_vertices", draw_mode_menu),
    ("VIEW3D_MT_sculpt", draw_mode_menu),
)


def register() -> None:
    """Add the entries."""
    for menu, draw in _ENTRIES:
        getattr(bpy.types, menu).append(draw)


def unregister() -> None:
    """Unregister everything that `register` has added."""
    for menu, draw in _ENTRIES:
        getattr(bpy.types, menu).remove(draw)
