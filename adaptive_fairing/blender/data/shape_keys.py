"""Shape keys of a mesh: the evolution, and copies on another mesh.

"Basis" is the input, "Fairing 1", "Fairing 2", … are the steps of the evolution.

Absolute keys form one movie: `Key.eval_time` runs through them, so that one slider scrubs the
evolution. Relative keys are the kind that glTF and FBX can export. Keys of the user are never
changed: the writers refuse a mesh that has some.
"""

from __future__ import annotations

import re
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import compatibility
from .mesh_arrays import (
    flat_float32,
    read_key,
    read_mesh_coordinates,
    read_positions,
    write_positions,
)

BASIS = "Basis"
_STEP_NAME = re.compile(r"Fairing (\d+)")

COPIED = ("interpolation", "mute", "slider_min", "slider_max", "value", "vertex_group")
"""Properties of a key besides its shape, its place and the key that it is relative to."""


def step_key_name(index: int) -> str:
    """Name of the key of a step, counted from 1."""
    return f"Fairing {index}"


def has_foreign_keys(mesh: bpy.types.Mesh) -> bool:
    """Whether the mesh has shape keys other than those that this module writes."""
    keys = mesh.shape_keys
    return keys is not None and _steps(keys) != list(range(1, len(keys.key_blocks)))


def has_step_keys(mesh: bpy.types.Mesh) -> bool:
    """Whether the mesh has the shape keys that this module writes; some may have been deleted."""
    return mesh.shape_keys is not None and bool(_steps(mesh.shape_keys))


def _steps(keys: bpy.types.Key) -> list[int] | None:
    """Step numbers of the keys, without the Basis; None if any key is not ours."""
    first, *others = (block.name for block in keys.key_blocks)
    matches = [_STEP_NAME.fullmatch(name) for name in others]
    if first != BASIS or not all(matches):
        return None
    steps = [int(match[1]) for match in matches]
    return steps if steps == sorted(steps) else None


def evolution_keys(obj: bpy.types.Object) -> bpy.types.Key | None:
    """Return the absolute shape keys of an object, which the Evolution slider moves through."""
    keys = getattr(obj.data, "shape_keys", None)
    return keys if keys is not None and not keys.use_relative else None


def shown_step(keys: bpy.types.Key) -> float:
    """Find the step that absolute fairing keys show, by its number; 0 is the Basis."""
    frames = [block.frame for block in keys.key_blocks]
    return float(np.interp(keys.eval_time, frames, [0, *_steps(keys)]))


def last_step(keys: bpy.types.Key) -> int:
    """Find the number of the last step among fairing keys."""
    return _steps(keys)[-1]


def show_step(keys: bpy.types.Key, step: float) -> None:
    """Show absolute fairing keys at the number of a step, as `show_time` does."""
    frames = [block.frame for block in keys.key_blocks]
    show_time(keys, float(np.interp(step, [0, *_steps(keys)], frames)))


def keys_checksum(keys: bpy.types.Key, before: int = 0) -> int:
    """Checksum of the names and shapes of keys, and of what has the checksum `before`."""
    for block in keys.key_blocks:
        before = zlib.crc32(read_key(block), zlib.crc32(block.name.encode(), before))
    return before


def shown_positions(mesh: bpy.types.Mesh) -> NDArray[np.float32]:
    """Positions (n, 3) that a mesh shows: mixed keys if it has some, else its coordinates."""
    return mixed_keys(mesh.shape_keys) if mesh.shape_keys else read_mesh_coordinates(mesh)


def mixed_keys(keys: bpy.types.Key) -> NDArray[np.float32]:
    """Mix shape keys as Blender does, (n, 3).

    Relative keys count by their values, without vertex groups and muting. Absolute keys are
    interpolated between the two neighbours of the evaluation time.
    """
    blocks = keys.key_blocks
    if not keys.use_relative:
        after, part = _place(keys)
        before = read_key(blocks[after - 1])
        return before + np.float32(part) * (read_key(blocks[after]) - before)
    shown = read_key(keys.reference_key)
    for block in blocks[1:]:
        if block.value:
            shown += np.float32(block.value) * (read_key(block) - read_key(block.relative_key))
    return shown


def show_time(keys: bpy.types.Key, time: float) -> None:
    """Show absolute keys at a time, to exporters too.

    Blender ignores the values of absolute keys. The exporters of glTF and FBX write the keys and
    the values; with the values 1 - t and t of the two neighbours they give the same shape. Other
    exporters write the coordinates of the mesh itself, unless they apply modifiers. FBX adds the
    keys to these coordinates, so between the Basis, which has no value, and the first key the
    coordinates must be the Basis.
    """
    keys.eval_time = time
    after, part = _place(keys)
    for block in keys.key_blocks:
        block.value = 0.0
    keys.key_blocks[after].value = part
    if after > 1:
        keys.key_blocks[after - 1].value = 1.0 - part
    is_beside_basis = after == 1 and part < 1
    write_positions(
        keys.user, read_key(keys.reference_key) if is_beside_basis else mixed_keys(keys)
    )


