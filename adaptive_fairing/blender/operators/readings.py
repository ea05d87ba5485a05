"""Readings of rough surfaces as noise or detail, and refusals: what the last run said.

The panel shows it, and offers the other reading beside the note that names it.  A mesh that was not
changed has no record, so this is remembered here, for the session only: until the next run begins,
and as long as the object keeps the shape, or the result, of that run.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import bpy

from ..choices import DENOISE, FAIR
from ..data.display import display_of
from ..data.mesh_arrays import checksum, read_mesh_coordinates

if TYPE_CHECKING:  # the solver needs scipy, which may be missing
    from ..jobs.solve import Solve

readings: dict[int, Reading] = {}
"""Notes by the object's session_uid."""


class Reading(NamedTuple):
    """Notes of a run on an object.

    Attributes
    ----------
    algorithm : str
        Algorithm of the run.
    notes : tuple of str
    others : tuple of str
        Other values of the setting `clean` to run with, if there are any.
    shape : str
        Checksum of the mesh that was not changed; empty if there is a result.
    """

    algorithm: str
    notes: tuple[str, ...]
    others: tuple[str, ...]
    shape: str


def remember(obj: bpy.types.Object | None, solve: Solve) -> None:
    """Remember the notes of a run that changed nothing, or that allows another reading."""
    if obj is None or obj.type != "MESH":
        return
    notes, others, error = solve.notes, (), solve.error
    if error is not None:
        notes = (error,)
    elif solve.denoised is not None:
        others = solve.denoised.other_readings
    if error is not None or others or not solve.is_changed:
        algorithm = DENOISE if solve.is_denoise else FAIR
        shape = "" if obj.adaptive_fairing.result else checksum(read_mesh_coordinates(obj.data))
        readings[obj.session_uid] = Reading(algorithm, notes, others, shape)


def reading_of(obj: bpy.types.Object | None) -> Reading | None:
    """Return the notes on an object, if they still hold."""
    reading = None if obj is None else readings.get(obj.session_uid)
    if reading is None or obj.type != "MESH":
        return None
    if bool(obj.adaptive_fairing.result) == bool(reading.shape):
        return None
    if obj.mode == "EDIT":  # coordinates and attributes cannot be read
        return reading
    if reading.shape:
        holds = reading.shape == checksum(read_mesh_coordinates(obj.data))
    else:
        holds = display_of(obj).is_whole
    return reading if holds else None
