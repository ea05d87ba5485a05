"""The operator that fairs copies with and without adaptivity and lays them side by side."""

from __future__ import annotations

import math

import bpy
from bpy.app.translations import pgettext_data as data_
from bpy.app.translations import pgettext_rpt as rpt_
from mathutils import Quaternion, Vector

from ..choices import DENOISE, EVOLUTION, LIVE
from ..data.coloring import end_view
from ..data.display import display_of
from ..data.mesh_arrays import write_positions
from ..data.object_mode import object_mode
from ..data.regions import refusal
from ..data.results import clear, end_comparison
from ..data.shape_keys import clear_keys
from ..data.shown_surface import control_read
from ..properties import in_object_units, solver_settings
from ..requirements import scipy_problem
from ..run_properties import SolverProperties
from .modal_run import ModalRun
from .polls import busy_refusal, is_allowed, no_active_mesh_refusal

GAP = 0.25
"""Gap between two copies, as a fraction of the object's size."""

LABEL_GAP = 0.06
"""Gap between a copy and its label, as a fraction of the object's size."""

LABEL_SIZE = 0.11
"""Height of the labels, as a fraction of the object's size."""

FRONT = Quaternion((1.0, 0.0, 0.0), math.pi / 2)
"""Rotation of the front view, for scripts, which have no view."""


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
        description="τ of the uniform copy; 0 takes the mean timestep of the adaptive copy",
        default=0.0,
        min=0.0,
        precision=5,
    )

    def execute(self, context):
        return self._removed(context) or super().execute(context)

    def invoke(self, context, event):
        return self._removed(context) or super().invoke(context, event)

    def _removed(self, context):
        """Remove the comparison if there is one."""
        collection = comparison_of(context.scene)
        if collection is None:
            return None
        for obj in list(collection.objects):
            bpy.data.batch_remove([obj, obj.data] if obj.data.users == 1 else [obj])
        bpy.data.collections.remove(collection)
        return {"FINISHED"}

    @classmethod
    def poll(cls, context):
        problem = scipy_problem() or refusal(context)
        return is_allowed(cls, busy_refusal(), problem, no_active_mesh_refusal(context))

    def prepare(self, context):
        from dataclasses import replace

        from ...core import FairingSettings
        from ...core.diffusion.smoothing_radius import equivalent_uniform_tau
        from ..jobs.solve import Solve
        from ..jobs.write_back import read_start

        obj = context.active_object
        settings = in_object_units(solver_settings(self), obj)
        # `denoise` has no τ to take over: the adaptive schemes are shown at their best setting.
        best = FairingSettings(density="area", tau=0.0107, steps=4)
        beside = best if self.algorithm == DENOISE else settings
        if beside.method == "uniform":
            settings = beside = replace(beside, method="adaptive_timestep")
        with object_mode(context):
            end_comparison(obj)
            data = read_start(obj, from_original=True)
        tau = self.uniform_tau or equivalent_uniform_tau(*data, beside)
        uniform = replace(beside, method="uniform", tau=float(f"{tau:.3g}"))
        return [
            Solve(*data, each, name=obj.name, session_uid=obj.session_uid)
            for each in (uniform, settings)
        ]

    def conclude(self, context, solves, *, is_stopped):
        from ...core import FairingError
        from ..jobs.write_back import find_object, read_start, require_unchanged

        failed = [solve.error for solve in solves if solve.error is not None]
        unfinished = not all(solve.has_result for solve in solves)
        if failed or unfinished:
            message = failed[0] if failed else rpt_("Stopped before both copies were done")
            self.report({"ERROR"} if failed else {"INFO"}, message)
            return {"CANCELLED"}
        if context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        try:
            source = find_object(solves[0])
            require_unchanged(solves[0], read_start(source, from_original=True).vertices)
        except FairingError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        with control_read(display_of(source)):
            made = _lay_out(context, source, solves)
        comparison = comparison_of(context.scene)
        _select(context, [source, *comparison.objects])
        _frame_selected(context)
        _select(context, made)
        return {"FINISHED"}


def _select(context, objects) -> None:
    """Select these objects and no others; the last one is active."""
    for obj in context.selected_objects:
        obj.select_set(False)
    for obj in objects:
        obj.select_set(True)
    context.view_layer.objects.active = objects[-1]


