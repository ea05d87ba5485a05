"""Operators on results: apply, discard, show on a surface, compare with the original."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_iface as iface_
from bpy.app.translations import pgettext_rpt as rpt_
from mathutils import Vector

from ..data.display import display_of
from ..data.earlier_files import has_earlier_keys, take_keys
from ..data.object_mode import undoable_object_mode
from ..data.regions import DYNTOPO
from ..data.results import (
    apply,
    discard,
    end_comparison,
    forget,
    on_control,
    show_before,
    show_split,
)
from ..data.sculpt_undo import keep_before, note_state
from ..requirements import scipy_problem
from .polls import busy_refusal, is_allowed, linked_refusal, no_active_mesh_refusal
from .questions import Asking

SURFACES = (
    ("CONTROL", "Control Mesh", "The mesh itself, as it was denoised"),
    ("LIMIT", "Limit Points", "Its vertices on the smooth surface that it describes"),
    ("REFINED_1", "Refined 1", "Each triangle in 4, with all vertices on the smooth surface"),
    ("REFINED_2", "Refined 2", "Each triangle in 16, with all vertices on the smooth surface"),
    ("REFINED_3", "Refined 3", "Each triangle in 64, with all vertices on the smooth surface"),
)

NO_RESULT = "The active object has no result of Adaptive Fairing that can still be changed"


def record_refusal(context: bpy.types.Context) -> str | None:
    """Message that the active object has no record that may be changed; None if it has.

    Whether the record still fits the mesh is not checked.
    """
    obj = context.active_object
    if obj is None or obj.type != "MESH" or not obj.adaptive_fairing.result:
        return NO_RESULT
    return DYNTOPO if obj.use_dynamic_topology_sculpting else linked_refusal(obj)


def result_refusal(context: bpy.types.Context) -> str | None:
    """Message that the active object has no result; None if it has."""
    obj, refusal = context.active_object, record_refusal(context)
    if refusal is not None or display_of(obj).is_whole:
        return refusal
    return "The mesh was changed since the last run: its stored result no longer fits"


def result_objects(context: bpy.types.Context) -> list[bpy.types.Object]:
    """Find the active object and, in Object Mode, the other selected objects with a result."""
    active = context.active_object
    selected = context.selected_objects if active.mode == "OBJECT" else []
    meshes = [obj for obj in selected if obj.type == "MESH" and obj != active]
    return [active, *(obj for obj in meshes if obj.adaptive_fairing.result)]


class _OnResult:
    """Mix-in of operators on the result of the active object."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return is_allowed(cls, result_refusal(context), busy_refusal())

    def finish(self, context, action, objects=None):
        """Do something with the results of objects, in Object Mode, and return to the mode."""
        from ...core import FairingError

        objects, problems = objects or [context.active_object], []
        with undoable_object_mode(context):
            for obj in objects:
                if not obj.adaptive_fairing.result:  # has ended with that of a shared mesh
                    continue
                end_comparison(obj)
                try:
                    action(obj)
                except FairingError as error:
                    problems.append(f"{obj.name}: {error}")
        is_done = len(problems) < len(objects)
        for problem in problems:
            self.report({"WARNING"} if is_done else {"ERROR"}, problem)
        return {"FINISHED"} if is_done else {"CANCELLED"}


class _EndOfResult(Asking, _OnResult):
    """Mix-in of operators that end the results of all selected objects, each by `end`."""

    def invoke(self, context, event):
        return self.ask(context, iface_(self.bl_label)) or self.execute(context)

    def execute(self, context):
        return self.finish(context, self.end, result_objects(context))


