"""The operator that fairs the selected meshes, and the one that stops it."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ..data.regions import refusal, target_objects, vertex_weights
from ..properties import OutputProperties, SolverProperties, solver_settings
from ..requirements import scipy_problem
from .modal_run import ModalRun, progress, stop_run
from .object_mode import object_mode
from .polls import busy_refusal, is_allowed
from .settings_layout import draw_operator


class OBJECT_OT_adaptive_fairing(SolverProperties, OutputProperties, ModalRun, bpy.types.Operator):
    bl_idname = "object.adaptive_fairing"
    bl_label = "Adaptive Fairing"
    bl_description = (
        "Smooth the noise out of the selected meshes by geometric diffusion that follows the "
        "density of the mesh, and keep every step or strength"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return is_allowed(cls, busy_refusal(), scipy_problem(), refusal(context))

    def draw(self, context):
        draw_operator(self.layout, self, context.active_object)

    def prepare(self, context):
        settings = solver_settings(self)
        objects = target_objects(context)
        mode = objects[0].mode
        with object_mode(context):
            return [self._solve(obj, mode, settings) for obj in objects]

    def conclude(self, context, solves, *, is_stopped):
        from ...core import FairingError
        from ..jobs.store_result import object_of, store_solve

        results, problems = [], []
        with object_mode(context):
            for solve in solves:
                try:
                    if solve.has_result:
                        obj = store_solve(
                            solve, output=self.output, store_density=self.store_density
                        )
                        results.append(obj)
                        for note in solve.notes:
                            self.report({"INFO"}, f"{obj.name}: {note}")
                        _take_over_selection(context, object_of(solve.session_uid), obj)
                except FairingError as error:
                    solve.failure = error
                if solve.error is not None:
                    problems.append(f"{solve.name}: {solve.error}")
        for problem in problems:
            self.report({"WARNING"} if results else {"ERROR"}, problem)
        if not results:
            if not problems:
                self.report({"INFO"}, rpt_("Stopped: nothing was changed"))
            return {"CANCELLED"}
        self.report({"INFO"}, _summary(solves, is_stopped))
        return {"FINISHED"}

    def _solve(self, obj, mode, settings):
        from ...core import FairingError, InputError
        from ..data.mesh_arrays import read_mesh
        from ..data.targets import needs_copy
        from ..jobs.solve import Solve

        data = read_mesh(obj.data)
        solve = Solve(
            data.vertices, data.triangles, settings, name=obj.name, session_uid=obj.session_uid
        )
        try:
            if self.existing_keys == "REFUSE" and needs_copy(obj):
                raise InputError(
                    rpt_(
                        "has shape keys of its own, or is linked from another file: "
                        "allow to work on a copy, or make one without them"
                    )
                )
            solve.weights = vertex_weights(
                obj,
                mode,
                use_region=self.use_region,
                vertex_group=self.vertex_group,
                invert=self.invert_vertex_group,
            )
        except FairingError as error:
            solve.failure = error
        return solve


class OBJECT_OT_adaptive_fairing_stop(bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_stop"
    bl_label = "Stop"
    bl_description = (
        "Stop the run after the step it is computing and keep the finished steps; an automatic "
        "run stops at once, without a result"
    )
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context):
        return progress() is not None

    def execute(self, context):
        stop_run()
        return {"FINISHED"}


def _take_over_selection(
    context: bpy.types.Context, source: bpy.types.Object, result: bpy.types.Object
) -> None:
    """Select a result that is a copy in place of the object it was made from."""
    if result == source or result.name not in context.view_layer.objects:
        return
    result.select_set(True)
    if context.view_layer.objects.active == source:
        context.view_layer.objects.active = result


def _summary(solves, is_stopped: bool) -> str:
    done = [solve for solve in solves if solve.has_result]
    n_vertices = sum(len(solve.vertices) for solve in done)
    seconds = sum(solve.seconds for solve in done)
    if done[0].is_denoise:
        text = rpt_("Denoised {:d} vertices, {:.1f} s").format(n_vertices, seconds)
    else:
        text = rpt_("Faired {:d} vertices in {:d} steps, {:.1f} s").format(
            n_vertices, sum(len(solve.steps) for solve in done), seconds
        )
    return rpt_("Stopped early. {:s}").format(text) if is_stopped else text


register, unregister = bpy.utils.register_classes_factory(
    (OBJECT_OT_adaptive_fairing, OBJECT_OT_adaptive_fairing_stop)
)
