"""Results on an object: the shown shape, its original, apply and discard.

A run leaves one of these on an object, named by `FairingRecord.result`:

- "LIVE" and "MODIFIER", the result of `denoise`, see `stored_offsets`;
- "KEYS", the steps of the paper's methods as shape keys, see `shape_keys`;
- "", nothing that can be changed any more.
"""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np
from bpy.app.translations import pgettext_rpt as rpt_

from ...core import InputError
from ...core.runtime.arrays import SingleArray
from . import modifier, split
from .field_attributes import remove_density
from .mesh_arrays import read_key, read_mesh_coordinates, write_positions
from .record_functions import forget, remember_coordinates, set_strengths, split_along
from .rollback import remove_mesh
from .shape_keys import (
    animate_evolution,
    animated_frames,
    has_foreign_keys,
    mixed_keys,
    remove_fairing_keys,
    write_absolute_keys,
    write_final_shape,
    write_relative_keys,
)
from .stored_offsets import (
    ORIGINAL,
    PAINT_GROUP,
    StoredResult,
    has_result,
    is_current,
    paint_weights,
    read_stored,
    read_vectors,
    remove_stored,
    shown_by,
    write_shown,
    write_stored,
    write_vectors,
)


def is_stale(obj: bpy.types.Object) -> bool:
    """Whether the mesh was changed by somebody else since the last run stored its result."""
    is_stored = obj.adaptive_fairing.result in ("LIVE", "MODIFIER")
    return is_stored and obj.mode != "EDIT" and not is_current(obj)


def shown_positions(obj: bpy.types.Object) -> SingleArray:
    """Positions (n, 3) that an object shows, other modifiers aside; not in Edit Mode."""
    if obj.data.shape_keys is not None:
        shown = mixed_keys(obj.data.shape_keys)
    else:
        shown = read_mesh_coordinates(obj.data)
    if obj.adaptive_fairing.result == "MODIFIER" and is_current(obj):
        return shown + (shown_by(obj) - read_mesh_coordinates(obj.data))
    return shown


def original_positions(obj: bpy.types.Object) -> SingleArray | None:
    """Positions (n, 3) before the first run that still counts; None if no result is left."""
    if not has_result(obj):
        return None
    mesh = obj.data
    if obj.adaptive_fairing.result == "MODIFIER":
        return read_mesh_coordinates(mesh)
    if ORIGINAL in mesh.attributes:
        return read_vectors(mesh, ORIGINAL)
    return read_key(mesh.shape_keys.reference_key)


def store_strengths(
    obj: bpy.types.Object,
    start: SingleArray,
    shapes: list[SingleArray],
    strengths: list[float],
    strength: float,
    way: str,
    *,
    from_original: bool = False,
) -> None:
    """Store the result of `denoise` and show it.

    A second run refines the first: strength 0 stays the first original, and what the first run
    had moved at a strength is added. So runs on two regions add up.

    Parameters
    ----------
    obj
        Object that may be written, see `writable_object`; its record has this run's shapes.
    start
        (n, 3) positions that the run started from.
    shapes, strengths
        (n, 3) positions at each strength.
    strength
        The one to show.
    way
        "LIVE" or "MODIFIER".
    from_original
        The run started from the original: earlier ones do not count.
    """
    relative = [each / strength for each in strengths]
    earlier, original = read_stored(obj), original_positions(obj)
    if from_original or original is None:
        original, carried = start, [np.float32(0)] * len(shapes)
    elif earlier is not None:
        weights = paint_weights(obj)
        shown = obj.adaptive_fairing.strength
        carried = [earlier.offset(shown * each) for each in relative]
        if weights is not None:
            carried = [weights[:, None] * each for each in carried]
    else:
        carried = [np.float32(min(each, 1.0)) * (start - original) for each in relative]
    offsets = tuple(move + (shape - start) for move, shape in zip(carried, shapes, strict=True))
    clear(obj)
    stored = StoredResult(original, tuple(strengths), offsets)
    write_stored(obj.data, stored, with_original=way == "LIVE")
    record = obj.adaptive_fairing
    record.result = way
    set_strengths(record, strengths, strength)
    if way == "MODIFIER":
        if obj.data.shape_keys is None:
            write_shown(obj, original)
        else:
            remember_coordinates(record)
        modifier.add(obj, stored.strengths, strength)
    else:
        write_shown(obj, shown_by(obj))


