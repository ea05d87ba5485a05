"""Colour a mesh by a field, and remember on the object what the colours mean."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_rpt as rpt_
from numpy.typing import ArrayLike

from ...core import FairingSettings, InputError
from .attributes import write_color, write_scalar
from .color_map import ANCHORS, DIVERGING_ANCHORS, SIGNED_FIELDS, color_range, symmetric_range
from .fields import field_values

ATTRIBUTES = {
    "DENSITY": "fairing_density",
    "DISPLACEMENT": "fairing_displacement",
    "CURVATURE": "fairing_mean_curvature",
    "REMOVED": "fairing_removed",
}
"""Float attribute of each field; the colour attribute has "_color" behind it."""


def color_by_field(
    obj: bpy.types.Object,
    field: str,
    settings: FairingSettings,
    before: ArrayLike | None = None,
) -> None:
    """Store a field of the shape that an object shows, as numbers and as colours.

    Parameters
    ----------
    obj
        Mesh object in Object Mode.
    field
        Key of `ATTRIBUTES`.
    settings, before
        As in `field_values`.

    Raises
    ------
    InputError
        The mesh is linked from another file, or as in `field_values`.
    """
    if obj.data.library is not None:
        raise InputError(rpt_("the mesh is linked from another file: make it local to colour it"))
    values = field_values(obj, field, settings, before)
    is_signed = field in SIGNED_FIELDS
    low, high = symmetric_range(values) if is_signed else color_range(values)
    anchors = DIVERGING_ANCHORS if is_signed else ANCHORS
    name = ATTRIBUTES[field]
    write_scalar(obj.data, name, values)
    write_color(obj.data, f"{name}_color", values, low, high, anchors)
    obj.adaptive_fairing.view = field
    obj.adaptive_fairing.view_range = low, high
