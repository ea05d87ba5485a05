"""Handlers for changes by others: painted weights, deleted objects, undo."""

from __future__ import annotations

import bpy

from ..data import earlier_files
from ..data.display import display_of
from ..data.results import follow_weights
from ..data.sculpt_undo import forget_states
from ..data.vertex_groups import forget_weights
from . import mesh_scale, viewport
from .check import checks
from .readings import readings


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


def _forget_file() -> None:
    """Forget all that is known of the objects of a file, because it is being closed."""
    forget_weights()
    forget_states()
    for each in (checks, readings, mesh_scale):
        each.clear()


@bpy.app.handlers.persistent
def _follow_history(*_arguments) -> None:
    """After undo and redo, show the colours of fields exactly where there are fields."""
    forget_weights()
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