def _place(keys: bpy.types.Key) -> tuple[int, float]:
    """Index of the key after the evaluation time, and how far from the key before it is, 0 to 1."""
    frames = [block.frame for block in keys.key_blocks]
    after = int(np.clip(np.searchsorted(frames, keys.eval_time), 1, len(frames) - 1))
    span = frames[after] - frames[after - 1]
    return after, float(np.clip((keys.eval_time - frames[after - 1]) / span, 0.0, 1.0))


def write_absolute_keys(
    obj: bpy.types.Object, positions: Sequence[ArrayLike], shown: int = -1
) -> None:
    """Replace the object's fairing keys by absolute ones, one of which is shown.

    Parameters
    ----------
    obj
        Mesh object in Object Mode.
    positions
        Positions of every step, (n, 3) each, in object space, without the input; at least one.
    shown
        Index of the step to show, by default the last.

    Raises
    ------
    FairingError
        The mesh has shape keys of its own.
    """
    keys, block = _write_keys(obj, positions, shown)
    keys.use_relative = False
    # Frames are 0, 10, 20, 30.0000019 …: read, never computed.
    show_time(keys, block.frame)


def write_relative_keys(
    obj: bpy.types.Object, positions: Sequence[ArrayLike], shown: int = -1
) -> None:
    """Replace the object's fairing keys by relative ones; only the shown one has the value 1.

    Parameters and errors as in `write_absolute_keys`.
    """
    keys, shown_block = _write_keys(obj, positions, shown)
    keys.use_relative = True
    for block in keys.key_blocks:
        # Blender 5.0 changed the value of a new key from 0 to 1.
        block.value = 1.0 if block == shown_block else 0.0
    write_positions(obj.data, mixed_keys(keys))


def remove_fairing_keys(obj: bpy.types.Object) -> None:
    """Remove the fairing keys and their animation; the vertices return to the Basis.

    Raises
    ------
    FairingError
        The mesh has shape keys of its own.
    """
    mesh = obj.data
    if mesh.shape_keys is None:
        return
    if has_foreign_keys(mesh):
        from ...core import FairingError  # enabling the add-on does not load the core

        raise FairingError(
            f"mesh {mesh.name!r} has shape keys of its own, which fairing would destroy: "
            "fair a copy of the object without them"
        )
    basis = read_positions(mesh)
    clear_animation(mesh.shape_keys)
    obj.shape_key_clear()
    write_positions(mesh, basis)


def clear_animation(keys: bpy.types.Key) -> None:
    """Remove the animation of keys, and its action if nothing else uses it."""
    action = keys.animation_data.action if keys.animation_data is not None else None
    keys.animation_data_clear()
    if action is not None and action.users == 0:
        bpy.data.actions.remove(action)


def remove_step_keys(obj: bpy.types.Object) -> None:
    """Remove the keys of steps; other keys stay, as relative keys."""
    keys = obj.data.shape_keys
    if keys is None:
        return
    for block in list(keys.key_blocks):
        if _STEP_NAME.fullmatch(block.name):
            obj.shape_key_remove(block)
    if has_foreign_keys(obj.data):
        keys.use_relative = True
        write_positions(obj.data, mixed_keys(keys))
    else:
        remove_fairing_keys(obj)


def animate_evolution(obj: bpy.types.Object, frame_start: float, frame_end: float) -> None:
    """Let the timeline run through the absolute keys: one keyframe per step, evenly spaced.

    Parameters
    ----------
    obj
        Object that `write_absolute_keys` has written.
    frame_start, frame_end
        Frames that show the input and the last step.
    """
    keys = obj.data.shape_keys
    last = len(keys.key_blocks) - 1
    length = frame_end - frame_start
    keyframe_keys(keys, [frame_start + length * index / last for index in range(last + 1)])


def animated_frames(obj: bpy.types.Object) -> tuple[float, float] | None:
    """First and last frame of the animated evolution; None if it is not animated."""
    keys = obj.data.shape_keys
    if keys is None or keys.use_relative:
        return None
    for curve in compatibility.fcurves(keys):
        if curve.data_path == "eval_time" and len(curve.keyframe_points) > 1:
            return curve.keyframe_points[0].co[0], curve.keyframe_points[-1].co[0]
    return None


