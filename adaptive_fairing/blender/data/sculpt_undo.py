"""Undo steps of what is changed in Sculpt Mode by something else than a stroke.

Strokes are kept as differences, from which Blender cannot undo a change that was not a stroke; a
whole state just before the change gives it something to go back to. Of a slider it keeps no step at
all there, so the state after it is kept as well, once the slider rests.
"""

from __future__ import annotations

import bpy

RESTS = 0.2
"""Seconds without a change after which a slider rests."""


def keep_before(obj: bpy.types.Object | None) -> None:
    """Keep the state before a change of an object, if it is in Sculpt Mode."""
    if obj is not None and obj.mode == "SCULPT":
        _push("Adaptive Fairing")


def keep_slide(obj: bpy.types.Object) -> None:
    """Call before every change by a slider, so that all until it rests are one step."""
    timers = bpy.app.timers
    if obj.mode != "SCULPT" or bpy.app.background:
        return
    if timers.is_registered(_keep_after):
        timers.unregister(_keep_after)
    else:
        _push("Adaptive Fairing")
    timers.register(_keep_after, first_interval=RESTS)


def _keep_after() -> None:
    window = bpy.context.window_manager.windows[0]
    with bpy.context.temp_override(window=window):
        _push("Adaptive Fairing")


def _push(message: str) -> None:
    if bpy.ops.ed.undo_push.poll():  # type: ignore[call-arg]  # the stubs want self
        bpy.ops.ed.undo_push(message=message)
