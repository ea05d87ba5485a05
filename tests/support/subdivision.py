"""Objects under Loop subdivision, and what a test reads of them. Needs bpy."""

import bpy
import numpy as np

from adaptive_fairing.blender.data.mesh_arrays import read_attributes, read_mesh
from adaptive_fairing.core import LimitSurface, TriangleTopology
from support import meshes
from support.objects import add_object


def subdivide(obj, **options):
    """Run the operator on one object."""
    for other in bpy.context.scene.objects:
        other.select_set(other == obj)
    bpy.context.view_layer.objects.active = obj
    return bpy.ops.object.adaptive_fairing_loop_subdivide(**options)


def sphere():
    return add_object(*meshes.random_closed(1))


def surface_of(obj, **options):
    data = read_mesh(obj.data)
    return LimitSurface(
        TriangleTopology(data.triangles, len(data.vertices)), data.vertices, **options
    )


def values_of(mesh, name):
    return next(a.values for a in read_attributes(mesh) if a.name == name)


def edges_of(mesh):
    ends = np.empty(2 * len(mesh.edges), dtype=np.int32)
    mesh.edges.foreach_get("vertices", ends)
    return ends.reshape(-1, 2)


def normals_of(mesh):
    flat = np.empty(3 * len(mesh.loops), dtype=np.float32)
    if hasattr(mesh, "calc_normals_split"):
        mesh.calc_normals_split()
    mesh.corner_normals.foreach_get("vector", flat)
    return flat.reshape(-1, 3)


def bent_boundary():
    """Return the index pairs of three edges in a row on the sphere."""
    faces = meshes.random_closed(1)[1]
    return meshes.edges_of(faces)[:7]
