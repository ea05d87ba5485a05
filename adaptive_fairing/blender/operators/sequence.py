"""The operator that fairs an animated object over a range of frames."""

from __future__ import annotations

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ...files.output_words import DENOISED, FAIRED
from ..properties import in_object_units, solver_settings
from ..requirements import scipy_problem
from ..run_properties import SolverProperties
from .modal_run import ModalRun
from .polls import busy_refusal, is_allowed, no_active_mesh_refusal


class OBJECT_OT_adaptive_fairing_sequence(SolverProperties, ModalRun, bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_sequence"
    bl_label = "Frame Sequence"
    bl_description = (
        "Run the algorithm on the active object as it is shown at each frame of a range, modifiers "
        "and simulations included, and make a new object that plays the results; bake simulations "
        "first"
    )
    bl_options = {"REGISTER", "UNDO"}

    frame_start: bpy.props.IntProperty(
        name="First Frame", description="First frame to fair", default=1
    )
    frame_end: bpy.props.IntProperty(
        name="Last Frame", description="Last frame to fair", default=250
    )
    same_strength: bpy.props.BoolProperty(
        name="Same Strength",
        description="Smooth every frame as strongly as the first one, so that nothing flickers",
        default=True,
    )

    @classmethod
    def poll(cls, context):
        no_mesh, wrong_mode = no_active_mesh_refusal(context), None
        if no_mesh is None and context.active_object.mode != "OBJECT":
            wrong_mode = "Change to Object Mode"
        return is_allowed(cls, no_mesh, wrong_mode, busy_refusal(), scipy_problem())

    def prepare(self, context):
        from ...core import InputError
        from ..jobs.frames import read_frames
        from ..jobs.solve import Solve

        if self.frame_end <= self.frame_start:
            raise InputError(rpt_("The last frame must come after the first"))
        obj = context.active_object
        settings = in_object_units(solver_settings(self), obj)
        numbers = range(self.frame_start, self.frame_end + 1)
        self._session_uid = obj.session_uid
        self._frames = read_frames(obj, numbers)
        return [
            Solve(*frame.data, settings, name=rpt_("Frame {:d}").format(frame.number))
            for frame in self._frames
        ]

    def conclude(self, context, solves, *, is_stopped):
        from ..jobs.keyed_object import show_frames
        from ..jobs.write_back import object_of

        done = [
            (frame, solve.kept)
            for frame, solve in zip(self._frames, solves, strict=True)
            if solve.kept is not None
        ]
        problems = [f"{each.name}: {each.error}" for each in solves if each.error is not None]
        for problem in problems:
            self.report({"WARNING"} if done else {"ERROR"}, problem)
        obj = object_of(self._session_uid)
        if obj is None:
            self.report({"ERROR"}, rpt_("the object was deleted during the run"))
            return {"CANCELLED"}
        if not done:
            if not problems:
                self.report({"INFO"}, rpt_("Stopped before the first frame was done"))
            return {"CANCELLED"}
        word = DENOISED if solves[0].is_denoise else FAIRED
        result = show_frames(obj, *zip(*done, strict=True), word=word)
        for each in context.selected_objects:
            each.select_set(False)
        result.select_set(True)
        context.view_layer.objects.active = result
        text = rpt_("Denoised {:d} frames, {:.1f} s")
        if not solves[0].is_denoise:
            text = rpt_("Faired {:d} frames, {:.1f} s")
        text = text.format(len(done), sum(solve.seconds for solve in solves))
        self.report({"INFO"}, rpt_("Stopped early. {:s}").format(text) if is_stopped else text)
        return {"FINISHED"}

    def _generator(self, solves):
        from ..jobs.frame_sequence import run_frames

        return run_frames(solves, one_strength=self.same_strength)


register, unregister = bpy.utils.register_classes_factory((OBJECT_OT_adaptive_fairing_sequence,))
