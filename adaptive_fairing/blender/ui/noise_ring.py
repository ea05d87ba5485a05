"""Ring on the active mesh, as large as the bumps of a Noise Size that was given.

It can be seen in a 3D view whose sidebar shows our tab, beside the length that the panel tells.
"""

from __future__ import annotations

from math import cos, pi, sin

import bpy
from bpy_extras.view3d_utils import (
    location_3d_to_region_2d,
    region_2d_to_origin_3d,
    region_2d_to_vector_3d,
)
from mathutils import Vector

from ..choices import DENOISE
from ..operators import mesh_scale
from ..properties import has_width
from .layouts import FairingPanel
from .view_lines import draw_line, sight

N_POINTS = 64

STROKES = ((5.0, (0.0, 0.0, 0.0, 1.0)), (2.0, (1.0, 1.0, 1.0, 1.0)))
"""Widths in pixels at the interface's scale 1, and colours: an outline seen on any mesh."""


def ring(centre: Vector, along: Vector, radius: float) -> list[Vector]:
    """Points of a closed ring, the first one also last, across a line of sight."""
    right = along.orthogonal().normalized() * radius
    up = along.normalized().cross(right)
    angles = [2 * pi * each / N_POINTS for each in range(N_POINTS)]
    points = [centre + cos(angle) * right + sin(angle) * up for angle in angles]
    return [*points, points[0]]


def surface_point(obj: bpy.types.Object, eye: Vector, along: Vector) -> Vector:
    """Find the point of an object that is seen, or one towards its middle, or that itself."""
    into_world, into_object = obj.matrix_world, obj.matrix_world.inverted_safe()
    middle = sum((Vector(corner) for corner in obj.bound_box), Vector()) / 8
    start = into_object @ eye
    for direction in (into_object.to_3x3() @ along, middle - start):
        try:
            is_hit, location, *_ = obj.ray_cast(start, direction)
        except RuntimeError:  # its modifiers leave no mesh
            break
        if is_hit:
            return into_world @ location
    return into_world @ middle


def bump_radius(context: bpy.types.Context) -> float | None:
    """Radius of a bump of the noise in the world: the size given; None if there is none to show."""
    settings = context.scene.adaptive_fairing
    if settings.algorithm != DENOISE or not has_width(settings) or not _is_at_hand(context):
        return None
    obj = context.active_object
    if obj is None or obj.type != "MESH" or not obj.visible_get(viewport=context.space_data):
        return None
    scale = mesh_scale.known_scale(obj, settings)  # that the panel has asked for
    if scale is None or isinstance(scale, str):
        return None
    return mesh_scale.noise_length(obj, settings, scale) or None


def _is_at_hand(context: bpy.types.Context) -> bool:
    """Whether a 3D view shows overlays, and our tab beside them."""
    space = context.space_data
    if context.region_data is None or not (space.overlay.show_overlays and space.show_region_ui):
        return False
    tabs = [each.active_panel_category for each in context.area.regions if each.type == "UI"]
    return FairingPanel.bl_category in tabs


def ring_in_pixels(context: bpy.types.Context, radius: float) -> list[Vector]:
    """Points of the ring in the region of a 3D view; none if a part of it is behind the viewer."""
    seen = context.region, context.region_data
    middle = context.region.width / 2, context.region.height / 2
    eye, along = region_2d_to_origin_3d(*seen, middle), region_2d_to_vector_3d(*seen, middle)
    centre = surface_point(context.active_object, eye, along)
    places = ring(centre, sight(context, centre), radius)
    points = [location_3d_to_region_2d(*seen, place) for place in places]
    return [] if None in points else points


def _draw() -> None:
    radius = bump_radius(bpy.context)
    if radius is not None:
        points = ring_in_pixels(bpy.context, radius)
        for width, color in STROKES if points else ():
            draw_line(bpy.context, points, width, color)


_handlers: list[object] = []


def register() -> None:
    """Have it drawn with the 3D views, on top of them and not in renders."""
    _handlers.append(bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_PIXEL"))


def unregister() -> None:
    """Draw it no more."""
    while _handlers:
        bpy.types.SpaceView3D.draw_handler_remove(_handlers.pop(), "WINDOW")
