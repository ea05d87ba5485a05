"""The operator that fairs copies with and without adaptivity and lays them side by side."""

from __future__ import annotations

import math

import bpy
from bpy.app.translations import pgettext_data as data_
from bpy.app.translations import pgettext_rpt as rpt_
from mathutils import Vector

from ..data.regions import refusal
from ..properties import SolverProperties, solver_settings
from ..requirements import scipy_problem
from .modal_run import ModalRun
from .object_mode import object_mode
from .polls import busy_refusal, is_allowed, no_active_mesh_refusal

GAP = 0.25
"""Space between two copies, as a share of the object's size."""

BESIDE_AUTO = {"method": "adaptive_timestep", "density": "area", "tau": 0.0107, "steps": 4}
"""Best setting of the adaptive schemes (measured); the uniform copy beside one of "auto", which has
no τ, gets the τ that belongs to it."""

LABEL_GAP = 0.06
"""Space between a copy and its label, as a share of the object's size."""

LABEL_SIZE = 0.11
"""Height of the labels, as a share of the object's size."""


class OBJECT_OT_adaptive_fairing_compare(SolverProperties, ModalRun, bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_compare"
    bl_label = "Compare with Uniform"
    bl_description = (
        "Fair two copies of the active mesh, one uniformly and one adaptively, and lay them side "
        "by side with labels"
    )
    bl_options = {"REGISTER", "UNDO"}

    uniform_tau: bpy.props.FloatProperty(
        name="Uniform τ",
        description="τ of the uniform copy; 0 takes the mean of τ times density of the other",
        default=0.0,
        min=0.0,
        precision=5,
    )

    @classmethod
    def poll(cls, context):
        problem = scipy_problem() or refusal(context)
        return is_allowed(cls, busy_refusal(), problem, no_active_mesh_refusal(context))

    def prepare(self, context):
        from dataclasses import replace

        from ...core.diffusion.smoothing_radius import equivalent_uniform_tau
        from ..data.mesh_arrays import read_mesh
        from ..jobs.fairing_task import FairingTask

        adaptive = solver_settings(self)
        if adaptive.method == "uniform":
            adaptive = replace(adaptive, method="adaptive_timestep")
        beside = replace(adaptive, **BESIDE_AUTO) if adaptive.method == "auto" else adaptive
        obj = context.active_object
        with object_mode(context):
            data = read_mesh(obj.data)
        tau = self.uniform_tau or equivalent_uniform_tau(data.vertices, data.triangles, beside)
        uniform = replace(beside, method="uniform", tau=float(f"{tau:.3g}"))
        library = obj.library.filepath if obj.library is not None else None
        return [
            FairingTask(obj.name, data.vertices, data.triangles, None, settings, library)
            for settings in (uniform, adaptive)
        ]

    def conclude(self, context, tasks, *, is_stopped):
        from ...core import FairingError
        from ..jobs.store_result import find_object

        failed = [task.error for task in tasks if task.error is not None]
        unfinished = not all(task.steps for task in tasks)
        if failed or unfinished:
            message = failed[0] if failed else rpt_("Stopped before both copies were done")
            self.report({"ERROR"} if failed else {"INFO"}, message)
            return {"CANCELLED"}
        if context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        try:
            source = find_object(tasks[0])
        except FairingError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        made = _lay_out(context, source, tasks)
        for obj in context.selected_objects:
            obj.select_set(False)
        for obj in made:
            obj.select_set(True)
        context.view_layer.objects.active = made[-1]
        return {"FINISHED"}


def _lay_out(context, source, tasks) -> list[bpy.types.Object]:
    """Put labelled copies to the right of the source, in a collection of their own.

    The source itself stands for the mesh before, unless shape keys make it show something else.
    """
    from ..jobs.store_result import write_steps

    low, high = _world_box(source)
    size = max(high - low)
    stride = (high.x - low.x) + GAP * size
    collection = bpy.data.collections.new(data_("Fairing Comparison"))
    context.scene.collection.children.link(collection)

    def add(title, label, place):
        copy = _plain_copy(source, f"{source.name} {title.lower()}", tasks[0].vertices)
        copy.matrix_world.translation.x += place * stride
        collection.objects.link(copy)
        add_label(label, place)
        return copy

    def add_label(text, place):
        at = Vector(((low.x + high.x) / 2 + place * stride, low.y, low.z - LABEL_GAP * size))
        collection.objects.link(_label(text, at, LABEL_SIZE * size))

    before = data_("Before")
    if source.data.shape_keys is None:
        place = 0
        add_label(before, place)
    else:
        place = 1
        add(before, before, place)
    made = []
    for task in tasks:
        place += 1
        copy = add(*_title_and_label(task), place)
        write_steps(copy, task, output="ABSOLUTE_KEYS", store_density=False)
        made.append(copy)
    return made


def _title_and_label(task) -> tuple[str, str]:
    """Name a copy, for the outliner and for the label below it."""
    from ...core.results import chosen_step

    settings, chosen = task.settings, chosen_step(task.steps)
    with_what = f"τ = {settings.tau:.3g}"
    if chosen.auto is not None:
        title, with_what = data_("Automatic"), f"{data_('Noise')} {chosen.auto.noise:.2g}"
    elif settings.method == "uniform":
        title = data_("Uniform")
    else:
        title = data_("Adaptive")
    return title, f"{title}\n{with_what}\nH {100 * chosen.curvature_ratio:.0f} %"


def _plain_copy(source, name, vertices) -> bpy.types.Object:
    """Copy an object with a mesh of its own, without shape keys and parent."""
    from ..data.mesh_arrays import write_positions

    copy = source.copy()
    copy.name = name
    copy.data = source.data.copy()
    copy.data.name = name
    if copy.data.shape_keys is not None:
        copy.shape_key_clear()
        write_positions(copy.data, vertices)
    copy.parent = None
    copy.matrix_world = source.matrix_world.copy()
    return copy


def _label(text, location, size) -> bpy.types.Object:
    """Make a text that stands upright and faces the front view."""
    curve = bpy.data.curves.new(text.split("\n")[0], "FONT")
    curve.body = text
    curve.align_x = "CENTER"
    curve.align_y = "TOP"
    curve.size = size
    label = bpy.data.objects.new(curve.name, curve)
    label.location = location
    label.rotation_euler = (math.pi / 2, 0.0, 0.0)
    return label


def _world_box(obj) -> tuple[Vector, Vector]:
    """Return the lowest and the highest corner of an object's box in the world."""
    corners = [obj.matrix_world @ Vector(corner) for corner in obj.bound_box]
    low = Vector(min(corner[axis] for corner in corners) for axis in range(3))
    high = Vector(max(corner[axis] for corner in corners) for axis in range(3))
    return low, high


register, unregister = bpy.utils.register_classes_factory((OBJECT_OT_adaptive_fairing_compare,))
