"""Readings of rough surfaces as noise or detail: the last run's, and the others.

The panel offers the other reading beside the note that names it.  A mesh that nothing was done to
has no record of its own, so this is remembered here, for the session alone: until the next run, and
as long as the object has the shape, or the result, that was spoken of.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import bpy

from ..data.mesh_arrays import read_mesh_coordinates
from ..data.stored_offsets import checksum, has_result

if TYPE_CHECKING:  # the solver needs scipy, which may be missing
    from ..jobs.solve import Solve

_readings: dict[int, Reading] = {}  # by the object's session_uid


class Reading(NamedTuple):
    """What a run said of an object.

    Attributes
    ----------
    notes : tuple of str
    others : tuple of str
        Values of the setting `clean` to run with instead, if there are any.
    shape : str
        Checksum of the mesh that nothing was done to; empty if there is a result.
    """

    notes: tuple[str, ...]
    others: tuple[str, ...]
    shape: str


def remember(obj: bpy.types.Object | None, solve: Solve) -> None:
    """Remember what a run said, if it has changed nothing or there is another reading."""
    if obj is None:
        return
    _readings.pop(obj.session_uid, None)
    if solve.denoised is not None and (solve.denoised.other_readings or not solve.is_changed):
        shape = "" if obj.adaptive_fairing.result else checksum(read_mesh_coordinates(obj.data))
        _readings[obj.session_uid] = Reading(solve.notes, solve.denoised.other_readings, shape)


def reading_of(obj: bpy.types.Object | None) -> Reading | None:
    """Return what was said of an object, if it still holds."""
    reading = None if obj is None else _readings.get(obj.session_uid)
    if reading is None or obj.type != "MESH":
        return None
    if bool(obj.adaptive_fairing.result) == bool(reading.shape):
        return None
    if obj.mode == "EDIT":  # coordinates and attributes cannot be read
        return reading
    if reading.shape:
        holds = reading.shape == checksum(read_mesh_coordinates(obj.data))
    else:
        holds = has_result(obj)
    return reading if holds else None


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
