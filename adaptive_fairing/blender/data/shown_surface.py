"""The surface that shows a result: its control mesh, or a mesh on the limit surface.

A refined mesh is a separate mesh.  `FairingRecord.control` keeps the control mesh in the file; it
comes back bit by bit when the result is discarded or another surface is chosen.  Refinement is
linear, so the original, each offset and each shape key are refined alike, and a display works on
the refined mesh as on the control mesh.

The first vertices of a refined mesh are the control vertices.  Their weights in vertex groups, the
values and the animation of keys, and the materials go back to the control mesh.  If anything else
was changed on the refined mesh, that mesh stays in the file.
"""

from __future__ import annotations

import zlib

import bpy

from ...core import FairingSettings
from .attribute_arrays import read_attributes
from .coloring import color_by_field, pause_view
from .control_mesh import CONTROL, LEVELS, has_control, is_refined, net_fingerprint, take_control
from .display import display_of
from .field_attributes import COMPARED_FIELDS
from .mesh_arrays import is_shared, n_triangles
from .paint_group import forget_weights
from .refined_object import RENEWED, RefineOptions, refine_object
from .rollback import remove_mesh
from .shape_keys import keys_checksum
from .stored_path import stored_names

LARGEST_EXACT = 500_000
"""Largest number of triangles of a refined mesh with exact normals.

Above it, normals that follow the slider take seconds, and Blender's own differ little.
"""

OWN_PREFIXES = (".", "fairing_")
"""Prefixes of attributes that hold no work of the user."""


def show_surface(obj: bpy.types.Object, surface: str) -> tuple[tuple[str, ...], str | None]:
    """Show the result of an object on a surface, and update the colours of a view.

    Parameters
    ----------
    obj
        Object in Object Mode that has a result.
    surface
        `CONTROL` or a key of `LEVELS`.

    Returns
    -------
    tuple of str, str or None
        As `refine_result` and `show_control` return.

    Raises
    ------
    FairingError
        As `refine_result`.
    """
    view = pause_view(obj)
    kept = show_control(obj)
    obj.adaptive_fairing.surface = surface
    return show_result(obj, view), kept


def show_control(obj: bpy.types.Object) -> str | None:
    """Bring the control mesh of a result back, with the shape shown now.

    Returns
    -------
    str or None
        Name of the refined mesh, if it stays in the file because something was changed on it.
    """
    if not has_control(obj):
        return None
    pause_view(obj)
    refined, record = obj.data, obj.adaptive_fairing
    is_changed = not is_refined(obj) or _fingerprint(obj.data) != record.refined_fingerprint
    take_control(obj)
    record.control = None
    name = refined.name
    if is_changed:
        refined.name, refined.use_fake_user = f"{name} refined", True
    else:
        remove_mesh(refined)
    obj.data.name = name
    return refined.name if is_changed else None


def rest_on_control(obj: bpy.types.Object) -> tuple[str, str | None]:
    """Bring the control mesh of a result back, without colours, so that it can be written.

    Returns
    -------
    str, str or None
        As `pause_view` and `show_control` return.
    """
    view, kept = pause_view(obj), None
    if is_refined(obj):
        kept = show_control(obj)
    else:  # it may have been until somebody changed the refined mesh
        obj.adaptive_fairing.surface = CONTROL
    return view, kept


def show_result(
    obj: bpy.types.Object, view: str, settings: FairingSettings | None = None
) -> tuple[str, ...]:
    """Show the result of an object, which is on its control mesh, on the surface of its record.

    Parameters
    ----------
    obj
    view
        Field to colour it by, as `pause_view` returns it. If the shape before the runs is not known
        there are no colours that compare with it.
    settings
        As in `color_by_field`, by default those of the core.

    Returns
    -------
    tuple of str
        What was cut, turned or left out because the mesh is not an oriented manifold.

    Raises
    ------
    FairingError
        The refined mesh does not fit into memory; then the control mesh stays.
    """
    notes = _refine(obj)
    if view and not (view in COMPARED_FIELDS and display_of(obj).original() is None):
        color_by_field(obj, view, settings or FairingSettings())
    return notes


def _refine(obj: bpy.types.Object) -> tuple[str, ...]:
    record = obj.adaptive_fairing
    if record.surface not in LEVELS or not display_of(obj).is_whole:
        record.surface = CONTROL
        return ()
    if is_shared(obj.data):
        obj.data = obj.data.copy()
    control = obj.data
    display = display_of(obj)
    place, has_strokes = display.place, display.has_strokes
    levels = LEVELS[record.surface]
    is_exact = n_triangles(control) * 4**levels <= LARGEST_EXACT
    obj.data = control.copy()
    try:
        options = RefineOptions(levels, exact_normals=is_exact)
        notes = refine_object(obj, options, stored_names(control))
    except BaseException:
        copy, obj.data = obj.data, control
        remove_mesh(copy)
        record.surface = CONTROL
        raise
    name = control.name
    control.name, obj.data.name = f"{name} control", name
    record.control = control
    forget_weights()
    if not has_strokes:
        display.note_written()
    display.show(place)
    record.refined_fingerprint = _fingerprint(obj.data)
    return notes


def _fingerprint(mesh: bpy.types.Mesh) -> str:
    """Fingerprint of a refined mesh, without the data that goes back to the control mesh."""
    crc = 0
    for array in read_attributes(mesh, RENEWED):
        if not array.name.startswith(OWN_PREFIXES):
            values = array.values
            content = repr(values.tolist()).encode() if values.dtype == object else values.tobytes()
            crc = zlib.crc32(content, zlib.crc32(repr(array[:3]).encode(), crc))
    if mesh.shape_keys is not None:
        crc = keys_checksum(mesh.shape_keys, crc)
    return f"{net_fingerprint(mesh)}{crc}"
