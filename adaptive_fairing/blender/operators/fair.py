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
        from ..ui.settings_panel import draw_operator

        draw_operator(self.layout, self, context.active_object)

    def prepare(self, context):
        settings = solver_settings(self)
        objects = target_objects(context)
        mode = objects[0].mode
        with object_mode(context):
            return [self._task(obj, mode, settings) for obj in objects]

    def conclude(self, context, tasks, *, is_stopped):
        from ...core import FairingError
        from ..jobs.store_result import store_task

        results, problems = [], []
        with object_mode(context):
            for task in tasks:
                try:
                    if task.steps:
                        obj = store_task(task, output=self.output, store_density=self.store_density)
                        results.append(obj)
                        for note in task.steps[-1].notes:
                            self.report({"INFO"}, f"{task.name}: {note}")
                        _take_over_selection(context, task.name, obj)
                except FairingError as error:
                    task.error = str(error)
                if task.error is not None:
                    problems.append(f"{task.name}: {task.error}")
        for problem in problems:
            self.report({"WARNING"} if results else {"ERROR"}, problem)
        if not results:
            if not problems:
                self.report({"INFO"}, rpt_("Stopped: nothing was changed"))
            return {"CANCELLED"}
        self.report({"INFO"}, _summary(tasks, is_stopped))
        return {"FINISHED"}

    def _task(self, obj, mode, settings):
        from ...core import FairingError
        from ..data.mesh_arrays import read_mesh
        from ..data.targets import needs_copy
        from ..jobs.fairing_task import FairingTask

        data = read_mesh(obj.data)
        library = obj.library.filepath if obj.library is not None else None
        task = FairingTask(obj.name, data.vertices, data.triangles, None, settings, library)
        if self.existing_keys == "REFUSE" and needs_copy(obj):
            task.error = rpt_(
                "has shape keys of its own, or is linked from another file: "
                "allow to work on a copy, or make one without them"
            )
            return task
        try:
            task.weights = vertex_weights(
                obj,
                mode,
                use_region=self.use_region,
                vertex_group=self.vertex_group,
                invert=self.invert_vertex_group,
            )
        except FairingError as error:
            task.error = str(error)
        return task


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


def _take_over_selection(context: bpy.types.Context, name: str, result: bpy.types.Object) -> None:
    """Select a result that is a copy in place of the object it was made from."""
    if result.name == name or result.name not in context.view_layer.objects:
        return
    active = context.view_layer.objects.active
    result.select_set(True)
    if active is not None and active.name == name:
        context.view_layer.objects.active = result


def _summary(tasks, is_stopped: bool) -> str:
    done = [task for task in tasks if task.steps]
    n_vertices = sum(len(task.vertices) for task in done)
    seconds = sum(task.seconds for task in done)
    if done[0].is_auto:
        text = rpt_("Faired {:d} vertices, {:.1f} s").format(n_vertices, seconds)
    else:
        text = rpt_("Faired {:d} vertices in {:d} steps, {:.1f} s").format(
            n_vertices, sum(len(task.steps) for task in done), seconds
        )
    return rpt_("Stopped early. {:s}").format(text) if is_stopped else text


register, unregister = bpy.utils.register_classes_factory(
    (OBJECT_OT_adaptive_fairing, OBJECT_OT_adaptive_fairing_stop)
)
