"""Animated and deforming objects: the shape that they have at a frame."""

from __future__ import annotations

import bpy

from .files import FileError


def object_at_frame(obj: bpy.types.Object, frame: int) -> bpy.types.Object:
    """Make an object that has the shape and the place of another one at a frame.

    Modifiers, shape keys, armatures, simulations and caches count, as the viewport shows them; the
    new object has none of them. The scene stays at the frame.

    Parameters
    ----------
    obj
        Mesh object in a scene.
    frame
        Of the scene's timeline.

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
    """Copy the mesh of an object as it is at a frame, and give the object's place, a 4x4 matrix."""
    graph = go_to_frame(obj, frame)
    evaluated = obj.evaluated_get(graph)
    mesh = bpy.data.meshes.new_from_object(
        evaluated, preserve_all_data_layers=True, depsgraph=graph
    )
    return mesh, evaluated.matrix_world.copy()


def go_to_frame(obj: bpy.types.Object, frame: int) -> bpy.types.Depsgraph:
    """Evaluate the scene of an object at a frame."""
    scene = obj.users_scene[0]
    if bpy.context.window is not None:
        bpy.context.window.scene = scene
    scene.frame_set(frame)
    return bpy.context.evaluated_depsgraph_get()
