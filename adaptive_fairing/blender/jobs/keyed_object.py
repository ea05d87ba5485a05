"""Faired frames as one object: absolute shape keys that the timeline runs through."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...batch.plan import Item
from ...core import FairingError
from ...files.formats import keeps_axes
from ...files.output_words import FAIRED
from ..data.mesh_arrays import flat_float32, read_positions
from ..data.refined_object import RefineOptions, refine_object
from ..data.shape_keys import keyframe_keys
from ..files.mesh_files import import_mesh, save_blend
from .frames import Frame, object_at_frame


def frame_key_name(frame: int) -> str:
    """Name of the shape key of a frame."""
    return f"Frame {frame}"


def write_frame_keys(
    obj: bpy.types.Object, frames: Sequence[int], positions: Sequence[ArrayLike]
) -> None:
    """Give an object one absolute key per frame, keyframed so that each frame shows its own.

    Parameters
    ----------
    obj
        Mesh object without shape keys, in Object Mode.
    frames
        Frames on the timeline, ascending.
    positions
        Positions at every frame, (n, 3) each, in object space.
    """
    buffers = [flat_float32(shape, obj.data) for shape in positions]
    obj.data.attributes["position"].data.foreach_set("vector", buffers[0])
    for frame, buffer in zip(frames, buffers, strict=True):
        block = obj.shape_key_add(name=frame_key_name(frame), from_mix=False)
        block.points.foreach_set("co", buffer)
    keys = obj.data.shape_keys
    keys.use_relative = False
    keyframe_keys(keys, frames)
    obj.data.update()


def write_keyed_file(
    items: Sequence[Item],
    object_name: str | None,
    output: Path,
    refine: int | None = None,
    *,
    word: str = FAIRED,
) -> None:
    """Put the outputs of a sequence together in a .blend file.

    The object has the polygons, UVs and materials of the first frame's input. If the input is an
    animated object of a .blend file, that object stays beside it, hidden.

    Parameters
    ----------
    items
        Frames in order, whose outputs exist, in the format of `plan.KEYED_SUFFIX`.
    object_name
        Mesh object of the inputs; None if they hold a single one.
    output
        The file to write.
    refine
        As in `FairingJob`; the frames are not refined yet.
    word
        Word in the name of the object beside an animated one, see `files.output_words`.

    Raises
    ------
    FairingError
        A frame has other vertices than the first.
    OSError
        The file cannot be written.
    """
    shapes: list[np.ndarray] = []
    for item in items:
        frame = import_mesh(item.output)
        location = np.array(frame.location, dtype=np.float64)
        if not shapes:
            place = location  # of the first frame; that of a mesh far from the origin is there
        shapes.append((read_positions(frame.data) + (location - place)).astype(np.float32))
        if len(shapes[-1]) != len(shapes[0]):
            raise FairingError(
                f"{item.name} has {len(shapes[-1])} vertices, {items[0].name} has "
                f"{len(shapes[0])}: frames of different topology cannot become one object"
            )
    first = items[0]
    obj = import_mesh(first.input, object_name)
    if first.frame is not None:
        obj = _beside(obj, first.frame, word)
    if keeps_axes(first.input, first.output):
        # The mesh has the axes of the file, its object is turned.
        turn = np.round(np.array(obj.matrix_basis)[:3, :3])
        shapes = [shape + (place - turn.T @ obj.location) for shape in shapes]
    else:
        shapes = [_in_space_of(obj, shape + place) for shape in shapes]
    frames = [item.number for item in items]
    write_frame_keys(obj, frames, shapes)
    if refine is not None:
        refine_object(obj, RefineOptions(refine))
    scene = obj.users_scene[0]
    if first.frame is None:
        scene.frame_start, scene.frame_end = frames[0], frames[-1]
    scene.frame_set(frames[0])
    save_blend(output)


def show_frames(
    obj: bpy.types.Object,
    frames: Sequence[Frame],
    positions: Sequence[ArrayLike],
    *,
    word: str = FAIRED,
) -> bpy.types.Object:
    """Make an object that plays the results beside the animated object, which is hidden.

    Parameters
    ----------
    obj
        Mesh object in the view layer, in Object Mode.
    frames
        Frames as they were read, in order.
    positions
        Results, (n, 3) each, in the object's space at that frame.
    word
        As in `write_keyed_file`.
    """
    scene = obj.users_scene[0]
    current = scene.frame_current
    result = _beside(obj, frames[0].number, word)
    to_result = np.linalg.inv(frames[0].matrix)
    shapes = []
    for frame, shape in zip(frames, positions, strict=True):
        # The object moves from frame to frame; the result stays where the first frame was.
        matrix = to_result @ frame.matrix
        shapes.append(shape @ matrix[:3, :3].T + matrix[:3, 3])
    write_frame_keys(result, [frame.number for frame in frames], shapes)
    scene.frame_set(current)
    return result


def _beside(obj: bpy.types.Object, frame: int, word: str) -> bpy.types.Object:
    """Make an object with the shape of a frame beside an animated object, which is hidden."""
    result = object_at_frame(obj, frame)
    result.name = f"{obj.name} {word}"
    obj.hide_set(True)
    obj.hide_render = True
    return result


def _in_space_of(obj: bpy.types.Object, shape: NDArray[np.float32]) -> NDArray[np.float64]:
    """Transform positions from world space, that of mesh files, to the space of an object."""
    to_object = np.linalg.inv(np.array(obj.matrix_world, dtype=np.float64))
    return shape @ to_object[:3, :3].T + to_object[:3, 3]
