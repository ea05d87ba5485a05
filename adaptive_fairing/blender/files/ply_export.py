"""Additions to Blender's .ply exporter: order of vertices with UVs, exact eight-bit colours."""

from __future__ import annotations

import bpy
import numpy as np


def prepare_for_ply(mesh: bpy.types.Mesh) -> list[str]:
    """Change a mesh that is about to be exported, without its UV layers, so that nothing is lost.

    Parameters
    ----------
    mesh
        Receives float attributes "s" and "t" for its UVs, and float colours for its active ones.

    Returns
    -------
    list of str
        Losses in this format, one sentence each.
    """
    if mesh.color_attributes.active_color is not None:
        _store_exact_colors(mesh)
    if _store_uv_by_vertex(mesh):
        return []
    return ["UVs are left out: .ply has one UV per vertex, but the mesh has seams"]


def _store_exact_colors(mesh: bpy.types.Mesh) -> None:
    """Prevent that the exporter, which truncates decimals, darkens colours by one step."""
    old = mesh.color_attributes.active_color
    name, domain = old.name, old.domain
    colors = np.empty(4 * len(old.data), dtype=np.float32)
    old.data.foreach_get("color_srgb", colors)
    mesh.color_attributes.remove(old)
    new = mesh.color_attributes.new(name, "FLOAT_COLOR", domain)
    # A quarter above the whole step survives the rounding on the way to and from linear colours.
    new.data.foreach_set("color_srgb", (np.round(colors * 255) + np.float32(0.25)) / 255)
    mesh.color_attributes.active_color = new


def _store_uv_by_vertex(mesh: bpy.types.Mesh) -> bool:
    """Store the active UVs under their names in .ply; True if all corners at a vertex agree."""
    layer = mesh.uv_layers.active
    if layer is None:
        return True
    corner_vertex = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.loops.foreach_get("vertex_index", corner_vertex)
    uv = np.empty(2 * len(mesh.loops), dtype=np.float32)
    layer.uv.foreach_get("vector", uv)
    uv = uv.reshape(-1, 2)
    by_vertex = np.zeros((len(mesh.vertices), 2), dtype=np.float32)
    by_vertex[corner_vertex] = uv
    if not np.array_equal(by_vertex[corner_vertex], uv):
        return False
    for name, values in zip("st", by_vertex.T, strict=True):
        attribute = mesh.attributes.get(name) or mesh.attributes.new(name, "FLOAT", "POINT")
        attribute.data.foreach_set("value", np.ascontiguousarray(values))
    return True
