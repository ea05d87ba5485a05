"""Meshes built from arrays: triangles, edges, attributes and normals."""

from __future__ import annotations

from collections.abc import Iterable

import bpy
import numpy as np
from numpy.typing import NDArray

from .attribute_arrays import AttributeArray, write_attribute
from .mesh_arrays import flat_float32


def integers(collection: bpy.types.bpy_prop_collection, name: str, width: int) -> NDArray[np.int32]:
    """Read whole numbers of all elements, (n,) or (n, width)."""
    values = np.empty(width * len(collection), dtype=np.int32)
    collection.foreach_get(name, values)
    return values if width == 1 else values.reshape(-1, width)


def fill(
    mesh: bpy.types.Mesh,
    positions: NDArray[np.float64],
    triangles: NDArray,
    edges: NDArray,
    sides: NDArray,
) -> None:
    """Fill an empty mesh.

    Parameters
    ----------
    mesh
        Mesh without geometry.
    positions
        (n, 3) coordinates of the vertices.
    triangles
        (m, 3) vertices of each triangle.
    edges
        (e, 2) vertices of each edge, also of edges without a triangle.
    sides
        (m, 3) edge from corner k to corner k + 1 of each triangle.
    """
    mesh.vertices.add(len(positions))
    mesh.edges.add(len(edges))
    mesh.loops.add(triangles.size)
    mesh.polygons.add(len(triangles))
    attributes = mesh.attributes
    attributes["position"].data.foreach_set("vector", flat_float32(positions, mesh))
    attributes[".edge_verts"].data.foreach_set("value", _flat_int32(edges))
    attributes[".corner_vert"].data.foreach_set("value", _flat_int32(triangles))
    attributes[".corner_edge"].data.foreach_set("value", _flat_int32(sides))
    starts = np.arange(0, triangles.size, 3, dtype=np.int32)
    mesh.polygons.foreach_set("loop_start", starts)


def write_attributes(
    mesh: bpy.types.Mesh, source: bpy.types.Mesh, arrays: Iterable[AttributeArray]
) -> None:
    """Write attributes; the same UV maps and colours are active as in the source."""
    for array in arrays:
        write_attribute(mesh, array)
    for layer in source.uv_layers:
        mesh.uv_layers[layer.name].active_render = layer.active_render
    if source.uv_layers:
        mesh.uv_layers.active_index = source.uv_layers.active_index
    # By names: an index of -1, where no colour is chosen, Blender does not take back.
    for name in ("active_color_name", "default_color_name"):
        setattr(mesh.attributes, name, getattr(source.attributes, name) or "")


def write_normals(mesh: bpy.types.Mesh, normals: NDArray[np.float64], follow_motion: bool) -> None:
    """Shade a mesh with normals of its vertices (n, 3) or of its corners (3 m, 3).

    Normals that follow the motion of keys and modifiers are stored as angles to Blender's own.
    Plain vectors, which Blender accepts since 4.5, are ten times as fast to write.
    """
    domain = "POINT" if len(normals) == len(mesh.vertices) else "CORNER"
    values = np.ascontiguousarray(normals, dtype=np.float32)
    if not follow_motion and bpy.app.version >= (4, 5, 0):
        write_attribute(mesh, AttributeArray("custom_normal", "FLOAT_VECTOR", domain, values))
        mesh.update()
    elif domain == "POINT":
        mesh.normals_split_custom_set_from_vertices(values)
    else:
        mesh.normals_split_custom_set(values)


def _flat_int32(values: NDArray) -> NDArray[np.int32]:
    return np.ascontiguousarray(values, dtype=np.int32).reshape(-1)
