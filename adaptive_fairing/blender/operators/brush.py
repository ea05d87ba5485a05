"""The operator that denoises the surface under the brush in Sculpt Mode, by a key."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_rpt as rpt_
from bpy_extras.view3d_utils import (
    region_2d_to_location_3d,
    region_2d_to_origin_3d,
    region_2d_to_vector_3d,
)
from mathutils import Vector

from ..choices import DENOISE
from ..compatibility import sculpt_brush_radius
from ..data.regions import refusal
from ..properties import OUTPUT_NAMES, names_of
from ..requirements import scipy_problem
from .polls import busy_refusal, is_allowed


class OBJECT_OT_adaptive_fairing_brush(bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_brush"
    bl_label = "Denoise Under the Brush"
    bl_description = (
        "Denoise what the brush covers under the pointer, except where it is masked and outside "
        "the face set under the pointer. All roughness there counts as noise"
    )

    @classmethod
    def poll(cls, context):
        obj, is_here = context.active_object, None
        if obj is None or obj.mode != "SCULPT":
            is_here = "Change to Sculpt Mode"
        return is_allowed(cls, busy_refusal(), scipy_problem(), is_here, refusal(context))

    def invoke(self, context, event):
        found = _region_under(context, Vector((event.mouse_region_x, event.mouse_region_y)))
        if found is None:
            self.report({"WARNING"}, rpt_("Point at the mesh"))
            return {"CANCELLED"}
        settings = context.scene.adaptive_fairing
        given = {name: getattr(settings, name) for name in (*names_of(DENOISE), *OUTPUT_NAMES)}
        given |= {"algorithm": DENOISE, "clean": "denoise", "use_region": True, **found}
        bpy.ops.object.adaptive_fairing("INVOKE_DEFAULT", **given)
        return {"FINISHED"}


def _region_under(context: bpy.types.Context, pointer: Vector) -> dict[str, object] | None:
    """Region under the pointer, as settings of a run; None if it does not point at the mesh."""
    obj, region, view = context.active_object, context.region, context.region_data
    if region is None or view is None:
        return None
    inward = obj.matrix_world.inverted_safe()
    origin = inward @ region_2d_to_origin_3d(region, view, pointer)
    way = inward.to_3x3() @ region_2d_to_vector_3d(region, view, pointer)
    is_hit, place, _, polygon = obj.ray_cast(
        origin, way.normalized(), depsgraph=context.evaluated_depsgraph_get()
    )
    if not is_hit:
        return None
    radius, is_of_world = sculpt_brush_radius(context)
    if not is_of_world:
        centre = obj.matrix_world @ place
        side = region_2d_to_location_3d(region, view, pointer + Vector((radius, 0.0)), centre)
        radius = (side - centre).length
    radius /= obj.matrix_world.median_scale
    return {"brush_centre": place, "brush_radius": radius, "brush_polygon": polygon}


register, unregister = bpy.utils.register_classes_factory((OBJECT_OT_adaptive_fairing_brush,))
