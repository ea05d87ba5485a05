"""Meshes between Blender and numpy: undeformed positions, triangles, attributes of any type."""

from __future__ import annotations

import zlib
from collections.abc import Iterable
from typing import NamedTuple

import bpy
import numpy as np
from numpy.typing import ArrayLike, NDArray

STORAGE = {
    "FLOAT": ("value", 1, np.float32),
    "INT": ("value", 1, np.int32),
    "INT8": ("value", 1, np.int8),
    "BOOLEAN": ("value", 1, np.bool_),
    "FLOAT2": ("vector", 2, np.float32),
    "FLOAT_VECTOR": ("vector", 3, np.float32),
    "FLOAT_COLOR": ("color", 4, np.float32),
    "BYTE_COLOR": ("color", 4, np.float32),
    "QUATERNION": ("value", 4, np.float32),
    "FLOAT4X4": ("value", 16, np.float32),
    "INT16_2D": ("value", 2, np.int16),
    "INT32_2D": ("value", 2, np.int32),
}
"""Property, numbers per element and their type, by Blender's type; texts are treated separately."""

TEXT = "STRING"

GEOMETRY = ("position", ".edge_verts", ".corner_vert", ".corner_edge")
"""Attributes that are the mesh itself."""


def is_shared(mesh: bpy.types.Mesh, among: int = 1) -> bool:
    """Whether a mesh has more users than so many; the fake user does not count."""
    return mesh.users - mesh.use_fake_user > among


def n_triangles(mesh: bpy.types.Mesh) -> int:
    """Count the triangles of the polygons: a polygon of k corners has k - 2."""
    return max(len(mesh.loops) - 2 * len(mesh.polygons), 0)


class MeshData(NamedTuple):
    """Positions and triangles of a mesh, for the solver.

    Attributes
    ----------
    vertices
        (n, 3) float64, undeformed positions in object space, in Blender's vertex order. Loose
        vertices are included.
    triangles
        (m, 3) int32 indices into `vertices`. Quads and n-gons are cut into triangles for the solve
        only: the mesh keeps its polygons.
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]


def read_mesh(mesh: bpy.types.Mesh) -> MeshData:
    """Read a mesh that is not in Edit Mode.

    Parameters
    ----------
    mesh
        If it has shape keys, their Basis is read, whatever the other keys show.

    Returns
    -------
    MeshData
        Copies, independent of Blender's memory.
    """
    return MeshData(vertices=read_positions(mesh), triangles=read_triangles(mesh))


def welded(data: MeshData) -> tuple[MeshData, NDArray[np.intp]]:
    """Join vertices at the same place, for files that split them at seams and sharp edges.

    Returns
    -------
    MeshData
        The connected surface, without the triangles that lose a corner.
    (n,) array
        Vertex of that surface for every vertex of `data`: positions of the surface, indexed with
        this, are positions of the mesh, equal at split vertices.
    """
    vertices, surface_vertex = np.unique(data.vertices, axis=0, return_inverse=True)
    surface_vertex = surface_vertex.reshape(-1)  # numpy 2.0 gives it a second axis
    triangles = surface_vertex[data.triangles].astype(np.int32)
    has_three_corners = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    return MeshData(vertices, triangles[has_three_corners]), surface_vertex


def weld(mesh: bpy.types.Mesh) -> None:
    """Join the vertices at the same place; UV maps and other data of corners stay separate.

    Parameters
    ----------
    mesh
        Mesh without shape keys, in Object Mode.  Polygons left with two corners are removed.
    """
    import bmesh  # there is none before bpy is imported

    _, first, group = np.unique(
        read_positions(mesh), axis=0, return_index=True, return_inverse=True
    )
    target_of = first[group.reshape(-1)]
    moved = np.flatnonzero(target_of != np.arange(len(target_of)))
    if not len(moved):
        return
    edited = bmesh.new()
    edited.from_mesh(mesh)
    edited.verts.ensure_lookup_table()
    vertices = edited.verts
    pairs = zip(moved.tolist(), target_of[moved].tolist(), strict=True)
    bmesh.ops.weld_verts(edited, targetmap={vertices[a]: vertices[b] for a, b in pairs})
    edited.to_mesh(mesh)
    edited.free()
    mesh.update()


def read_positions(mesh: bpy.types.Mesh) -> NDArray[np.float64]:
    """Read the undeformed positions, (n, 3): the Basis key if there are shape keys."""
    if mesh.shape_keys is None:
        return read_mesh_coordinates(mesh).astype(np.float64)
    return read_key(mesh.shape_keys.reference_key).astype(np.float64)


def read_key(block: bpy.types.ShapeKey) -> NDArray[np.float32]:
    """Read the positions of a shape key, (n, 3)."""
    # Blender converts element by element if the buffer is not float32, which is 200 times slower.
    buffer = np.empty(3 * len(block.points), dtype=np.float32)
    block.points.foreach_get("co", buffer)
    return buffer.reshape(-1, 3)


def read_mesh_coordinates(mesh: bpy.types.Mesh) -> NDArray[np.float32]:
    """Read the coordinates (n, 3) of the mesh itself, without its shape keys."""
    buffer = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    if len(buffer):
        mesh.attributes["position"].data.foreach_get("vector", buffer)
    return buffer.reshape(-1, 3)


def read_triangles(mesh: bpy.types.Mesh) -> NDArray[np.int32]:
    """Read Blender's own triangulation of the polygons, (m, 3); it never adds a vertex."""
    if 0 < len(mesh.loops) == 3 * len(mesh.polygons):
        # There is nothing to cut, and Blender copies an attribute a hundred times as fast.
        corners = np.empty(len(mesh.loops), dtype=np.int32)
        mesh.attributes[".corner_vert"].data.foreach_get("value", corners)
        return corners.reshape(-1, 3)
    mesh.calc_loop_triangles()
    buffer = np.empty(3 * len(mesh.loop_triangles), dtype=np.int32)
    mesh.loop_triangles.foreach_get("vertices", buffer)
    return buffer.reshape(-1, 3)


