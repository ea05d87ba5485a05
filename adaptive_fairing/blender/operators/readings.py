"""What the last run took the roughness of an object for, and what else it may be.

The panel offers the other reading beside the note that names it.  A mesh that nothing was done to
has no record of its own, so this is remembered here until the next run, for the session alone.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import bpy

if TYPE_CHECKING:  # the solver needs scipy, which may be missing
    from ..jobs.solve import Solve

_readings: dict[int, Reading] = {}  # by the object's session_uid


class Reading(NamedTuple):
    """What a run said of an object.

    Attributes
    ----------
    notes : tuple of str
    others : tuple of str
        Values of the setting `clean` to run with instead.
    """

    notes: tuple[str, ...]
    others: tuple[str, ...]


def remember(obj: bpy.types.Object | None, solve: Solve) -> None:
    """Remember what a run said; nothing if there is no other reading, or no object any more."""
    if obj is None:
        return
    _readings.pop(obj.session_uid, None)
    if solve.denoised is not None and solve.denoised.other_readings:
        _readings[obj.session_uid] = Reading(solve.notes, solve.denoised.other_readings)


def reading_of(obj: bpy.types.Object | None) -> Reading | None:
    """Return the reading of an object, if there is another one."""
    return None if obj is None else _readings.get(obj.session_uid)


@bpy.app.handlers.persistent
def _forget(*_arguments) -> None:
    """Forget the objects of the file that is being left."""
    _readings.clear()


def register() -> None:
    """Watch for files being loaded."""
    bpy.app.handlers.load_pre.append(_forget)


def unregister() -> None:
    """Stop watching, and forget."""
    bpy.app.handlers.load_pre.remove(_forget)
    _forget()
