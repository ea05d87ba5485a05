"""The operator that refines meshes by Loop subdivision, onto the limit surface, without fairing."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_iface as iface_
from bpy.app.translations import pgettext_rpt as rpt_

from ..data.object_mode import object_mode
from ..data.regions import target_objects
from ..requirements import scipy_problem
from .polls import busy_refusal, is_allowed
from .questions import Asking


class OBJECT_OT_adaptive_fairing_loop_subdivide(Asking, bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_loop_subdivide"
    bl_label = "Loop Subdivide (Limit Surface)"
    bl_description = (
        "Refine the selected meshes by Loop subdivision of their triangles, with all shape keys, "
        "UV maps, attributes and vertex groups. A mesh that other objects use as well stays as it "
        "is, and the object gets its own"
    )
    bl_options = {"REGISTER", "UNDO"}

    levels: bpy.props.IntProperty(
        name="Levels",
        description="Number of steps; each cuts every triangle into four",
        default=1,
        min=1,
        max=3,
    )
    on_limit: bpy.props.BoolProperty(
        name="Limit Points",
        description=(
            "Put the vertices on the smooth surface that further subdivision would lead to. "
            "Without it they are the control points of the finer mesh, to subdivide again"
        ),
        default=True,
    )
    sharp_creases: bpy.props.BoolProperty(
        name="Sharp Edges as Creases",
        description=(
            "Edges that are marked sharp or have a crease of 1 stay sharp, and vertices with a "
            "crease of 1 stay in place"
        ),
        default=True,
    )
    exact_normals: bpy.props.BoolProperty(
        name="Exact Normals",
        description=(
            "Shade with the normals of the smooth surface, as custom normals. Clear them before "
            "you change the shape by hand"
        ),
        default=True,
    )

    @classmethod
    def poll(cls, context):
        return is_allowed(cls, scipy_problem(), busy_refusal(), _refusal(context))

    def invoke(self, context, event):
        return self.ask(context, iface_(self.bl_label)) or self.execute(context)

    def execute(self, context):
        from ...core import FairingError
        from ..data.refined_object import RefineOptions, refine_object

        options = RefineOptions(self.levels, self.on_limit, self.sharp_creases, self.exact_normals)
        objects, n_faces = target_objects(context), 0
        with object_mode(context):
            for obj in objects:
                try:
                    notes = refine_object(obj, options)
                except FairingError as error:
                    self.report({"ERROR"}, f"{obj.name}: {error}")
                    return {"CANCELLED"}
                for note in notes:
                    self.report({"WARNING"}, f"{obj.name}: {note}")
                n_faces += len(obj.data.polygons)
        self.report({"INFO"}, rpt_("Refined to {:d} triangles").format(n_faces))
        return {"FINISHED"}


def _refusal(context: bpy.types.Context) -> str | None:
    """Reason why nothing can be refined here, and what to do; None if it can."""
    active = context.active_object
    if active is not None and active.mode not in ("OBJECT", "EDIT"):
        return "Change to Object Mode or Edit Mode"
    objects = target_objects(context)
    if not objects:
        return "Select a mesh object"
    if any(obj.library is not None or obj.override_library is not None for obj in objects):
        return "The object is linked from another file: make it local first"
    return None


register, unregister = bpy.utils.register_classes_factory(
    (OBJECT_OT_adaptive_fairing_loop_subdivide,)
)
