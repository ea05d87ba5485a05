"""The vertex group by whose weights the original is painted back."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from .vertex_groups import group_weights

if TYPE_CHECKING:  # enabling the add-on does not load the core
    from ...core.runtime.arrays import SingleArray

PAINT_GROUP = "Fairing"
"""Vertex group whose weights say how much of the result is shown: 1 all, 0 the original."""

_weights: dict[tuple[int, int], SingleArray] = {}  # of the object that was shown last


def made_paint_group(obj: bpy.types.Object) -> bpy.types.VertexGroup:
    """Find or make the group of an object, and make it active; a new one shows the whole result."""
    group = obj.vertex_groups.get(PAINT_GROUP)
    if group is None:
        group = obj.vertex_groups.new(name=PAINT_GROUP)
        group.add(range(len(obj.data.vertices)), 1.0, "REPLACE")
        forget_weights()
    obj.vertex_groups.active = group
    return group


def remove_paint_group(obj: bpy.types.Object) -> None:
    """Remove the group, if there is one."""
    group = obj.vertex_groups.get(PAINT_GROUP)
    if group is not None:
        obj.vertex_groups.remove(group)


def paint_weights(obj: bpy.types.Object) -> SingleArray | None:
    """Weights (n,) of the group, 0 outside of it; None without a group."""
    group = obj.vertex_groups.get(PAINT_GROUP)
    if group is None:
        return None
    key = obj.session_uid, len(obj.data.vertices)
    if key not in _weights:
        _weights.clear()
        _weights[key] = group_weights(obj, group)
    return _weights[key]


def forget_weights() -> None:
    """Have the weights read again at the next use, because they may have been painted."""
    _weights.clear()
