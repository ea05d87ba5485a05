"""Shape keys copied to another mesh: positions, values, animation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
from numpy.typing import ArrayLike, NDArray

from .mesh_arrays import flat_float32, read_key

SETTINGS = ("interpolation", "mute", "slider_min", "slider_max", "value", "vertex_group")
"""Properties of a key besides its shape, its place and the key that it is relative to."""


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
        for name in SETTINGS:
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
