"""Meshes between Blender and numpy: undeformed positions, and triangles for the solve."""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import ArrayLike, NDArray


def is_shared(mesh: bpy.types.Mesh, among: int = 1) -> bool:
    """Whether a mesh has more users than so many; the fake user does not count."""
    return mesh.users - mesh.use_fake_user > among


def n_triangles(mesh: bpy.types.Mesh) -> int:
    """Count the triangles of the polygons: a polygon of k corners has k - 2."""
    return max(len(mesh.loops) - 2 * len(mesh.polygons), 0)


@dataclass(frozen=True)
class MeshData:
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
