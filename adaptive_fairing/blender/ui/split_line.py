"""Line between original and result of a split in the 3D view, to be dragged."""

from __future__ import annotations

from typing import NamedTuple

import bpy
from bpy_extras.view3d_utils import location_3d_to_region_2d, region_2d_to_location_3d
from mathutils import Vector
from mathutils.geometry import intersect_point_line

from ..data.results import show_split
from ..operators.results import result_refusal
from .view_lines import draw_line, sight

OVERHANG = 0.1
"""Overhang of the line beyond the object's box at either end, as a fraction of its length."""

REACH = 8
"""Distance from the line within which it can be dragged, in pixels at the interface's scale 1."""

LEAST_SINE = 1e-3
"""Least sine of the angle between line of sight and normal for which a plane has a line."""

WIDTH = 2
"""Width of the line in pixels at the interface's scale 1."""


class SplitPlane(NamedTuple):
    """Plane of a split in the world, and the corners of the object's box."""

    point: Vector
    normal: Vector
    corners: list[Vector]

    @classmethod
    def of(cls, obj: bpy.types.Object) -> SplitPlane:
        """Plane of the split that an object shows."""
        record, matrix = obj.adaptive_fairing, obj.matrix_world
        # A plane's normal goes into the world by the inverse transposed matrix.
        normal = matrix.to_3x3().inverted_safe().transposed() @ Vector(record.split_normal)
        corners = [matrix @ Vector(corner) for corner in obj.bound_box]
        return cls(matrix @ Vector(record.split_point), normal.normalized(), corners)

    def along(self, sight: Vector) -> Vector | None:
        """Direction in the plane across a line of sight; None if that is normal to the plane."""
        found = self.normal.cross(sight.normalized())
        return None if found.length < LEAST_SINE else found.normalized()

    def line(self, sight: Vector) -> tuple[Vector, Vector] | None:
        """Find the ends of the line across a line of sight; None if there is no line."""
        along = self.along(sight)
        if along is None:
            return None
        heights = [(corner - self.point).dot(along) for corner in self.corners]
        low, high = min(heights), max(heights)
        margin = OVERHANG * (high - low)
        return self.point + (low - margin) * along, self.point + (high + margin) * along

    def moved(self, way: Vector) -> SplitPlane:
        """Plane moved by the component of a vector along its normal, within the box."""
        offsets = [(corner - self.point).dot(self.normal) for corner in self.corners]
        offset = min(max(way.dot(self.normal), min(offsets)), max(offsets))
        return self._replace(point=self.point + offset * self.normal)

    def turned(self, along: Vector, sight: Vector) -> SplitPlane:
        """Plane turned about a line in it into the line of sight, so the border is straight."""
        normal = along.cross(sight).normalized()
        return self._replace(normal=normal if normal.dot(self.normal) > 0 else -normal)


class VIEW3D_GT_adaptive_fairing_split(bpy.types.Gizmo):
    """The line, drawn in pixels of the region."""

    bl_idname = "VIEW3D_GT_adaptive_fairing_split"

    def setup(self):
        self.use_draw_modal = True

    def draw(self, context):
        ends = _ends(context)
        if ends is None:
            return
        opacity, width = (0.9, 2 * WIDTH) if self.is_highlight else (0.6, WIDTH)
        draw_line(context, ends, width, (1.0, 1.0, 1.0, opacity))

    def test_select(self, context, location):
        ends = _ends(context)
        if ends is None:
            return -1
        nearest, part = intersect_point_line(Vector(location), *ends)
        reach = REACH * context.preferences.system.ui_scale
        is_near = 0 <= part <= 1 and (nearest.xy - Vector(location)).length < reach
        return 0 if is_near else -1

    def invoke(self, context, event):
        plane = SplitPlane.of(context.active_object)
        self._plane, self._began = plane, _in_depth(context, event, plane.point)
        self._along = plane.along(sight(context, plane.point))
        return {"RUNNING_MODAL"}

    def modal(self, context, event, _tweak):
        way = _in_depth(context, event, self._plane.point) - self._began
        plane = self._plane.moved(way)
        split_at(context.active_object, plane.turned(self._along, sight(context, plane.point)))
        context.area.tag_redraw()
        return {"RUNNING_MODAL"}

    def exit(self, context, cancel):
        if cancel:
            split_at(context.active_object, self._plane)
        elif bpy.ops.ed.undo_push.poll():  # type: ignore[call-arg]  # the stubs want self
            bpy.ops.ed.undo_push(message="Split")


class VIEW3D_GGT_adaptive_fairing_split(bpy.types.GizmoGroup):
    bl_idname = "VIEW3D_GGT_adaptive_fairing_split"
    bl_label = "Split"
    bl_space_type = "VIEW_3D"
    bl_region_type = "WINDOW"
    bl_options = {"PERSISTENT", "SHOW_MODAL_ALL"}

    @classmethod
    def poll(cls, context):
        if result_refusal(context) is not None:
            return False
        obj = context.active_object
        return obj.adaptive_fairing.is_split and obj.mode == "OBJECT" and obj.visible_get()

    def setup(self, context):
        self.gizmos.new(VIEW3D_GT_adaptive_fairing_split.bl_idname)


def split_at(obj: bpy.types.Object, plane: SplitPlane) -> None:
    """Show the original behind a plane of the world."""
    matrix = obj.matrix_world
    normal = (matrix.to_3x3().transposed() @ plane.normal).normalized()
    show_split(obj, normal, matrix.inverted_safe() @ plane.point)


def _ends(context: bpy.types.Context) -> tuple[Vector, Vector] | None:
    """Find the ends of the line in pixels of the region; None if it cannot be seen."""
    plane = SplitPlane.of(context.active_object)
    line = plane.line(sight(context, plane.point))
    if line is None:
        return None
    ends = [location_3d_to_region_2d(context.region, context.region_data, end) for end in line]
    return None if None in ends else (ends[0], ends[1])


def _in_depth(context: bpy.types.Context, event: bpy.types.Event, point: Vector) -> Vector:
    """Position of the pointer in the world, at the depth of a point."""
    pointer = event.mouse_region_x, event.mouse_region_y
    return region_2d_to_location_3d(context.region, context.region_data, pointer, point)


register, unregister = bpy.utils.register_classes_factory(
    (VIEW3D_GT_adaptive_fairing_split, VIEW3D_GGT_adaptive_fairing_split)
)