def _frame_selected(context) -> None:
    """Frame the selection in the user's 3D view, if there is one."""
    if context.region is not None and context.space_data is not None:
        if bpy.ops.view3d.view_selected.poll():  # type: ignore[call-arg]  # as above
            bpy.ops.view3d.view_selected()


COMPARISON = "fairing_comparison"
"""Custom property that marks the collection of a comparison."""


def comparison_of(scene: bpy.types.Scene) -> bpy.types.Collection | None:
    """Find the collection with the copies of a scene's comparison."""
    return next((each for each in scene.collection.children if COMPARISON in each), None)


def _lay_out(context, source, solves) -> list[bpy.types.Object]:
    """Put labelled copies in a collection of their own, beside the source as it is seen now.

    The source itself serves as the mesh before, unless its shape keys show something else.
    """
    from ..jobs.write_back import write_result

    view = _view_rotation(context)
    to_right, up = view @ Vector((1.0, 0.0, 0.0)), view @ Vector((0.0, 1.0, 0.0))
    corners = [source.matrix_world @ Vector(corner) for corner in source.bound_box]
    middle = sum(corners, Vector()) / len(corners)
    size = max(_extent(corners, Vector(axis)) for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1)))
    stride = (_extent(corners, to_right) + GAP * size) * to_right
    below = (_extent(corners, up) / 2 + LABEL_GAP * size) * up
    collection = bpy.data.collections.new(data_("Fairing Comparison"))
    collection[COMPARISON] = True
    context.scene.collection.children.link(collection)

    def add(title, label, place):
        copy = _plain_copy(source, f"{source.name} {title.lower()}", solves[0].vertices)
        copy.matrix_world.translation += place * stride
        collection.objects.link(copy)
        add_label(label, place)
        return copy

    def add_label(text, place):
        label = _label(text, middle + place * stride - below, view, LABEL_SIZE * size)
        collection.objects.link(label)

    before = data_("Before")
    if source.data.shape_keys is None and not source.adaptive_fairing.result:
        place = 0
        add_label(before, place)
    else:
        place = 1
        add(before, before, place)
    made = []
    for solve in solves:
        place += 1
        copy = add(*_title_and_label(solve), place)
        write_result(copy, solve, LIVE if solve.is_denoise else EVOLUTION)
        made.append(copy)
    return made


def _view_rotation(context: bpy.types.Context) -> Quaternion:
    """Rotation of the user's 3D view."""
    return FRONT if context.region_data is None else context.region_data.view_rotation


def _extent(corners, direction) -> float:
    """Extent of a box along a unit vector."""
    heights = [corner.dot(direction) for corner in corners]
    return max(heights) - min(heights)


def _title_and_label(solve) -> tuple[str, str]:
    """Name of a copy in the outliner, and text of the label below it."""
    if solve.is_denoise:
        title, with_what = data_("Denoised"), f"{data_('Noise')} {solve.denoised.noise_level:.2g}"
    else:
        is_uniform = solve.settings.method == "uniform"
        title = data_("Uniform") if is_uniform else data_("Adaptive")
        with_what = f"τ = {solve.steps[-1].tau:.3g}"
    before, after = solve.measures[0], solve.measures[solve.shown + 1]
    left = after.curvature_energy / before.curvature_energy if before.curvature_energy else 0.0
    return title, f"{title}\n{with_what}\nH {100 * left:.0f} %"


def _plain_copy(source, name, vertices) -> bpy.types.Object:
    """Copy an object and its mesh, without shape keys and parent."""
    copy = source.copy()
    copy.name = name
    copy.data = source.data.copy()
    copy.data.name = name
    end_view(copy)
    clear(copy)
    clear_keys(copy)
    write_positions(copy.data, vertices)
    copy.parent = None
    copy.matrix_world = source.matrix_world.copy()
    return copy


def _label(text, location, rotation, size) -> bpy.types.Object:
    """Make a text below a point that faces the view."""
    curve = bpy.data.curves.new(text.split("\n")[0], "FONT")
    curve.body = text
    curve.align_x = "CENTER"
    curve.align_y = "TOP"
    curve.size = size
    label = bpy.data.objects.new(curve.name, curve)
    label.location = location
    label.rotation_euler = rotation.to_euler()
    return label


register, unregister = bpy.utils.register_classes_factory((OBJECT_OT_adaptive_fairing_compare,))
