"""Frames of animated and deforming objects, as meshes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import bpy
import numpy as np
from bpy.app.translations import pgettext_rpt as rpt_
from numpy.typing import NDArray

from ...core import InputError
from ...files.errors import FileError
from ..compatibility import show_scene
from ..data.mesh_arrays import MeshData, read_mesh


@dataclass(frozen=True)
class Frame:
    """The surface of an object at a frame.

    Attributes
    ----------
    number
        Number of the frame.
    data
        Mesh in object space.
    matrix
        (4, 4) from object space into the world.
    """

    number: int
    data: MeshData
    matrix: NDArray[np.float64]


def read_frames(obj: bpy.types.Object, numbers: Iterable[int]) -> list[Frame]:
    """Read an animated object at several frames; the scene returns to its present frame.

    Raises
    ------
    InputError
        A frame has no faces, or not those of the first frame.
    """
    scene = obj.users_scene[0]
    current = scene.frame_current
    frames: list[Frame] = []
    try:
        for number in numbers:
            mesh, matrix = evaluated_mesh(obj, number)
            frames.append(Frame(number, read_mesh(mesh), np.array(matrix, dtype=np.float64)))
            bpy.data.meshes.remove(mesh)
            _require_same_faces(frames[0], frames[-1])
    finally:
        scene.frame_set(current)
    return frames


def _require_same_faces(first: Frame, frame: Frame) -> None:
    if len(first.data.triangles) == 0:
        raise InputError(rpt_("there are no faces at frame {:d}").format(first.number))
    same_vertices = len(frame.data.vertices) == len(first.data.vertices)
    if not (same_vertices and np.array_equal(frame.data.triangles, first.data.triangles)):
        raise InputError(
            rpt_("the faces at frame {:d} are not those of frame {:d}").format(
                frame.number, first.number
            )
        )


def object_at_frame(obj: bpy.types.Object, frame: int) -> bpy.types.Object:
    """Make an object with the shape and the place of another one at a frame.

    The shape is the one that the viewport shows, with modifiers, shape keys, armatures, simulations
    and caches; the new object has none of these. The scene stays at the frame.

    Parameters
    ----------
    obj
        Mesh object in a scene.
    frame
        Frame on the scene's timeline.

    Raises
    ------
    FileError
        The object has no faces there.
    """
    mesh, matrix = evaluated_mesh(obj, frame)
    if len(mesh.polygons) == 0:
        raise FileError(f"{obj.name!r} has no faces at frame {frame}: there is no surface to fair")
    result = bpy.data.objects.new(obj.name, mesh)
    result.matrix_world = matrix
    obj.users_scene[0].collection.objects.link(result)
    return result


def evaluated_mesh(obj: bpy.types.Object, frame: int) -> tuple[bpy.types.Mesh, object]:
    """Mesh of an object at a frame, as a copy, and the object's matrix (4, 4) into the world."""
    graph = go_to_frame(obj, frame)
    evaluated = obj.evaluated_get(graph)
    mesh = bpy.data.meshes.new_from_object(
        evaluated, preserve_all_data_layers=True, depsgraph=graph
    )
    return mesh, evaluated.matrix_world.copy()


def go_to_frame(obj: bpy.types.Object, frame: int) -> bpy.types.Depsgraph:
    """Evaluate the scene of an object at a frame."""
    scene = obj.users_scene[0]
    show_scene(scene)
    scene.frame_set(frame)
    return bpy.context.evaluated_depsgraph_get()
