"""Triangle meshes into Blender, through its modifiers, and back. Needs bpy."""

from __future__ import annotations

import bpy
import numpy as np

from .triangles import Faces, FloatArray


def new_object(vertices: FloatArray, triangles: Faces) -> bpy.types.Object:
    """Return a new object of the scene, of positions (n, 3) and triangles (m, 3)."""
    mesh = bpy.data.meshes.new("mesh")
    mesh.from_pydata(vertices, [], triangles)
    item = bpy.data.objects.new("mesh", mesh)
    bpy.context.scene.collection.objects.link(item)
    return item


def add_modifier(item: bpy.types.Object, kind: str, **options: object) -> bpy.types.Modifier:
    """Add a modifier with some of its settings."""
    modifier = item.modifiers.new(kind.lower(), kind)
    for name, value in options.items():
        setattr(modifier, name, value)
    return modifier


def evaluated(item: bpy.types.Object) -> tuple[FloatArray, Faces]:
    """Return the positions (n, 3) and triangles (m, 3) of an object with its modifiers."""
    mesh = item.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    mesh.calc_loop_triangles()
    vertices = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.vertices.foreach_get("co", vertices)
    triangles = np.empty(3 * len(mesh.loop_triangles), dtype=np.int32)
    mesh.loop_triangles.foreach_get("vertices", triangles)
    return vertices.reshape(-1, 3).astype(float), triangles.reshape(-1, 3)
