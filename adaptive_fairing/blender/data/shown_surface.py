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
from collections.abc import Iterator
from contextlib import contextmanager

import bpy

from .display_base import Display
from .mesh_arrays import is_shared, n_triangles, read_attributes
from .shape_keys import copy_settings, keys_checksum
from .stored_path import stored_names
from .targets import remove_mesh
from .vertex_groups import forget_weights, read_groups, same_groups, write_groups

CONTROL = "CONTROL"
LEVELS = {"LIMIT": 0, "REFINED_1": 1, "REFINED_2": 2, "REFINED_3": 3}
"""Steps of refinement by surface; with 0 the vertices move to their limit positions."""

LARGEST_EXACT = 500_000
"""Largest number of triangles of a refined mesh with exact normals.

Above it, normals that follow the slider take seconds, and Blender's own differ little.
"""

OWN_PREFIXES = (".", "fairing_")
"""Prefixes of attributes that hold no work of the user."""


def show_control(display: Display) -> str | None:
    """Bring the control mesh of a result back, with the shape shown now.

    Returns
    -------
    str or None
        Name of the refined mesh, if it stays in the file because something was changed on it.
    """
    if not display.has_control:
        return None
    obj, refined, record = display.obj, display.obj.data, display.obj.adaptive_fairing
    is_changed = not display.is_refined or _fingerprint(refined) != record.refined_fingerprint
    _take_control(display)
    record.control = None
    name = refined.name
    if is_changed:
        refined.name, refined.use_fake_user = f"{name} refined", True
    else:
        remove_mesh(refined)
    obj.data.name = name
    return refined.name if is_changed else None


def refine_result(display: Display) -> tuple[str, ...]:
    """Show a result, which is on its control mesh, on the surface of its record.

    Returns
    -------
    tuple of str
        What was cut, turned or left out because the mesh is not an oriented manifold.

    Raises
    ------
    FairingError
        The refined mesh does not fit into memory; then the control mesh stays.
    """
    from .refined_object import RefineOptions, refine_object

    obj, record = display.obj, display.obj.adaptive_fairing
    if record.surface not in LEVELS or not display.is_whole:
        record.surface = CONTROL
        return ()
    if is_shared(obj.data):
        obj.data = obj.data.copy()
    control, place, has_strokes = obj.data, display.place, display.has_strokes
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


@contextmanager
def control_read(display: Display) -> Iterator[None]:
    """Give an object its control mesh, with the shape shown now, while the body reads it."""
    if not display.is_refined:
        yield
        return
    obj, refined, record = display.obj, display.obj.data, display.obj.adaptive_fairing
    _take_control(display)
    try:
        yield
    finally:
        record.control, obj.data = obj.data, refined
        forget_weights()


def _take_control(display: Display) -> None:
    """Replace the refined mesh of an object by its control mesh; neither is changed."""
    obj, refined, record = display.obj, display.obj.data, display.obj.adaptive_fairing
    place = display.place if display.is_whole else None
    groups = read_groups(obj)
    if is_shared(record.control):  # a copy of the object has the same one
        record.control = record.control.copy()
    obj.data = control = record.control
    n = len(control.vertices)
    groups = [group.with_weights(lambda values: values[:n]) for group in groups]
    has_same_net = record.refined_fingerprint.startswith(net_fingerprint(refined))
    if has_same_net and not same_groups(groups, read_groups(obj)):
        write_groups(obj, groups)
    if list(control.materials) != list(refined.materials):
        control.materials.clear()
        for material in refined.materials:
            control.materials.append(material)
    if control.shape_keys is not None and refined.shape_keys is not None:
        copy_settings(refined.shape_keys, control.shape_keys)
    forget_weights()
    if place is not None:
        display.show(place)


def net_fingerprint(mesh: bpy.types.Mesh) -> str:
    """Numbers of vertices and polygons; `FairingRecord.refined_fingerprint` begins with them."""
    return f"{len(mesh.vertices)}-{len(mesh.polygons)}-"


def _fingerprint(mesh: bpy.types.Mesh) -> str:
    """Fingerprint of a refined mesh, without the data that goes back to the control mesh."""
    from .refined_object import RENEWED

    crc = 0
    for array in read_attributes(mesh, RENEWED):
        if not array.name.startswith(OWN_PREFIXES):
            values = array.values
            content = repr(values.tolist()).encode() if values.dtype == object else values.tobytes()
            crc = zlib.crc32(content, zlib.crc32(repr(array[:3]).encode(), crc))
    if mesh.shape_keys is not None:
        crc = keys_checksum(mesh.shape_keys, crc)
    return f"{net_fingerprint(mesh)}{crc}"
