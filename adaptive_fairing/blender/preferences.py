"""Preferences of the add-on: defaults for new files, and the number of processors for a run."""

from __future__ import annotations

from collections.abc import Callable

import bpy
from bpy.props import EnumProperty, IntProperty

from .choices import ALGORITHMS, DENOISE, LIVE, RESULTS

DEFAULTS = ("algorithm", "result")
"""Settings of a scene that the preferences have too."""


def addon_name() -> str:
    """Name under which Blender knows the add-on; for an extension it begins with its repository."""
    parts = __package__.split(".")
    return ".".join(parts[:3]) if parts[0] == "bl_ext" else parts[0]


def _set_in_all_scenes(name: str) -> Callable[[FairingPreferences, bpy.types.Context], None]:
    """Make the callback that passes a changed default on to the scenes of the open file."""

    def update(preferences: FairingPreferences, context: bpy.types.Context) -> None:
        for scene in bpy.data.scenes:
            setattr(scene.adaptive_fairing, name, getattr(preferences, name))

    return update


class FairingPreferences(bpy.types.AddonPreferences):
    bl_idname = addon_name()

    algorithm: EnumProperty(
        name="Algorithm",
        description="Settings of the panel in new files, and from now on in this one",
        items=ALGORITHMS,
        default=DENOISE,
        update=_set_in_all_scenes("algorithm"),
    )
    result: EnumProperty(
        name="Result",
        description="Result of Denoise in new files, and from now on in this one",
        items=RESULTS,
        default=LIVE,
        update=_set_in_all_scenes("result"),
    )
    threads: IntProperty(
        name="Threads",
        description="Number of processor cores that a run may use; 0 uses all, but at most 8",
        default=0,
        min=0,
        soft_max=16,
        max=256,
    )

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        for name in DEFAULTS:
            layout.prop(self, name)
        row = layout.row()
        row.prop(self, "threads")
        if not self.threads:
            row.label(text="Automatic")


def preferences() -> FairingPreferences | None:
    """Preferences of the add-on; None if it was not enabled as an add-on, as in scripts."""
    addon = bpy.context.preferences.addons.get(addon_name())
    return None if addon is None else addon.preferences


@bpy.app.handlers.persistent
def _set_up_scenes(*_arguments) -> None:
    """Set the defaults in the scenes of a loaded file, where nothing was chosen."""
    wanted = preferences()
    if wanted is None or not hasattr(bpy.data, "scenes"):  # while Blender starts
        return
    for scene in bpy.data.scenes:
        settings = scene.adaptive_fairing
        for name in DEFAULTS:
            value = getattr(wanted, name)
            if not settings.is_property_set(name) and getattr(settings, name) != value:
                setattr(settings, name, value)


_register_classes, _unregister_classes = bpy.utils.register_classes_factory((FairingPreferences,))


def register() -> None:
    """Register the preferences, and apply them from now on."""
    _register_classes()
    bpy.app.handlers.load_post.append(_set_up_scenes)
    _set_up_scenes()


def unregister() -> None:
    """Unregister everything that `register` has added."""
    bpy.app.handlers.load_post.remove(_set_up_scenes)
    _unregister_classes()
