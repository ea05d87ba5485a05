"""The control mesh behind a refined result, and its return with the shape shown now."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy

from .display import display_of
from .key_copies import copy_settings
from .mesh_arrays import is_shared
from .paint_group import forget_weights
from .vertex_groups import read_groups, same_groups, write_groups

CONTROL = "CONTROL"
LEVELS = {"LIMIT": 0, "REFINED_1": 1, "REFINED_2": 2, "REFINED_3": 3}
"""Steps of refinement by surface; with 0 the vertices move to their limit positions."""


def has_control(obj: bpy.types.Object) -> bool:
    """Whether an object shows its result on a mesh other than the control mesh."""
    return obj.adaptive_fairing.control not in (None, obj.data)


def is_refined(obj: bpy.types.Object) -> bool:
    """Whether an object shows its result on a refined mesh that nobody has changed."""
    display = display_of(obj)
    return has_control(obj) and display.is_whole and not display.has_strokes


@contextmanager
def control_read(obj: bpy.types.Object) -> Iterator[None]:
    """Give an object its control mesh, with the shape shown now, while the body reads it."""
    record = obj.adaptive_fairing
    if not is_refined(obj):
        yield
        return
    refined = obj.data
    take_control(obj)
    try:
        yield
    finally:
        record.control, obj.data = obj.data, refined
        forget_weights()


def take_control(obj: bpy.types.Object) -> None:
    """Replace the refined mesh of an object by its control mesh; neither is changed."""
    refined, record, display = obj.data, obj.adaptive_fairing, display_of(obj)
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
        display_of(obj).show(place)


def net_fingerprint(mesh: bpy.types.Mesh) -> str:
    """Numbers of vertices and polygons; `FairingRecord.refined_fingerprint` begins with them."""
    return f"{len(mesh.vertices)}-{len(mesh.polygons)}-"
