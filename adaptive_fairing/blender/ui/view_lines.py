"""Helpers for lines in the 3D view."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import bpy
from mathutils import Vector


def sight(context: bpy.types.Context, point: Vector) -> Vector:
    """Direction in which a point is seen."""
    view = context.region_data
    if view.is_perspective:
        return point - view.view_matrix.inverted().translation
    return view.view_rotation @ Vector((0.0, 0.0, -1.0))


def draw_line(
    context: bpy.types.Context,
    points: Sequence[Vector],
    width: float,
    color: tuple[float, float, float, float],
) -> None:
    """Draw a line through points in pixels of the region.

    Parameters
    ----------
    context
    points
        The line's ends, and the points between them in order.
    width
        In pixels at the interface's scale 1.
    color
        Red, green, blue and opacity.
    """
    import gpu  # there is none without a window
    from gpu_extras.batch import batch_for_shader

    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    shader.uniform_float("lineWidth", width * context.preferences.system.ui_scale)
    shader.uniform_float("color", color)
    parts = [(*point, 0.0) for part in pairwise(points) for point in part]
    gpu.state.blend_set("ALPHA")
    batch_for_shader(shader, "LINES", {"pos": parts}).draw(shader)
    gpu.state.blend_set("NONE")