def keyframe_keys(keys: bpy.types.Key, frames: Sequence[float]) -> None:
    """Show every absolute key at a frame of its own, with linear interpolation between them."""
    for frame, block in zip(frames, keys.key_blocks, strict=True):
        # The time of a key is read, never computed: 0, 10, 20, 30.0000019 …
        keys.eval_time = block.frame
        keys.keyframe_insert("eval_time", frame=frame)
    for curve in compatibility.fcurves(keys):
        if curve.data_path == "eval_time":
            for point in curve.keyframe_points:
                point.interpolation = "LINEAR"


def _write_keys(
    obj: bpy.types.Object, positions: Sequence[ArrayLike], shown: int
) -> tuple[bpy.types.Key, bpy.types.ShapeKey]:
    """Write keys for the input and every step; return them, and the key of the step to show."""
    mesh = obj.data
    # All shapes are checked before anything is touched.
    buffers = [flat_float32(step, mesh) for step in positions]
    remove_fairing_keys(obj)
    obj.shape_key_add(name=BASIS, from_mix=False)
    for index, buffer in enumerate(buffers, start=1):
        block = obj.shape_key_add(name=step_key_name(index), from_mix=False)
        block.points.foreach_set("co", buffer)
    obj.active_shape_key_index = 1 + range(len(buffers))[shown]
    return mesh.shape_keys, mesh.shape_keys.key_blocks[obj.active_shape_key_index]


@dataclass(frozen=True)
class KeyShapes:
    """The keys of a mesh.

    Attributes
    ----------
    source
        Blender's block, from which the animation is copied.
    positions
        (n, 3) of every key, in order.
    """

    source: bpy.types.Key
    positions: list[NDArray[np.float64]]


def read_keys(mesh: bpy.types.Mesh) -> KeyShapes | None:
    """Read all keys of a mesh in Object Mode; None if it has none."""
    if mesh.shape_keys is None:
        return None
    blocks = mesh.shape_keys.key_blocks
    return KeyShapes(mesh.shape_keys, [read_key(block).astype(np.float64) for block in blocks])


def write_keys(obj: bpy.types.Object, keys: KeyShapes, positions: Sequence[ArrayLike]) -> None:
    """Give an object's mesh the keys of another, with other positions.

    Parameters
    ----------
    obj
        Object whose mesh has as many vertices as the positions; its own keys are replaced.
    keys
        Keys to write; their source must still exist.
    positions
        (n, 3) of every key.
    """
    shown, only_this = obj.active_shape_key_index, obj.show_only_shape_key
    clear_keys(obj)
    source = keys.source
    for block, shape in zip(source.key_blocks, positions, strict=True):
        if obj.data.shape_keys is not None:
            # A new absolute key stands where the evaluation time is.
            obj.data.shape_keys.use_relative = False
            obj.data.shape_keys.eval_time = block.frame
        new = obj.shape_key_add(name=block.name, from_mix=False)
        new.points.foreach_set("co", flat_float32(shape, obj.data))
    target = obj.data.shape_keys
    for block in source.key_blocks:
        target.key_blocks[block.name].relative_key = target.key_blocks[block.relative_key.name]
    target.use_relative = source.use_relative
    copy_settings(source, target)
    obj.active_shape_key_index, obj.show_only_shape_key = shown, only_this


def copy_settings(source: bpy.types.Key, target: bpy.types.Key) -> None:
    """Copy values, evaluation time and animation from keys of the same names."""
    for block in source.key_blocks:
        new = target.key_blocks.get(block.name)
        if new is None:
            continue
        for name in COPIED:
            setattr(new, name, getattr(block, name))
    target.eval_time = source.eval_time
    target.animation_data_clear()
    _copy_animation(source, target)


def clear_keys(obj: bpy.types.Object) -> None:
    """Remove all keys of an object's mesh."""
    if obj.data.shape_keys is not None:
        name = obj.data.shape_keys.name
        obj.shape_key_clear()
        left = bpy.data.shape_keys.get((name, None))
        if left is not None:
            # Blender leaves a copied block behind, counted as used, though nothing uses it.
            bpy.data.batch_remove([left])


def _copy_animation(source: bpy.types.Key, target: bpy.types.Key) -> None:
    """Give the target the same action, and copies of the drivers."""
    animation: Any = source.animation_data
    if animation is None:
        return
    copy: Any = target.animation_data_create()
    copy.action = animation.action
    if animation.action is not None and hasattr(animation, "action_slot"):  # since Blender 4.4
        copy.action_slot = animation.action_slot
    for driver in animation.drivers:
        copy.drivers.from_existing(src_driver=driver)
