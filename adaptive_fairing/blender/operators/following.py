"""Handlers for changes by others: painted weights, deleted objects, undo."""

from __future__ import annotations

import bpy
import numpy as np

from ..data import earlier_files
from ..data.display import display_of
from ..data.results import update_shown
from ..data.sculpt_undo import forget_states
from ..data.vertex_groups import forget_weights, paint_weights
from . import mesh_scale, viewport
from .check import checks
from .readings import readings

_weights_before: dict[int, np.ndarray] = {}  # of the object being painted, by its session_uid


@bpy.app.handlers.persistent
def _follow_change(scene, graph) -> None:
    """Show the result with the weights just painted; end the colours of deleted objects."""
    viewport.end_without_fields()
    for update in graph.updates:
        if not (update.is_updated_geometry and isinstance(update.id, bpy.types.Object)):
            continue
        obj = update.id.original
        if obj.mode == "WEIGHT_PAINT" and display_of(obj).has_weights:
            follow_weights(obj)


def follow_weights(obj: bpy.types.Object) -> None:
    """Show an object with its painted weights, unless it does already."""
    forget_weights()
    weights = paint_weights(obj)
    before = _weights_before.get(obj.session_uid)
    if weights is None or (before is not None and np.array_equal(weights, before)):
        return
    _weights_before.clear()
    _weights_before[obj.session_uid] = weights
    update_shown(obj)


def _forget() -> None:
    """Forget all caches of meshes, which undo or another file has replaced."""
    forget_weights()
    _weights_before.clear()


def _forget_file() -> None:
    """Forget all that is known of the objects of a file, because it is being closed."""
    _forget()
    forget_states()
    for each in (checks, readings, mesh_scale):
        each.clear()


@bpy.app.handlers.persistent
def _follow_history(*_arguments) -> None:
    """After undo and redo, show the colours of fields exactly where there are fields."""
    _forget()
    viewport.end_without_fields()
    viewport.show()


@bpy.app.handlers.persistent
def _leave_file(*_arguments) -> None:
    _forget_file()
    viewport.put_back()  # the views may stay for the next file


@bpy.app.handlers.persistent
def _enter_file(*_arguments) -> None:
    earlier_files.adopt()
    viewport.adopt()


_HANDLERS = (
    ("depsgraph_update_post", _follow_change),
    ("undo_post", _follow_history),
    ("redo_post", _follow_history),
    ("load_pre", _leave_file),
    ("load_post", _enter_file),
)


def register() -> None:
    """Begin to follow."""
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def unregister() -> None:
    """End it."""
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).remove(handler)
    _forget_file()
