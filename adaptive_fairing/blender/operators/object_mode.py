"""A visit to Object Mode, from wherever the user is."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy


@contextmanager
def object_mode(context: bpy.types.Context) -> Iterator[None]:
    """Change to Object Mode and, if the active object can still be seen, back again.

    Positions, shape keys and attributes can be read and written there only.
    """
    active = context.active_object
    mode = active.mode if active is not None else "OBJECT"
    if mode == "OBJECT":
        yield
        return
    name = active.name
    bpy.ops.object.mode_set(mode="OBJECT")
    try:
        yield
    finally:
        active = context.view_layer.objects.active
        if active is not None and active.name == name and active.visible_get():
            bpy.ops.object.mode_set(mode=mode)
