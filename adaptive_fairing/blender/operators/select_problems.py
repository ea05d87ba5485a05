"""The operator that selects the vertices that a run refuses, holds or bounds."""

from __future__ import annotations

import bmesh
import bpy
import numpy as np
from bpy.app.translations import pgettext_rpt as rpt_
from numpy.typing import NDArray

from ..data.mesh_arrays import read_mesh
from ..data.object_mode import object_mode
from ..requirements import scipy_problem
from .polls import is_allowed, linked_refusal, no_active_mesh_refusal


class OBJECT_OT_adaptive_fairing_select_problems(bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_select_problems"
    bl_label = "Select Problem Vertices"
    bl_description = (
        "Select, in Edit Mode, the vertices of the active mesh that are not finite, not manifold "
        "or on triangles without area: those that a run refuses, holds still or limits"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        no_mesh, not_editable = no_active_mesh_refusal(context), None
        if no_mesh is None:
            obj = context.active_object
            if obj.mode not in ("OBJECT", "EDIT"):
                not_editable = "Change to Object Mode or Edit Mode"
            else:
                not_editable = linked_refusal(obj)
        return is_allowed(cls, scipy_problem(), no_mesh, not_editable)

    def execute(self, context):
        from ...core.problem.diagnosis import find_problems

        obj = context.active_object
        with object_mode(context):
            data = read_mesh(obj.data)
        problems = find_problems(data.vertices, data.triangles)
        if len(problems.vertices) == 0:
            self.report({"INFO"}, rpt_("No problem vertices"))
            return {"FINISHED"}
        bpy.ops.object.mode_set(mode="EDIT")
        _select_only(context, obj.data, problems.vertices)
        text = rpt_("Not finite: {:d}, held: {:d}, doubled: {:d}, without area: {:d}").format(
            len(problems.not_finite), len(problems.held), len(problems.left_out), len(problems.thin)
        )
        self.report({"INFO"}, text)
        return {"FINISHED"}


def _select_only(
    context: bpy.types.Context, mesh: bpy.types.Mesh, vertices: NDArray[np.intp]
) -> None:
    """Select vertices of a mesh in Edit Mode, show them if they are hidden, deselect all others."""
    context.tool_settings.mesh_select_mode = (True, False, False)
    bm = bmesh.from_edit_mesh(mesh)
    wanted = np.zeros(len(bm.verts), dtype=bool)
    wanted[vertices] = True
    for vertex, is_wanted in zip(bm.verts, wanted.tolist(), strict=True):
        if is_wanted:
            vertex.hide = False
        vertex.select = is_wanted
    bm.select_flush_mode()
    bmesh.update_edit_mesh(mesh, loop_triangles=False, destructive=False)


register, unregister = bpy.utils.register_classes_factory(
    (OBJECT_OT_adaptive_fairing_select_problems,)
)