def store_steps(
    obj: bpy.types.Object, start: SingleArray, shapes: list[SingleArray], output: str
) -> None:
    """Store the steps of the paper's methods as shape keys, or move the vertices.

    Parameters
    ----------
    obj, start, shapes
        As in `store_strengths`.
    output
        Identifier of `OutputProperties.output`.
    """
    original, frames = original_positions(obj), animated_frames(obj)
    clear(obj)
    write_positions(obj.data, start)
    if output == "FINAL_SHAPE":
        write_final_shape(obj, shapes[-1])
        return
    write = write_relative_keys if output == "RELATIVE_KEYS" else write_absolute_keys
    write(obj, shapes)
    if frames is not None and output != "RELATIVE_KEYS":
        animate_evolution(obj, *frames)
    obj.adaptive_fairing.result = "KEYS"
    if original is not None and not np.array_equal(original, start):
        write_vectors(obj.data, ORIGINAL, original)


def apply(obj: bpy.types.Object) -> None:
    """Keep the shape that is shown, and nothing else of the runs.

    Raises
    ------
    InputError
        There is no result.
    """
    _required_original(obj)
    mesh = obj.data
    if has_foreign_keys(mesh):  # of a "MODIFIER" result: all keys move along
        offset = shown_by(obj) - read_mesh_coordinates(mesh)
        clear(obj)
        for block in mesh.shape_keys.key_blocks:
            block.points.foreach_set("co", np.ravel(read_key(block) + offset))
        mesh.update()
        return
    shown = shown_positions(obj)
    clear(obj)
    write_positions(mesh, shown)


def discard(obj: bpy.types.Object) -> None:
    """Bring an object back to what it was before the first run that still counts.

    Raises
    ------
    InputError
        There is no result.
    """
    original = _required_original(obj)
    clear(obj)
    if obj.data.shape_keys is None:
        write_positions(obj.data, original)


def show_split(obj: bpy.types.Object, normal: Sequence[float], point: Sequence[float]) -> None:
    """Show the original behind a plane, given in object space.

    Raises
    ------
    InputError
        There is no result.
    """
    original = _required_original(obj)
    record = obj.adaptive_fairing
    split_along(record, normal, point)
    if record.result == "LIVE":  # is the mesh itself, which `split_along` has updated
        return
    if record.result == "MODIFIER" and obj.data.shape_keys is not None:
        original = mixed_keys(obj.data.shape_keys)
    split.add(obj, original, (original - np.float32(point)) @ np.float32(normal) < 0)


def _required_original(obj: bpy.types.Object) -> SingleArray:
    """Positions (n, 3) before the first run that still counts; InputError if no result is left."""
    original = original_positions(obj)
    if original is None:
        raise InputError(rpt_("there is no result on this object"))
    return original


def drop_control(obj: bpy.types.Object) -> None:
    """Forget the control mesh of a refined one."""
    record = obj.adaptive_fairing
    control, record.control = record.control, None
    if control is not None and control.users == 0:
        remove_mesh(control)


def clear(obj: bpy.types.Object) -> None:
    """Remove everything that runs have left on an object; the coordinates stay, or the Basis.

    A colour view must be over, see `coloring.end_view`.
    """
    record = obj.adaptive_fairing
    drop_control(obj)
    modifier.remove(obj)
    if record.result:
        group = obj.vertex_groups.get(PAINT_GROUP)
        if group is not None:
            obj.vertex_groups.remove(group)
    remove_stored(obj.data)
    if not has_foreign_keys(obj.data):
        remove_fairing_keys(obj)
    if record.keeps_density:
        remove_density(obj.data)
    forget(record)
