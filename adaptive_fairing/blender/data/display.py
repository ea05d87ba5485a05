"""Displays of a result on an object: three kinds behind one interface.

A run leaves one of these on an object, named by `FairingRecord.result`:

- "LIVE": the coordinates of the mesh are original + weight · offset(strength). Every exporter
  writes what is seen.
- "MODIFIER": the coordinates of the mesh stay; a modifier adds the offset, see `modifier`.
- "KEYS": the steps of `fair` as shape keys, see `shape_keys`.
- "", nothing that can be changed any more.

No other module asks which kind it is: `display_of` returns that of an object.
"""

from __future__ import annotations

import bpy

from . import modifier
from .display_base import Display, ResultDisplay
from .key_display import KeysDisplay, RelativeKeysDisplay
from .offset_display import LiveDisplay, ModifierDisplay
from .stored_path import ORIGINAL

_DISPLAYS = {each.name: each for each in (LiveDisplay, ModifierDisplay, KeysDisplay)}


def display_of(obj: bpy.types.Object) -> Display:
    """Display of the result of a mesh object."""
    name, mesh = obj.adaptive_fairing.result, obj.data
    if obj.use_dynamic_topology_sculpting:  # the mesh that is shown cannot be written
        return Display(obj)
    if name == ModifierDisplay.name and modifier.find(obj) is None and ORIGINAL in mesh.attributes:
        return LiveDisplay(obj)  # Blender's own Apply has made it that
    if name == KeysDisplay.name and mesh.shape_keys is not None and mesh.shape_keys.use_relative:
        return RelativeKeysDisplay(obj)
    return _DISPLAYS.get(name, Display)(obj)


def new_display(obj: bpy.types.Object, name: str) -> ResultDisplay:
    """Display for a new result, by the name of the setting that chooses it."""
    return {**_DISPLAYS, "ABSOLUTE_KEYS": KeysDisplay, "RELATIVE_KEYS": RelativeKeysDisplay}[name](
        obj
    )
