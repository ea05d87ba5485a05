"""Colours of a field on a mesh, and their meaning in the record.

While a field is shown, its colours are the active ones of the mesh, in 3D views and in renders. The
colours that were active before are noted on the mesh, and become active again.
"""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ...core import FairingSettings, InputError
from . import color_material
from .attribute_arrays import remove_attributes
from .color_map import ANCHORS, DIVERGING_ANCHORS, SIGNED_FIELDS, field_range
from .field_attributes import COLORS_BEFORE, FIELD_ATTRIBUTES, color_name, write_color, write_scalar
from .fields import measure_field


def color_by_field(
    obj: bpy.types.Object,
    field: str,
    settings: FairingSettings,
) -> None:
    """Store a field of the shape that an object shows, as numbers and as active colours.

    Parameters
    ----------
    obj
        Mesh object in Object Mode.
    field
        Key of `FIELD_ATTRIBUTES`.
    settings
        As in `measure_field`.

    Raises
    ------
    InputError
        The mesh is linked from another file; also as in `measure_field`.
    """
    mesh, record = obj.data, obj.adaptive_fairing
    if mesh.library is not None:
        raise InputError(rpt_("the mesh is linked from another file: make it local to color it"))
    found = measure_field(obj, field, settings)
    low, high = field_range(field, found.values)
    anchors = DIVERGING_ANCHORS if field in SIGNED_FIELDS else ANCHORS
    if record.view != field:
        pause_view(obj)
    name = FIELD_ATTRIBUTES[field]
    attributes = mesh.attributes
    if COLORS_BEFORE not in mesh:
        mesh[COLORS_BEFORE] = {
            "active": attributes.active_color_name,
            "rendered": attributes.default_color_name,
        }
    write_scalar(mesh, name, found.values)
    write_color(mesh, color_name(name), found.values, low, high, anchors)
    attributes.active_color_name = attributes.default_color_name = color_name(name)
    record.view = field
    record.view_range = low * found.unit, high * found.unit
    record.view_power = found.power
    if record.wants_material:
        color_material.assign(obj, field)


def end_view(obj: bpy.types.Object) -> None:
    """Remove the colours of a view, and everything that they changed."""
    obj.adaptive_fairing.wants_material = False
    pause_view(obj)


def pause_view(obj: bpy.types.Object) -> str:
    """Remove the colours of a view and their numbers; a density that was asked for stays.

    Returns
    -------
    str
        The field that was shown, for `color_by_field`; empty if none was.
    """
    mesh, record = obj.data, obj.adaptive_fairing
    view = record.view
    if not view:
        return view
    color_material.take_off(obj)
    name = FIELD_ATTRIBUTES[view]
    shown = color_name(name)
    before = mesh.pop(COLORS_BEFORE, None)
    chosen = [mesh.attributes.active_color_name, mesh.attributes.default_color_name]
    if view != "DENSITY" or not record.keeps_density:
        remove_attributes(mesh, (name, shown))
    if before is not None:
        # Whoever has chosen other colours in the meantime keeps them.
        if chosen[0] == shown and before["active"] in mesh.attributes:
            mesh.attributes.active_color_name = before["active"]
        if chosen[1] == shown and before["rendered"] in mesh.attributes:
            mesh.attributes.default_color_name = before["rendered"]
    record.view = ""
    return view
