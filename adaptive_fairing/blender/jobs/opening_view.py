"""First sight of an output .blend: density in colours, the view around it, Denoise beside it."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np
from mathutils import Vector

from ...core import DenoiseSettings
from ..data.coloring import DENSITY, color_name, field_material
from ..data.mesh_arrays import write_positions
from .solve import Solve

GAP = 0.1
"""Gap between the two objects, as a fraction of their width."""


def denoised_beside(
    obj: bpy.types.Object,
    solve: Solve,
    surface_vertex: np.ndarray | slice,
    on_fraction_done: Callable[[float], None] | None = None,
) -> tuple[bpy.types.Object | None, str]:
    """Put the result of `denoise` beside an object whose mesh is still the input.

    Parameters
    ----------
    obj
        Object with the input of the solve, without keys.
    solve
        A solve of the paper's method on it.
    surface_vertex
        Vertex of the solve for each vertex of the mesh.
    on_fraction_done
        As in `Solve`.

    Returns
    -------
    object
        "NAME denoised", to the right of `obj` as Blender's front view shows it; None if there is
        nothing to show.
    str
        A sentence about it for the user.
    """
    beside = Solve(
        solve.vertices,
        solve.triangles,
        DenoiseSettings(boundary=solve.settings.boundary),
        prepared=solve.prepared,
        on_fraction_done=on_fraction_done,
    )
    for _ in beside.run():
        pass
    name = f"{obj.name} denoised"
    if beside.error is not None:
        return None, f"there is no object {name!r}, because Denoise failed: {beside.error}"
    if not beside.is_changed:
        return None, f"there is no object {name!r}, because Denoise leaves this mesh as it is"
    copy = obj.copy()
    copy.data = obj.data.copy()
    copy.name = copy.data.name = name
    write_positions(copy.data, beside.positions[surface_vertex])
    for collection in obj.users_collection:
        collection.objects.link(copy)
    low, high = _corners([obj])
    copy.location.x += (1.0 + GAP) * (high - low).x
    copy.select_set(False)
    noise = beside.denoised.noise_level
    return copy, f"the object {name!r} beside it is the result of Denoise, noise level {noise:.3g}"


def color_by_density(obj: bpy.types.Object) -> None:
    """Render the stored density, unless the mesh has colours or materials of its own."""
    mesh = obj.data
    if mesh.attributes.active_color_name == color_name(DENSITY) and not mesh.materials:
        mesh.materials.append(field_material("DENSITY"))


def frame_views(objects: list[bpy.types.Object]) -> None:
    """Point every 3D view of the file at the objects, lit and in the colours of their vertices."""
    low, high = _corners(objects)
    size = max((high - low).length, 1e-6)
    for screen in bpy.data.screens:
        for area in screen.areas:
            if area.type == "VIEW_3D":
                space = area.spaces.active
                space.shading.light = "STUDIO"
                space.shading.color_type = "VERTEX"
                space.clip_start, space.clip_end = 1e-3 * size, 1e2 * size
                view = space.region_3d
                view.view_location = 0.5 * (low + high)
                view.view_rotation = Vector((0.3, -1.0, 0.15)).to_track_quat("Z", "Y")
                # With the usual 50 mm it then sees 1.2 times their size across the middle.
                view.view_distance = 0.85 * size * space.lens / 50.0


def _corners(objects: list[bpy.types.Object]) -> tuple[Vector, Vector]:
    """Lower and upper corner of the objects in the scene."""
    bpy.context.view_layer.update()
    corners = np.array(
        [obj.matrix_world @ Vector(corner) for obj in objects for corner in obj.bound_box]
    )
    return Vector(corners.min(axis=0)), Vector(corners.max(axis=0))