def write_positions(mesh: bpy.types.Mesh, positions: ArrayLike) -> None:
    """Write the coordinates of the mesh itself; shape keys may override them.

    Parameters
    ----------
    mesh
        Mesh that is not in Edit Mode.
    positions
        (n, 3) in object space.
    """
    mesh.attributes["position"].data.foreach_set("vector", flat_float32(positions, mesh))
    mesh.update()


def checksum(positions: NDArray[np.float32]) -> str:
    """Checksum of coordinates; a text, because properties cannot hold unsigned numbers."""
    return f"{len(positions)}-{zlib.crc32(np.ascontiguousarray(positions))}"


def flat_float32(positions: ArrayLike, mesh: bpy.types.Mesh) -> NDArray[np.float32]:
    """Positions as the contiguous float32 row that Blender expects.

    Raises
    ------
    ValueError
        The array does not hold one point per vertex of the mesh.
    """
    positions = np.asarray(positions)
    expected = (len(mesh.vertices), 3)
    if positions.shape != expected:
        raise ValueError(f"positions of shape {positions.shape}, the mesh needs {expected}")
    return np.ascontiguousarray(positions, dtype=np.float32).ravel()


def integers(collection: bpy.types.bpy_prop_collection, name: str, width: int) -> NDArray[np.int32]:
    """Read whole numbers of all elements, (n,) or (n, width)."""
    values = np.empty(width * len(collection), dtype=np.int32)
    collection.foreach_get(name, values)
    return values if width == 1 else values.reshape(-1, width)


class AttributeArray(NamedTuple):
    """An attribute: numbers (n,) or (n, width), or texts (n,)."""

    name: str
    data_type: str
    domain: str
    values: NDArray


def read_attributes(mesh: bpy.types.Mesh, without: tuple[str, ...] = ()) -> list[AttributeArray]:
    """Read every attribute of a mesh in Object Mode, except its geometry and the given names."""
    arrays = []
    for attribute in mesh.attributes:
        if attribute.name in GEOMETRY or attribute.name in without:
            continue
        if attribute.data_type == TEXT:
            values = np.array([item.value for item in attribute.data], dtype=object)
        elif attribute.data_type in STORAGE:
            values = read_values(attribute)
        else:
            continue
        described = attribute.name, attribute.data_type, attribute.domain
        arrays.append(AttributeArray(*described, values))
    return arrays


def read_values(attribute: bpy.types.Attribute) -> NDArray:
    """Read an attribute of a type in `STORAGE`: (n,) or (n, width)."""
    name, width, dtype = STORAGE[attribute.data_type]
    values = np.empty(width * len(attribute.data), dtype=dtype)
    attribute.data.foreach_get(name, values)
    return values if width == 1 else values.reshape(-1, width)


def write_attribute(mesh: bpy.types.Mesh, array: AttributeArray) -> None:
    """Write an attribute to a mesh in Object Mode; it replaces one of the same name."""
    present = mesh.attributes.get(array.name)
    if present is not None and (present.data_type, present.domain) != array[1:3]:
        mesh.attributes.remove(present)
        present = None
    attribute = present or mesh.attributes.new(array.name, array.data_type, array.domain)
    if array.data_type == TEXT:
        for item, value in zip(attribute.data, array.values, strict=True):
            item.value = value
        return
    name, _, dtype = STORAGE[array.data_type]
    attribute.data.foreach_set(name, np.ascontiguousarray(array.values, dtype=dtype).reshape(-1))


def remove_attributes(mesh: bpy.types.Mesh, names: Iterable[str]) -> None:
    """Remove attributes by their names; a missing one is not an error."""
    attributes = mesh.attributes
    for name in names:
        if name in attributes:
            attributes.remove(attributes[name])
            # Since Blender 5.2 colours stay the active ones after they are gone.
            for which in ("active_color_name", "default_color_name"):
                if getattr(attributes, which) == name:
                    setattr(attributes, which, next(iter(mesh.color_attributes.keys()), ""))


def read_or_zeros(mesh: bpy.types.Mesh, name: str, size: int, dtype: type = np.float32) -> NDArray:
    """Read a number or a flag, (size,); zeros where the mesh has no such attribute."""
    attribute = mesh.attributes.get(name)
    return np.zeros(size, dtype) if attribute is None else read_values(attribute)
