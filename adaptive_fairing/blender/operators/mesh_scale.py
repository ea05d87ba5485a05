"""Scale of τ on the mesh at hand, measured once per mesh for the panel or by its operator.

The panel is drawn many times a second, so drawing only looks the scale up. A mesh without a known
scale is measured shortly after, outside of drawing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from ..data.display import display_of
from ..data.mesh_arrays import checksum, read_mesh_coordinates
from ..jobs.kept_preparation import preparations
from ..properties import FairingSceneSettings as Settings
from ..properties import fairing_settings
from ..requirements import scipy_problem
from .modal_run import redraw_panels
from .polls import is_allowed, no_active_mesh_refusal

if TYPE_CHECKING:
    from ...core.diffusion.smoothing_radius import RadiusScale

LARGEST_UNASKED = 200_000
"""Largest number of polygons that is measured without being asked: a fraction of a second."""

REMEMBERED = 32

Key = tuple[object, ...]

_known: dict[Key, RadiusScale | str] = {}
_wanted: list[tuple[Key, str, bpy.types.PropertyGroup]] = []


class OBJECT_OT_adaptive_fairing_measure(bpy.types.Operator):
    bl_idname = "object.adaptive_fairing_measure"
    bl_label = "Measure Mesh"
    bl_description = "Find out what τ and the radius mean on the active mesh"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context):
        problem = scipy_problem() or no_active_mesh_refusal(context)
        if problem is None and context.active_object.mode == "EDIT":
            problem = "Leave Edit Mode to measure the mesh"
        return is_allowed(cls, problem)

    def execute(self, context):
        scale = measure(context.active_object, context.scene.adaptive_fairing)
        if isinstance(scale, str):
            self.report({"ERROR"}, scale)
            return {"CANCELLED"}
        return {"FINISHED"}


def known_scale(obj: bpy.types.Object, properties: Settings) -> RadiusScale | str | None:
    """Look up the scale of a mesh, or the reason why it has none; None if it is not measured."""
    if obj.mode == "EDIT":  # its coordinates cannot be read
        return None
    return _known.get(_key(obj, properties))


def measure(obj: bpy.types.Object, properties: Settings) -> RadiusScale | str:
    """Measure the shape that a run would start from; remember the scale, or why there is none."""
    from ...core import FairingError
    from ...core.diffusion.smoothing_radius import radius_scale
    from ..jobs.write_back import read_start

    start, triangles = read_start(obj, from_original=properties.from_original)
    known = preparations.known(triangles, len(start))
    surface = None if known is None else known.surface
    try:
        scale = radius_scale(start, triangles, fairing_settings(properties), surface=surface)
    except FairingError as error:
        scale = str(error)
    while len(_known) >= REMEMBERED:
        del _known[next(iter(_known))]
    _known[_key(obj, properties)] = scale
    return scale


def noise_length(obj: bpy.types.Object, properties: Settings, scale: RadiusScale) -> float:
    """Size of the noise, which is given in edges, as a length in the world."""
    return properties.width * scale.edge_typical * obj.matrix_world.median_scale


def measure_soon(obj: bpy.types.Object, properties: Settings) -> bool:
    """Schedule the measurement of a mesh after drawing, unless it is too large or in Edit Mode.

    Returns
    -------
    bool
        Whether it will be measured.
    """
    if obj.mode == "EDIT" or len(obj.data.polygons) > LARGEST_UNASKED:
        return False
    if not bpy.app.timers.is_registered(_measure_wanted):
        _wanted[:] = [(_key(obj, properties), obj.name, properties.id_data.name)]
        bpy.app.timers.register(_measure_wanted, first_interval=0.05)
    return True


def _measure_wanted() -> None:
    """Timer that measures the mesh that the panel asked for, if it still exists."""
    for key, object_name, scene_name in _wanted:
        obj, scene = bpy.data.objects.get(object_name), bpy.data.scenes.get(scene_name)
        if obj is None or scene is None or obj.type != "MESH" or obj.mode == "EDIT":
            continue
        if _key(obj, scene.adaptive_fairing) == key:
            measure(obj, scene.adaptive_fairing)
    _wanted.clear()
    redraw_panels(bpy.context, "WINDOW")  # a length is also shown in the view


def _key(obj: bpy.types.Object, properties: Settings) -> Key:
    """Key of everything that the scale depends on, cheap to compare."""
    mesh = obj.data
    shown = checksum(read_mesh_coordinates(mesh)), display_of(obj).place
    faces = len(mesh.edges), len(mesh.polygons)
    density = properties.density, properties.density_passes
    if properties.scheme == "UNIFORM":
        density = ()
    frame = properties.normalize, properties.from_original
    return (obj.session_uid, *shown, *faces, *frame, *density)


def clear() -> None:
    """Forget the meshes of the file that is being closed."""
    _known.clear()
    _wanted.clear()


_register_classes, _unregister_classes = bpy.utils.register_classes_factory(
    (OBJECT_OT_adaptive_fairing_measure,)
)


def register() -> None:
    """Register the operator."""
    _register_classes()


def unregister() -> None:
    """Unregister it, and the timer."""
    if bpy.app.timers.is_registered(_measure_wanted):
        bpy.app.timers.unregister(_measure_wanted)
    _unregister_classes()
