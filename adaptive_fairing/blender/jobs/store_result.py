"""Write the result of a solve into Blender's data: shape keys, attributes, the record."""

from __future__ import annotations

import bpy
import numpy as np
from bpy.app.translations import pgettext_rpt as rpt_

from ...core import FairingError, FairingSettings
from ..data.attributes import write_density
from ..data.coloring import color_by_field
from ..data.mesh_arrays import read_positions
from ..data.rollback import written_or_restored
from ..data.shape_keys import write_absolute_keys, write_final_shape, write_relative_keys
from ..properties import AUTO
from .solve import Solve


def store_solve(solve: Solve, *, output: str, store_density: bool) -> bpy.types.Object:
    """Write the result of a solve that has one.

    Parameters
    ----------
    solve
        A solve that has been run.
    output
        Identifier of `OutputProperties.output`.
    store_density
        Whether to store the density of the last step as attributes.

    An object that is coloured by a field is coloured anew.

    Returns
    -------
    bpy.types.Object
        The object that has the result: the one that was read, or a copy of it.

    Raises
    ------
    FairingError
        The object is gone, or its mesh has been changed since it was read.
    """
    with written_or_restored(find_object(solve)) as obj:
        write_shapes(obj, solve, output=output, store_density=store_density)
        write_record(obj, solve)
        if obj.adaptive_fairing.view:
            settings = FairingSettings() if solve.is_denoise else solve.settings
            color_by_field(obj, obj.adaptive_fairing.view, settings, solve.vertices)
    return obj


def write_shapes(
    obj: bpy.types.Object,
    solve: Solve,
    *,
    output: str = "ABSOLUTE_KEYS",
    store_density: bool = True,
    vertex_of: np.ndarray | slice = slice(None),
) -> None:
    """Write the shapes of a result, and the density, to an object that may be written.

    Parameters
    ----------
    obj, solve, output, store_density
        As in `store_solve`.
    vertex_of
        Vertex of the solve for each vertex of the object.
    """
    shapes = [shape[vertex_of] for shape in solve.shapes]
    if output == "FINAL_SHAPE":
        write_final_shape(obj, shapes[solve.shown])
    elif output == "RELATIVE_KEYS":
        write_relative_keys(obj, shapes, solve.shown)
    else:
        write_absolute_keys(obj, shapes, solve.shown)
    if store_density and solve.steps:
        write_density(obj.data, solve.steps[-1].density[vertex_of])


def find_object(solve: Solve) -> bpy.types.Object:
    """Find the object of a solve again, whatever its name is now, with the mesh that was read.

    Raises
    ------
    FairingError
        As `store_solve`.
    """
    obj = object_of(solve.session_uid)
    if obj is None or obj.type != "MESH":
        raise FairingError(rpt_("the object was deleted during the run"))
    now = read_positions(obj.data)
    if now.shape != solve.vertices.shape or not np.array_equal(now, solve.vertices):
        raise FairingError(rpt_("the mesh was changed during the run; nothing was written"))
    return obj


def object_of(session_uid: int) -> bpy.types.Object | None:
    """Find an object by the number that it keeps as long as the file is open."""
    return next((obj for obj in bpy.data.objects if obj.session_uid == session_uid), None)


def write_record(obj: bpy.types.Object, solve: Solve) -> None:
    """Keep on the object what the run has measured and found; needs the add-on registered."""
    record = obj.adaptive_fairing
    result = solve.denoised
    record.method = AUTO if solve.is_denoise else solve.settings.method
    record.tau = 0.0 if solve.is_denoise else solve.settings.tau
    record.stop_reason = "" if solve.is_denoise else solve.stop_reason or "stopped"
    record.seconds = solve.seconds
    record.notes = "\n".join(solve.notes)
    record.shown = solve.shown + 1
    record.iterations = (
        sum(step.solve.iterations for step in solve.steps)
        if result is None
        else result.solve.iterations
    )
    if result is not None:
        record.noise = result.noise_level
        record.noise_length = result.noise_length
        record.radius = result.radius
        record.is_sharp = result.is_sharp
    strengths = [0.0] * len(solve.shapes) if result is None else result.strengths
    record.shapes.clear()
    for strength, shape, measures in zip(
        [0.0, *strengths], [solve.vertices, *solve.shapes], solve.measures, strict=True
    ):
        item = record.shapes.add()
        item.strength = strength
        item.curvature_energy = measures.curvature_energy
        item.area = measures.area
        item.volume = measures.volume
        item.displacement = np.linalg.norm(shape - solve.vertices, axis=1).max()
