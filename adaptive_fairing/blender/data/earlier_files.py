"""Files saved by earlier states of the add-on.

Some are brought to this state when they are opened. Names of our attributes begin with a dot now,
like Blender's own, so that exporters skip them; earlier they did not. What a mesh shows is noted on
the mesh now; earlier it was noted on the object. *Before* leaves the slider in its place now;
earlier the slider went to 0, and its place was held.

Even earlier, every result was shape keys with a record of `steps`. They become a result when the
user asks for it.
"""

from __future__ import annotations

import bpy
import numpy as np

from .coloring import DENSITY
from .display import KeysDisplay, LiveDisplay, display_of
from .mesh_arrays import checksum, is_shared, read_key, read_mesh_coordinates
from .results import MEASURES, is_of_strengths, show_at
from .shape_keys import animated_frames, has_step_keys, remove_fairing_keys, shown_step
from .stored_path import StoredPath

_STARTS = ("fairing_original", "fairing_offset_", "fairing_split")


def adopt() -> None:
    """Bring the open file to the present state."""
    _hide_attributes()
    for obj in bpy.data.objects:
        if obj.type == "MESH" and obj.data.is_editable:
            _adopt_record(obj)


def _adopt_record(obj: bpy.types.Object) -> None:
    record, shown, display = obj.adaptive_fairing, obj.data.adaptive_fairing, display_of(obj)
    if record.checksum and display.has_weights:  # shape keys after strengths left it there
        shown.checksum, shown.strength = record.checksum, record.stored_strength
        if record.control is not None:
            coordinates = read_mesh_coordinates(record.control)
            record.control.adaptive_fairing.checksum = checksum(coordinates)
    if record.refined_print:
        record.refined_fingerprint = record.refined_print
    if record.held >= 0 and not obj.data.is_editmode:
        show_at(obj, record.held * display.unit)
    for name in ("checksum", "refined_print", "held"):
        record.property_unset(name)


def _hide_attributes() -> None:
    """Rename the attributes, and what refers to them."""
    for mesh in bpy.data.meshes:
        for name in [name for name in mesh.attributes.keys() if name.startswith(_STARTS)]:
            if mesh.is_editable:
                mesh.attributes[name].name = f".{name}"
    for tree in bpy.data.node_groups:
        for node in tree.nodes:
            if node.bl_idname == "GeometryNodeInputNamedAttribute" and tree.is_editable:
                name = node.inputs["Name"]
                if name.default_value.startswith(_STARTS):
                    name.default_value = f".{name.default_value}"


def has_earlier_keys(obj: bpy.types.Object) -> bool:
    """Whether a mesh object has all the keys of an earlier run, and no result since."""
    keys, n_steps = obj.data.shape_keys, len(obj.adaptive_fairing.steps)
    return n_steps > 0 and has_step_keys(obj.data) and len(keys.key_blocks) == n_steps


def take_keys(obj: bpy.types.Object) -> None:
    """Turn the keys of an earlier run, which `has_earlier_keys` finds, into a result.

    The object must be in Object Mode. Strengths get the slider of strengths, unless their keys are
    animated or mixed as relative keys.
    """
    if is_shared(obj.data):
        obj.data = obj.data.copy()
    record, keys = obj.adaptive_fairing, obj.data.shape_keys
    for step in record.steps:
        shape = record.shapes.add()
        for name in ("strength", *MEASURES):
            setattr(shape, name, getattr(step, name))
    record.shown = record.chosen or len(record.steps) - 1  # the first files have no number
    record.keeps_density = DENSITY in obj.data.attributes
    record.steps.clear()
    if is_of_strengths(record) and not keys.use_relative and animated_frames(obj) is None:
        strengths = [shape.strength for shape in record.shapes]
        place = float(np.interp(shown_step(keys), range(len(strengths)), strengths))
        start, *shapes = (read_key(block) for block in keys.key_blocks)
        remove_fairing_keys(obj)
        path = StoredPath.through(start, strengths[1:], shapes)
        LiveDisplay(obj).write(path, place)
    else:
        record.result = KeysDisplay.name
        KeysDisplay(obj).note_written()
