"""Colour a mesh by a field, and remember on the object what the colours mean."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ...core import FairingSettings, InputError
from .attribute_arrays import remove_attributes
from .attributes import FIELD_ATTRIBUTES, color_name, write_color, write_scalar
from .color_map import ANCHORS, DIVERGING_ANCHORS, SIGNED_FIELDS, field_range
from .fields import field_values


def color_by_field(
    obj: bpy.types.Object,
    field: str,
    settings: FairingSettings,
) -> None:
    """Store a field of the shape that an object shows, as numbers and as colours.

    Parameters
    ----------
    obj
        Mesh object in Object Mode.
    field
        Key of `FIELD_ATTRIBUTES`.
    settings
        As in `field_values`.

    Raises
    ------
    InputError
        The mesh is linked from another file, or as in `field_values`.
    """
    if obj.data.library is not None:
        raise InputError(rpt_("the mesh is linked from another file: make it local to colour it"))
    values = field_values(obj, field, settings)
    low, high = field_range(field, values)
    anchors = DIVERGING_ANCHORS if field in SIGNED_FIELDS else ANCHORS
    if obj.adaptive_fairing.view != field:
        end_view(obj)
    name = FIELD_ATTRIBUTES[field]
    write_scalar(obj.data, name, values)
    write_color(obj.data, color_name(name), values, low, high, anchors)
    obj.adaptive_fairing.view = field
    obj.adaptive_fairing.view_range = low, high


def end_view(obj: bpy.types.Object) -> None:
    """Remove the colours of a view and the numbers behind them, but for a density to keep."""
    record = obj.adaptive_fairing
    if not record.view:
        return
    name = FIELD_ATTRIBUTES[record.view]
    if record.view != "DENSITY" or not record.keeps_density:
        remove_attributes(obj.data, (name, color_name(name)))
    record.view = ""
