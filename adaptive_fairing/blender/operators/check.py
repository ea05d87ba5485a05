"""The operator that examines a mesh before a run, and its findings.

The findings are remembered for the session, as long as the object has the shape that was examined
and the settings are the same.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import bpy
from bpy.app.translations import pgettext_rpt as rpt_

from ..choices import DENOISE
from ..data.mesh_arrays import checksum, read_mesh_coordinates
from ..data.multires import read_level, shown_level
from ..data.object_mode import object_mode
from ..properties import solver_settings
from ..requirements import scipy_problem
from .modal_run import ModalRun
from .polls import busy_refusal, is_allowed, no_active_mesh_refusal

if TYPE_CHECKING:  # the solver needs scipy, which may be missing
    from ...core import DenoiseSettings
    from ...core.denoising.examination import Examination


class Check(NamedTuple):
    """Findings on an object.

    Attributes
    ----------
    shape : str
        Checksum of the mesh that was examined.
    settings : DenoiseSettings
        Settings for which it was examined.
    found : Examination
    """

    shape: str
    settings: DenoiseSettings
    found: Examination


checks: dict[int, Check] = {}
"""Findings by the object's session_uid."""


class OBJECT_OT_adaptive_fairing_check(ModalRun, bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_check"
    bl_label = "Check Mesh"
    bl_description = (
        "Find out how much noise the active mesh has, how many parts it consists of, and what is "
        "wrong with it. Nothing is changed"
    )
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context):
        reasons = busy_refusal(), scipy_problem(), no_active_mesh_refusal(context)
        return is_allowed(cls, *reasons)

    def prepare(self, context):
        from ..jobs.examination import ExaminationJob
        from ..jobs.write_back import read_start

        obj, settings = context.active_object, _settings(context.scene)
        is_level = obj.mode != "EDIT" and shown_level(obj) is not None
        with object_mode(context):
            data = read_level(obj) if is_level else read_start(obj)
        return [ExaminationJob(*data, settings, name=obj.name, session_uid=obj.session_uid)]

    def conclude(self, context, solves, *, is_stopped):
        from ..jobs.write_back import object_of

        (job,) = solves
        obj = object_of(job.session_uid)
        if job.error is not None:
            self.report({"ERROR"}, f"{job.name}: {job.error}")
        if job.found is None or obj is None or obj.type != "MESH":
            return {"CANCELLED"}
        with object_mode(context):
            shape = checksum(read_mesh_coordinates(obj.data))
            checks[job.session_uid] = Check(shape, job.settings, job.found)
        if job.found.is_clean:
            text = rpt_("{:s}: looks clean")
        else:
            text = rpt_("{:s}: noise of {:.2g} edges")
        self.report({"INFO"}, text.format(job.name, job.found.noise_level))
        return {"FINISHED"}


def check_of(obj: bpy.types.Object | None) -> Examination | None:
    """Return the findings on an object, if its shape and the settings are still the same."""
    check = None if obj is None or obj.type != "MESH" else checks.get(obj.session_uid)
    if check is None or check.settings != _settings(bpy.context.scene):
        return None
    # In Edit Mode the coordinates cannot be read.
    holds = obj.mode == "EDIT" or check.shape == checksum(read_mesh_coordinates(obj.data))
    return check.found if holds else None


def _settings(scene: bpy.types.Scene) -> DenoiseSettings:
    """Read the settings of *Denoise* in a scene; the defaults, if another algorithm is chosen."""
    from ...core import DenoiseSettings

    settings = scene.adaptive_fairing
    return solver_settings(settings) if settings.algorithm == DENOISE else DenoiseSettings()


register, unregister = bpy.utils.register_classes_factory((OBJECT_OT_adaptive_fairing_check,))
