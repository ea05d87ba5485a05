"""Loop subdivision of an object's mesh with all its data: keys, attributes, groups, normals.

The mesh of the object is not changed: the object gets a new one, and the old one is removed only if
nothing else uses it.  *Make Single User* does the same before a destructive edit.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from ...core import FairingError
from ...core.surface.cut_surface import CutSurface
from ...core.surface.memory_estimate import require_memory
from ...core.surface.refined_net import RefinedNet
from ...core.surface.refined_topology import edge_keys
from .mesh_arrays import (
    GEOMETRY,
    AttributeArray,
    flat_float32,
    integers,
    is_shared,
    n_triangles,
    read_attributes,
    read_or_zeros,
    read_positions,
    write_attribute,
    write_positions,
)
from .refinement_cache import RefinedShape, refinement_of
from .shape_keys import read_keys, write_keys
from .targets import remove_mesh
from .vertex_groups import read_groups, write_groups

SHARP_CREASE = 1.0
"""Blender's weight of a crease that is infinitely sharp."""

RENEWED = ("custom_normal", "sharp_face", ".select_vert", ".select_edge", ".select_poly")
"""Attributes that the refined mesh does not inherit: it is smooth, has its own normals, and has no
selection."""


@dataclass(frozen=True)
class RefineOptions:
    """Options of a refinement.

    Attributes
    ----------
    levels : int
        Steps; each cuts every triangle into four.  0 leaves the polygons as they are.
    on_limit : bool
        Vertices on the limit surface; otherwise they are the control points of the finer mesh.
    sharp_creases : bool
        Edges marked sharp or with a crease of 1 stay sharp, vertices with a crease of 1 stay.
    exact_normals : bool
        Custom normals from the limit surface; otherwise Blender's own average.
    """

    levels: int = 1
    on_limit: bool = True
    sharp_creases: bool = True
    exact_normals: bool = True


def refine_object(
    obj: bpy.types.Object, options: RefineOptions, shapes: Collection[str] = ()
) -> tuple[str, ...]:
    """Give an object a refined mesh.

    Parameters
    ----------
    obj
        Local mesh object in Object Mode.
    options
    shapes
        Names of vector attributes of the points that are positions or differences of positions,
        and are refined like the positions.  Normals then follow motions.

    Returns
    -------
    tuple of str
        What was cut, turned or left out because the mesh is not an oriented manifold.

    Raises
    ------
    FairingError
        The mesh has no faces, its positions are not finite, or the refined mesh does not fit into
        memory.
    """
    mesh = obj.data
    n_keys = len(mesh.shape_keys.key_blocks) if mesh.shape_keys is not None else 0
    n_arrays = len(mesh.attributes) - len(GEOMETRY) + n_keys + len(obj.vertex_groups)
    require_memory(n_triangles(mesh), options.levels, n_arrays)
    source = _Source(mesh, options.sharp_creases, options.levels)
    refinement, net = source.refinement, source.refinement.net(options.levels)
    keys = read_keys(mesh)

    def refined(places: NDArray, has_normals: bool = False) -> RefinedShape:
        return refinement.shape(
            places, options.levels, on_limit=options.on_limit, has_normals=has_normals
        )

    first, *others = keys.positions if keys is not None else [read_positions(mesh)]
    start = refined(first, options.exact_normals)
    positions = [start.positions, *(refined(each).positions for each in others)]
    normals = start.normals
    moves = bool(shapes) or keys is not None or len(obj.modifiers) > 0
    attributes = [
        array._replace(values=refined(array.values).positions)
        if array.name in shapes
        else array._replace(values=source.refined(net, array))
        for array in read_attributes(mesh, RENEWED)
        if options.levels or array.name in shapes
    ]
    if options.levels == 0:
        _move_vertices(obj, positions, attributes)
        if normals is not None and len(normals) == len(mesh.vertices):
            write_normals(obj.data, normals, follow_motion=moves)
        return refinement.cut.notes
    groups = read_groups(obj)

    new = mesh.copy()
    new.clear_geometry()
    loose = source.loose_edges
    fill(new, positions[0], net.triangles, np.concatenate([net.edges, loose]), net.sides)
    write_attributes(new, mesh, attributes)
    obj.data = new
    write_groups(obj, [group.with_weights(net.of_points) for group in groups])
    new.update()
    if normals is not None:
        write_normals(new, normals, follow_motion=moves)
    if keys is not None:
        write_keys(obj, keys, positions)
    _retire(mesh, new)
    return refinement.cut.notes


