"""Regions: the objects of a run, the weight of every vertex, the part under a brush."""

from __future__ import annotations

from typing import NamedTuple

import bpy
import numpy as np
from bpy.app.translations import pgettext_rpt as rpt_
from numpy.typing import NDArray

from .mesh_arrays import integers, read_mesh_coordinates, read_or_zeros, read_values
from .vertex_groups import group_weights

MODES = ("OBJECT", "EDIT", "SCULPT")
SCULPT_MASK = ".sculpt_mask"
DYNTOPO = "Turn off dynamic topology sculpting"
"""Refusal: while it is on, Blender shows another mesh than the one that can be read."""

FACE_SET = ".sculpt_face_set"
FULL_PART = 0.5
"""Fraction of the radius within which the weight is 1; from there it falls to 0."""


class BrushRegion(NamedTuple):
    """A ball in object space, and the polygon that was pointed at."""

    centre: tuple[float, float, float]
    radius: float
    polygon: int

    def weights(self, mesh: bpy.types.Mesh) -> NDArray[np.float64]:
        """Weights (n,) in [0, 1] of the vertices of a mesh in Object Mode."""
        away = read_mesh_coordinates(mesh) - np.float32(self.centre)
        rest = (1 - np.linalg.norm(away, axis=1).astype(np.float64) / self.radius) / (1 - FULL_PART)
        rest = np.clip(rest, 0.0, 1.0)
        weights = rest**2 * (3 - 2 * rest)
        weights[self._is_beyond(mesh)] = 0.0
        return weights

    def _is_beyond(self, mesh: bpy.types.Mesh) -> NDArray[np.bool_]:
        """Whether each vertex is hidden or has a face of another face set, (n,)."""
        is_beyond = read_or_zeros(mesh, ".hide_vert", len(mesh.vertices), bool)
        if FACE_SET in mesh.attributes and self.polygon < len(mesh.polygons):
            face_set = integers(mesh.attributes[FACE_SET].data, "value", 1)
            corner_set = np.repeat(face_set, integers(mesh.polygons, "loop_total", 1))
            corners = integers(mesh.attributes[".corner_vert"].data, "value", 1)
            is_beyond[corners[corner_set != face_set[self.polygon]]] = True
        return is_beyond


def target_objects(context: bpy.types.Context) -> list[bpy.types.Object]:
    """Mesh objects to work on: all that are selected, or all in the mode of the active object."""
    active = context.active_object
    if active is None or active.mode == "OBJECT":
        selected = context.selected_objects
        return [obj for obj in selected if obj.type == "MESH"]
    if active.mode == "EDIT":
        return [obj for obj in context.objects_in_mode if obj.type == "MESH"]
    return [active] if active.type == "MESH" else []


def refusal(context: bpy.types.Context) -> str | None:
    """Reason why no run can start here, and what to do; None if one can."""
    active = context.active_object
    if active is not None and active.mode not in MODES:
        return "Change to Object Mode, Edit Mode or Sculpt Mode"
    if active is not None and active.mode == "SCULPT":
        if active.use_dynamic_topology_sculpting:
            return DYNTOPO
        if any(modifier.type == "MULTIRES" for modifier in active.modifiers):
            return "Leave Sculpt Mode: the mask of a multiresolution sculpture cannot be read"
    if not target_objects(context):
        return "Select a mesh object"
    return None


def sculpt_mask(mesh: bpy.types.Mesh) -> NDArray[np.float32] | None:
    """Read the mask of Sculpt Mode, (n,) in [0, 1], in Object Mode; None if there is none."""
    if SCULPT_MASK not in mesh.attributes:
        return None
    return np.clip(read_values(mesh.attributes[SCULPT_MASK]), 0.0, 1.0)


def vertex_weights(
    obj: bpy.types.Object,
    mode: str,
    n: int,
    *,
    use_region: bool,
    vertex_group: str,
    invert: bool,
    hold_sharp: bool = False,
    brush: BrushRegion | None = None,
) -> NDArray[np.float64] | None:
    """Fraction of the smoothing that every vertex gets.

    Parameters
    ----------
    obj
        Mesh object in Object Mode, where selection and mask can be read.
    mode
        Mode in which the user started the run; decides whether selection or mask count.
    n
        Number of vertices to smooth, the first of the mesh: those of the control mesh.
    use_region
        Whether the selection in Edit Mode, or the mask in Sculpt Mode, limits the smoothing.
    vertex_group
        Name of a vertex group whose weights scale the smoothing; empty for none.
    invert
        Whether to take one minus the weights of the group.
    hold_sharp
        Whether the vertices of edges that are marked sharp stay where they are.
    brush
        Region that limits the smoothing, if there is one.

    Returns
    -------
    (n,) array in [0, 1], or None
        None if nothing limits the smoothing.

    Raises
    ------
    InputError
        The object has no such vertex group, or every vertex has the weight 0.
    """
    from ...core import InputError

    mesh = obj.data
    factors = [] if brush is None else [brush.weights(mesh)]
    if use_region and mode == "EDIT":
        selected = np.zeros(len(mesh.vertices), dtype=bool)
        mesh.vertices.foreach_get("select", selected)
        if selected.any():
            factors.append(selected.astype(np.float64))
    mask = sculpt_mask(mesh) if use_region and mode == "SCULPT" else None
    if mask is not None:
        factors.append(1.0 - mask.astype(np.float64))
    if vertex_group:
        group = obj.vertex_groups.get(vertex_group)
        if group is None:
            raise InputError(rpt_("there is no vertex group {!r}").format(vertex_group))
        weights = group_weights(obj, group).astype(np.float64)
        factors.append(1.0 - weights if invert else weights)
    if hold_sharp and "sharp_edge" in mesh.attributes:
        ends = integers(mesh.attributes[".edge_verts"].data, "value", 2)
        is_free = np.ones(len(mesh.vertices))
        is_free[ends[read_or_zeros(mesh, "sharp_edge", len(ends), bool)]] = 0.0
        factors.append(is_free)
    if not factors:
        return None
    product = np.prod(factors, axis=0)[:n]
    if not product.any():
        raise InputError(rpt_("selection, mask and vertex group leave no vertex to smooth"))
    return product
