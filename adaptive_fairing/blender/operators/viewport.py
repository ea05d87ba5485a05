"""Shading of 3D views while a field is shown: solid, lit, with the active colours.

Every view in solid mode shows them, and the view whose button was pressed changes to solid mode.
The earlier shading comes back when no object shows a field any more, except what the user has
changed in the meantime.
"""

from __future__ import annotations

from collections.abc import Iterator

import bpy

# Highlights would hide the dark colours of dense parts.
SHOWN = {
    "color_type": "VERTEX",
    "light": "STUDIO",
    "show_specular_highlight": False,
    "type": "SOLID",
}
"""Shading of a view that shows the colours."""

BLENDERS = {"color_type": "MATERIAL", "show_specular_highlight": True}
"""Blender's default shading, for a view that was saved while it showed the colours."""

_before: dict[int, dict[str, str | bool]] = {}  # by the address of a view that was changed


def show(asked: bpy.types.SpaceView3D | None = None) -> None:
    """Show the colours of fields, if any object has them.

    Parameters
    ----------
    asked
        View that changes to solid mode.
    """
    if not _has_fields():
        return
    for address, space in views():
        shading = space.shading
        if shading.type == "SOLID" or space == asked:
            found = {name: getattr(shading, name) for name in SHOWN}
            if found != SHOWN:
                _before.setdefault(address, found)
                for name, value in SHOWN.items():
                    setattr(shading, name, value)


def end_without_fields() -> None:
    """Restore the shading if no object shows a field any more."""
    if _before and not _has_fields():
        put_back()


def put_back() -> None:
    """Restore the shading of all views, except what was changed since."""
    for address, space in views():
        for name, value in _before.get(address, {}).items():
            if getattr(space.shading, name) == SHOWN[name]:
                setattr(space.shading, name, value)
    _before.clear()


def adopt() -> None:
    """Count the views of a file as changed by us if it was saved while they showed the colours.

    Their earlier shading is not known any more; they will get Blender's default.
    """
    if _has_fields():
        for address, space in views():
            if all(getattr(space.shading, name) == SHOWN[name] for name in SHOWN):
                _before[address] = SHOWN | BLENDERS
        show()


def _has_fields() -> bool:
    """Whether an object of this file shows a field; linked objects do not count."""
    return any(obj.adaptive_fairing.view for obj in bpy.data.objects if obj.library is None)


def views() -> Iterator[tuple[int, bpy.types.SpaceView3D]]:
    """All 3D views of the file, in all its screens, each with its address."""
    for screen in bpy.data.screens:
        for area in screen.areas:
            for space in area.spaces:
                if space.type == "VIEW_3D":
                    yield space.as_pointer(), space


def register() -> None:
    """Begin without changed views."""
    _before.clear()


def unregister() -> None:
    """Restore the views."""
    put_back()
