"""The operator that smooths the selected meshes, and the one that stops it."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_iface as iface_
from bpy.app.translations import pgettext_rpt as rpt_
from bpy.app.translations import pgettext_tip as tip_

from ..choices import DENOISE, FAIR
from ..data.display import display_of, leaves_keys, new_display
from ..data.mesh_arrays import is_shared
from ..data.multires import read_level, shown_level, write_level
from ..data.object_mode import object_mode, undoable_object_mode
from ..data.regions import BrushRegion, refusal, target_objects, vertex_weights
from ..data.results import discard, end_comparison, on_control
from ..data.targets import needs_copy
from ..jobs.kept_preparation import preparations
from ..properties import in_object_units, solver_settings, way_of
from ..requirements import scipy_problem
from ..run_properties import CONTEXT, OutputProperties, SolverProperties
from .modal_run import ModalRun, progress, stop_run
from .polls import busy_refusal, is_allowed
from .questions import Asking, hints
from .readings import readings, remember
from .results import report_kept
from .settings_layout import draw_operator

_finished: list = []
"""Solves of the last run: the redo panel may ask for the same solves, stored in another way."""

DESCRIPTIONS = {
    DENOISE: (
        "Estimate the noise of the selected meshes, such as scans, and remove it. Starts from the "
        "shape that is shown"
    ),
    FAIR: (
        "Smooth the selected meshes by the paper's geometric diffusion, which follows the density "
        "of the mesh, and keep every step. Starts from the shape that is shown"
    ),
}


class OBJECT_OT_adaptive_fairing(
    SolverProperties, OutputProperties, Asking, ModalRun, bpy.types.Operator
):
    bl_idname = "object.adaptive_fairing"
    bl_label = "Adaptive Fairing"  # the title of the redo panel, whatever the algorithm
    bl_description = "Remove the noise of the selected meshes, by one of the two algorithms"
    bl_options = {"REGISTER", "UNDO"}

    brush_centre: bpy.props.FloatVectorProperty(
        name="Centre", description="Middle of the brush on the mesh", options={"HIDDEN"}
    )
    brush_radius: bpy.props.FloatProperty(
        name="Radius",
        description="Radius of the brush in the units of the mesh; 0 is no brush",
        min=0.0,
        options={"HIDDEN", "SKIP_SAVE"},
    )
    brush_polygon: bpy.props.IntProperty(
        name="Polygon", description="Polygon that was pointed at", min=0, options={"HIDDEN"}
    )

    @classmethod
    def poll(cls, context):
        return is_allowed(cls, busy_refusal(), scipy_problem(), refusal(context))

    def draw(self, context):
        draw_operator(self.layout, self, context.active_object)

    @classmethod
    def description(cls, context, properties):
        return tip_(DESCRIPTIONS[properties.algorithm])

    def invoke(self, context, event):
        label = run_label(self.algorithm)
        question = self.ask(context, label, hints(target_objects(context), self))
        return question or super().invoke(context, event)

    def prepare(self, context):
        settings = solver_settings(self)
        objects = target_objects(context)
        mode = objects[0].mode
        with object_mode(context):
            for obj in objects:
                readings.pop(obj.session_uid, None)  # because another run begins
                end_comparison(obj)
            return [self._solve(users, mode, settings) for users in self._by_mesh(objects)]

    def conclude(self, context, solves, *, is_stopped):
        from ...core import FairingError
        from ..jobs.write_back import find_object

        _finished[:] = [solve for solve in solves if solve.is_over and solve.has_result]
        results, problems, unchanged, discarded = [], [], [], []
        with undoable_object_mode(context):
            for solve in solves:
                source = None
                try:
                    source = find_object(solve)
                    if solve.is_changed and solve.is_of_level:
                        write_level(source, solve.vertices, solve.positions)
                        results.append(source)
                        text = rpt_("{:s}: denoised the level that is shown; it has no slider")
                        self.report({"INFO"}, text.format(solve.name))
                    elif solve.is_changed:
                        results.append(self._store(solve, source))
                        remember(results[-1], solve)
                        _take_over_selection(context, source, results[-1])
                    elif solve.has_result:
                        unchanged.append(solve)
                        if self.from_original and self._bring_back(source):
                            discarded.append(source)
                        remember(source, solve)
                except FairingError as error:
                    solve.failure = error
                if solve.error is not None:
                    remember(source, solve)
                    problems.append((f"{solve.name}: {solve.error}", source is None))
        for problem, was_deleted in problems:
            # An error opens a window, which would swallow the Ctrl Z of whoever has deleted the
            # object.
            is_expected = was_deleted and self.options.is_invoke
            self.report({"WARNING"} if results or is_expected else {"ERROR"}, problem)
        for solve in unchanged:
            self.report({"INFO"}, f"{solve.name}: {'; '.join(solve.notes)}")
        if not results:
            if not problems and not unchanged:
                self.report({"INFO"}, rpt_("Stopped: nothing was changed"))
            return {"FINISHED"} if discarded else {"CANCELLED"}
        stored = [each for each in solves if each.is_changed and each.failure is None]
        self.report({"INFO"}, _summary(stored, is_stopped))
        return {"FINISHED"}

    def _by_mesh(self, objects):
        """Put objects together that use one mesh, which gets one result."""
        users: dict[bpy.types.ID, list[bpy.types.Object]] = {}
        for obj in objects:
            users.setdefault(obj if self._needs_copy(obj) else obj.data, []).append(obj)
        return users.values()

    def _needs_copy(self, obj):
        return needs_copy(obj, in_place=leaves_keys(way_of(self)))

    def _bring_back(self, obj):
        """Show the original where an earlier result is shown: this run changes nothing."""
        if not display_of(obj).is_whole:
            return False
        report_kept(self, discard(obj))
        return True

    def _store(self, solve, source):
        """Replace the result of an object, and of those that share its mesh, and show it."""
        from ..jobs.write_back import object_of, share_result, store_solve

        sharing = [object_of(uid) for uid in solve.sharing]
        others = [each for each in sharing if each is not None and each.data == source.data]
        is_kept = is_shared(source.data, among=1 + len(others))
        self._tell_what_is_dropped(solve, source)
        settings = None if solve.is_denoise else solve.settings
        with on_control(source, settings, for_run=True) as shown:
            obj = store_solve(
                solve,
                source,
                way=way_of(self),
                store_density=self.store_density or not solve.is_denoise,
                from_original=self.from_original,
            )
            shown.objects.add(obj)
        if obj == source and others:
            share_result(solve, obj, others)
        if obj == source and is_kept:
            text = rpt_("{:s} has a mesh of its own now: other objects keep the old one")
            self.report({"INFO"}, text.format(solve.name))
        report_kept(self, shown.kept)
        for note in solve.notes:
            self.report({"INFO"}, f"{obj.name}: {note}")
        return obj

    def _tell_what_is_dropped(self, solve, source):
        """Report that an earlier result no longer counts."""
        earlier, display = display_of(source), new_display(source, way_of(self))
        if source.adaptive_fairing.result and not display.continues(earlier):
            self.report(
                {"INFO"},
                rpt_(
                    "{:s}: the mesh was changed since the last run, whose stored result was dropped"
                ).format(solve.name),
            )

    def _solve(self, users, mode, settings):
        """Make a solve of a mesh for objects that use it."""
        from ...core import FairingError
        from ..jobs.solve import Solve
        from ..jobs.write_back import read_start

        obj, *others = users
        data = read_start(obj, from_original=self.from_original)
        solve = Solve(
            *data,
            in_object_units(settings, obj),
            preparations=preparations,
            name=obj.name,
            session_uid=obj.session_uid,
            sharing=tuple(each.session_uid for each in others),
            is_of_level=mode == "OBJECT" and shown_level(obj) is not None,
        )
        try:
            if solve.is_of_level:
                self._take_level(solve, obj)
            else:
                solve.weights = self._weights(obj, mode, len(data.vertices))
                for other in _finished:
                    if solve.has_input_of(other):
                        solve.take_result(other)
        except FairingError as error:
            solve.failure = error
        return solve

    def _weights(self, obj, mode, n):
        """Weights of the first vertices of an object, which may be smoothed."""
        from ...core import InputError

        if self.existing_keys == "REFUSE" and self._needs_copy(obj):
            raise InputError(
                rpt_(
                    "has shape keys of its own, or is linked from another file: "
                    "allow to work on a copy, or make one without them"
                )
            )
        brush = None
        if self.brush_radius > 0:
            brush = BrushRegion(tuple(self.brush_centre), self.brush_radius, self.brush_polygon)
        return vertex_weights(
            obj,
            mode,
            n,
            use_region=self.use_region,
            vertex_group=self.vertex_group,
            invert=self.invert_vertex_group,
            hold_sharp=self.hold_sharp,
            brush=brush,
        )

    def _take_level(self, solve, obj):
        """Let a solve start from the shown level of a multiresolution sculpture."""
        from ...core import InputError

        if not solve.is_denoise:
            raise InputError(
                rpt_(
                    "has sculpted levels, which cannot hold steps as shape keys: choose "
                    "Denoise, or apply the multiresolution modifier"
                )
            )
        if self.vertex_group or self.hold_sharp:
            raise InputError(
                rpt_(
                    "has sculpted levels, which have no vertex groups or sharp edges: turn "
                    "these options off, or apply the multiresolution modifier"
                )
            )
        level = read_level(obj)
        solve.vertices, solve.triangles = level.vertices, level.triangles


class OBJECT_OT_adaptive_fairing_stop(bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_stop"
    bl_label = "Stop"
    bl_description = (
        "Stop the run after the step it is computing and keep the finished steps; Denoise "
        "stops at once, without a result"
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
    """If the result is a copy, select it in place of the object it was made from."""
    if result == source or result.name not in context.view_layer.objects:
        return
    result.select_set(True)
    if context.view_layer.objects.active == source:
        context.view_layer.objects.active = result


def run_label(algorithm: str) -> str:
    """Label of the button that runs an algorithm."""
    return iface_("Denoise" if algorithm == DENOISE else "Fair", CONTEXT)


def _summary(solves, is_stopped: bool) -> str:
    n_vertices = sum(_n_smoothed(solve) for solve in solves)
    seconds = sum(solve.seconds for solve in solves if not solve.is_repeated)
    if solves[0].is_denoise:
        text = rpt_("Denoised {:d} vertices, {:.1f} s").format(n_vertices, seconds)
    else:
        text = rpt_("Faired {:d} vertices in {:d} steps, {:.1f} s").format(
            n_vertices, sum(len(solve.steps) for solve in solves), seconds
        )
    return rpt_("Stopped early. {:s}").format(text) if is_stopped else text


def _n_smoothed(solve) -> int:
    """Count the vertices that a solve may move; selection, mask and group can exclude some."""
    return len(solve.vertices) if solve.weights is None else int((solve.weights > 0).sum())


_register_classes, unregister = bpy.utils.register_classes_factory(
    (OBJECT_OT_adaptive_fairing, OBJECT_OT_adaptive_fairing_stop)
)


def register() -> None:
    """Register the operators."""
    _finished.clear()
    preparations.clear()
    _register_classes()
