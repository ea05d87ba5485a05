"""Undo steps for changes in Sculpt Mode other than strokes, and for sliders in Edit Mode.

Blender stores strokes as differences, from which it cannot undo another kind of change. So a whole
state is stored just before the change. For a slider of an object Blender stores no step at all in
these modes, so the state after it is stored as well, once the slider rests.
"""

from __future__ import annotations

import bpy

RESTS = 0.2
"""Seconds without a change after which a slider counts as at rest."""


def keep_before(obj: bpy.types.Object | None) -> None:
    """Store the state before a change of an object, if it is in Sculpt Mode."""
    if obj is not None and obj.mode == "SCULPT":
        _push("Adaptive Fairing")


def keep_slide(obj: bpy.types.Object) -> None:
    """Call before every change by a slider, so that all changes until it rests are one step."""
    timers = bpy.app.timers
    if obj.mode not in ("SCULPT", "EDIT") or bpy.app.background:
        return
    if timers.is_registered(_keep_after):
        timers.unregister(_keep_after)
    else:
        keep_before(obj)
    timers.register(_keep_after, first_interval=RESTS)


def _keep_after() -> None:
    window = bpy.context.window_manager.windows[0]
    with bpy.context.temp_override(window=window):
        _push("Adaptive Fairing")


def _push(message: str) -> None:
    if bpy.ops.ed.undo_push.poll():  # type: ignore[call-arg]  # the stubs want self
        bpy.ops.ed.undo_push(message=message)
