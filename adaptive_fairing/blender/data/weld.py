"""Welding of a mesh that its file has split at seams and sharp edges."""

from __future__ import annotations

import bmesh
import bpy
import numpy as np

from .mesh_arrays import read_positions


def weld(mesh: bpy.types.Mesh) -> None:
    """Join the vertices at the same place; UV maps and other data of corners stay separate.

    Parameters
    ----------
    mesh
        Mesh without shape keys, in Object Mode.  Polygons left with two corners are removed.
    """
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
