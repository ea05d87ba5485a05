"""Switch 3D views to the colours of the mesh, and back to what they showed before."""

from __future__ import annotations

from collections.abc import Iterator

import bpy

_SOLID_COLOR = {"type": "SOLID", "color_type": "VERTEX", "light": "FLAT"}

# Shading of the views before, by the view's address; of this session and this file only.
_before: dict[int, dict[str, str]] = {}


def show_colors(context: bpy.types.Context) -> None:
    """Show the active colour attribute of every mesh, in flat light so that colours are true."""
    for space in _views(context):
        shading = space.shading
        if space.as_pointer() not in _before:
            _before[space.as_pointer()] = {
                name: getattr(shading, name) for name in ("type", "color_type", "light")
            }
        for name, value in _SOLID_COLOR.items():
            setattr(shading, name, value)


def show_as_before(context: bpy.types.Context) -> None:
    """Give the views back the shading they had before `show_colors`."""
    for space in _views(context):
        before = _before.pop(space.as_pointer(), None)
        if before is not None:
            # Colour and light belong to solid shading and have to be set while it is on.
            for name in ("color_type", "light", "type"):
                setattr(space.shading, name, before[name])


def _views(context: bpy.types.Context) -> Iterator[bpy.types.SpaceView3D]:
    """Give the view that the user is in, or all views of the screen if there is none."""
    if context.space_data is not None and context.space_data.type == "VIEW_3D":
        yield context.space_data
        return
    for area in context.screen.areas if context.screen is not None else ():
        if area.type == "VIEW_3D":
            yield area.spaces.active


@bpy.app.handlers.persistent
def _forget_views(*_arguments) -> None:
    """Forget the views of the file that is being left: addresses are used again."""
    _before.clear()


def register() -> None:
    """Watch for files being loaded."""
    bpy.app.handlers.load_pre.append(_forget_views)


def unregister() -> None:
    """Stop watching."""
    bpy.app.handlers.load_pre.remove(_forget_views)
    _before.clear()