class OBJECT_OT_adaptive_fairing_apply(_EndOfResult, bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_apply"
    bl_label = "Apply"
    bl_description = (
        "Keep the shape as it is shown and remove everything else that the runs have left: stored "
        "shapes, shape keys, modifier, colors. Of all selected objects"
    )
    end = staticmethod(apply)


class OBJECT_OT_adaptive_fairing_discard(_EndOfResult, bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_discard"
    bl_label = "Discard"
    bl_description = (
        "Bring the mesh back to exactly what it was before the runs. Of all selected objects"
    )

    @classmethod
    def poll(cls, context):
        refusal, obj = record_refusal(context), context.active_object
        display = display_of(obj) if refusal is None else None
        if display is not None and not (display.has_control or display.has_original):
            refusal = "The mesh from before the runs is no longer known: Forget keeps this one"
        return is_allowed(cls, refusal, busy_refusal())

    def end(self, obj):
        report_kept(self, discard(obj))


class OBJECT_OT_adaptive_fairing_forget(_EndOfResult, bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_forget"
    bl_label = "Forget"
    bl_description = (
        "Leave the mesh and its shape keys as they are and remove what else the runs have left. Of "
        "all selected objects"
    )
    end = staticmethod(forget)

    @classmethod
    def poll(cls, context):
        return is_allowed(cls, record_refusal(context), busy_refusal())


class OBJECT_OT_adaptive_fairing_surface(_OnResult, bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_surface"
    bl_label = "Surface"
    bl_description = (
        "Choose the mesh that shows the result. Strength, Evolution, painting and the animation "
        "work on each of them, and Discard brings the original mesh back"
    )

    surface: bpy.props.EnumProperty(
        name="Surface",
        description="The mesh that shows the result",
        items=SURFACES,
        default="CONTROL",
    )

    @classmethod
    def poll(cls, context):
        problems = result_refusal(context), busy_refusal(), scipy_problem()
        return is_allowed(cls, *problems)

    def execute(self, context):
        def show(obj):
            with on_control(obj) as shown:
                obj.adaptive_fairing.surface = self.surface
            report_kept(self, shown.kept)
            for note in shown.notes:
                self.report({"WARNING"}, f"{obj.name}: {note}")

        return self.finish(context, show)


def surface_name(record: bpy.types.PropertyGroup) -> str:
    """Name of the surface that shows a result."""
    shown = "CONTROL" if record.control is None else record.surface
    return next(name for identifier, name, *_ in SURFACES if identifier == shown)


def report_kept(operator: bpy.types.Operator, name: str | None) -> None:
    """Report that a refined mesh stays in the file, see `shown_surface.show_control`."""
    if name is not None:
        text = rpt_("The refined mesh was changed by hand: it stays in the file as {!r}")
        operator.report({"WARNING"}, text.format(name))


class OBJECT_OT_adaptive_fairing_before(_OnResult, bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_before"
    bl_label = "Before"
    bl_description = (
        "Show the original as long as the key is held; the button shows it until the next click"
    )

    _key: str | None = None

    def execute(self, context):
        self._toggle(context.active_object)
        note_state(context.active_object)
        return {"FINISHED"}

    def invoke(self, context, event):
        if event.value != "PRESS" or event.type == "LEFTMOUSE":
            return self.execute(context)
        self._toggle(context.active_object)
        self._key = event.type
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type != self._key or event.value != "RELEASE":
            return {"RUNNING_MODAL"}
        show_before(context.active_object, False)
        return {"CANCELLED"}  # all is as it was: that is no step of the history

    def cancel(self, context):
        show_before(context.active_object, False)

    @staticmethod
    def _toggle(obj):
        keep_before(obj)
        show_before(obj, not obj.adaptive_fairing.is_before)


class OBJECT_OT_adaptive_fairing_split(_OnResult, bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_split"
    bl_label = "Split"
    bl_description = (
        "Show the original on the left half of the object, as it is seen now, and the result on "
        "the right; once more shows the whole result"
    )

    def execute(self, context):
        obj = context.active_object
        with undoable_object_mode(context):
            if obj.adaptive_fairing.is_split:
                end_comparison(obj)
                return {"FINISHED"}
            show_before(obj, False)
            to_right = Vector((1.0, 0.0, 0.0))
            if context.region_data is not None:
                to_right = context.region_data.view_matrix.to_3x3().inverted() @ to_right
            # A plane's normal goes from the world into the object by the transposed matrix.
            normal = (obj.matrix_world.to_3x3().transposed() @ to_right).normalized()
            corners = [Vector(corner) for corner in obj.bound_box]
            show_split(obj, normal, sum(corners, Vector()) / len(corners))
        return {"FINISHED"}


class OBJECT_OT_adaptive_fairing_take_keys(bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_take_keys"
    bl_label = "Make Them a Result"
    bl_description = (
        "Give the shape keys of an earlier run a slider, Before, Split, Apply and Discard. "
        "Strengths are stored without keys, unless they are animated"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        refusal, obj = no_active_mesh_refusal(context), context.active_object
        if refusal is None and not has_earlier_keys(obj):
            refusal = "The active object has no shape keys of an earlier run"
        elif refusal is None:
            refusal = linked_refusal(obj)
        return is_allowed(cls, refusal, busy_refusal())

    def execute(self, context):
        with undoable_object_mode(context):
            take_keys(context.active_object)
        return {"FINISHED"}


_CLASSES = (
    OBJECT_OT_adaptive_fairing_apply,
    OBJECT_OT_adaptive_fairing_discard,
    OBJECT_OT_adaptive_fairing_forget,
    OBJECT_OT_adaptive_fairing_surface,
    OBJECT_OT_adaptive_fairing_before,
    OBJECT_OT_adaptive_fairing_split,
    OBJECT_OT_adaptive_fairing_take_keys,
)
register, unregister = bpy.utils.register_classes_factory(_CLASSES)