def control_surface(mesh: bpy.types.Mesh) -> CutSurface:
    """Make the limit surface of a mesh in Object Mode, with its creases.

    Raises
    ------
    FairingError
        The mesh has no faces.
    """
    return _Source(mesh, sharp_creases=True, levels=0).refinement.cut


class _Source:
    """A mesh as triangles, and the refinement of its elements."""

    def __init__(self, mesh: bpy.types.Mesh, sharp_creases: bool, levels: int) -> None:
        if not len(mesh.polygons):
            raise FairingError("the mesh has no faces: there is no surface to refine")
        is_triangulated = len(mesh.loops) == 3 * len(mesh.polygons)
        if is_triangulated:
            data = mesh.attributes[".corner_vert"].data
            self.triangles = integers(data, "value", 1).reshape(-1, 3)
            self.corners, self.polygons = slice(None), slice(None)
        else:
            mesh.calc_loop_triangles()
            self.triangles = integers(mesh.loop_triangles, "vertices", 3)
            self.corners = integers(mesh.loop_triangles, "loops", 3).reshape(-1)
            self.polygons = integers(mesh.loop_triangles, "polygon_index", 1)
        self.ends = integers(mesh.attributes[".edge_verts"].data, "value", 2)
        creases, held = np.empty((0, 2), dtype=np.int64), np.empty(0, dtype=np.int64)
        if sharp_creases:
            n_edges = len(self.ends)
            is_sharp = read_or_zeros(mesh, "sharp_edge", n_edges, bool)
            is_sharp |= read_or_zeros(mesh, "crease_edge", n_edges) >= SHARP_CREASE
            creases = self.ends[is_sharp]
            pinned = read_or_zeros(mesh, "crease_vert", len(mesh.vertices)) >= SHARP_CREASE
            held = np.flatnonzero(pinned)
        self.refinement = refinement_of(self.triangles, len(mesh.vertices), creases, held, levels)
        edges = self.refinement.net(0).edges
        self._is_loose = np.zeros(len(self.ends), dtype=bool)
        if not is_triangulated or len(edges) != len(self.ends):
            keys, n = edge_keys(self.ends, len(mesh.vertices)), len(mesh.vertices)
            self._is_loose = ~np.isin(keys, edge_keys(edges, n))

    @property
    def loose_edges(self) -> NDArray[np.int64]:
        """Edges without a face, which stay one edge each."""
        return self.ends[self._is_loose]

    def refined(self, net: RefinedNet, array: AttributeArray) -> NDArray:
        """Values of an attribute on the refined mesh."""
        values = array.values
        if array.domain == "POINT":
            return net.of_points(values)
        if array.domain == "CORNER":
            return net.of_corners(values[self.corners])
        if array.domain == "FACE":
            return net.of_triangles(values[self.polygons])
        inside = "" if values.dtype == object else values.dtype.type(0)
        return np.concatenate([net.of_edges(values, self.ends, inside), values[self._is_loose]])


def _move_vertices(
    obj: bpy.types.Object, shapes: list[NDArray[np.float32]], attributes: list[AttributeArray]
) -> None:
    """Move the vertices of all shapes, on a mesh that only this object uses."""
    if is_shared(obj.data):
        obj.data = obj.data.copy()
    mesh = obj.data
    if mesh.shape_keys is not None:
        for block, shape in zip(mesh.shape_keys.key_blocks, shapes, strict=True):
            block.points.foreach_set("co", flat_float32(shape, mesh))
    for array in attributes:
        write_attribute(mesh, array)
    write_positions(mesh, shapes[0])


def _retire(old: bpy.types.Mesh, new: bpy.types.Mesh) -> None:
    """Remove a mesh that nothing uses any more, and pass its name on."""
    if old.users == 0:
        name = old.name
        remove_mesh(old)
        new.name = name


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
