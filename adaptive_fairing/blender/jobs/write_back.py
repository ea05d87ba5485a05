"""Storage of a solve in Blender's data: shape keys, attributes, the record."""

from __future__ import annotations

import bpy
import numpy as np
from bpy.app.translations import pgettext_rpt as rpt_

from ...core import FairingError, FairingSettings
from ...files.output_words import DENOISED, FAIRED
from ..data import results
from ..data.control_mesh import control_read
from ..data.display import display_of
from ..data.field_attributes import write_density
from ..data.fields import shown_density
from ..data.rollback import remove_mesh, written_or_restored
from .solve import Solve


def store_solve(
    solve: Solve,
    source: bpy.types.Object,
    *,
    way: str,
    output: str,
    store_density: bool,
    from_original: bool = False,
) -> bpy.types.Object:
    """Write the result of a solve that has changed something.

    Parameters
    ----------
    solve
        A finished solve.
    source
        Object that was read, on its control mesh.
    way, output
        How the object stores a result of `denoise` and of the paper's methods, see
        `OutputProperties.result` and `.output`.
    store_density
        Whether to store the density as attributes.
    from_original
        Whether the solve started from the original shape, not from the shown one.

    Returns
    -------
    bpy.types.Object
        The object with the result: the one that was read, or a copy of it.

    Raises
    ------
    FairingError
        The shape of the object was changed after it was read.
    """
    require_unchanged(solve, _start(source, from_original))
    in_place = solve.is_denoise and way == "MODIFIER"
    word = DENOISED if solve.is_denoise else FAIRED
    with written_or_restored(source, in_place=in_place, word=word) as obj:
        write_result(obj, solve, way=way, output=output, from_original=from_original)
        obj.adaptive_fairing.keeps_density = store_density
        if store_density:
            write_density(obj.data, _density(solve))
    return obj


def write_result(
    obj: bpy.types.Object,
    solve: Solve,
    *,
    way: str = "LIVE",
    output: str = "ABSOLUTE_KEYS",
    from_original: bool = False,
) -> None:
    """Write the shapes and the record of a result to an object that may be changed.

    Parameters as in `store_solve`.
    """
    start = solve.vertices.astype(np.float32)
    if solve.is_denoise:
        result = solve.denoised
        results.store_strengths(
            obj,
            start,
            solve.shapes,
            result.strengths.tolist(),
            solve.settings.strength,
            way,
            weights=solve.weights,
            from_original=from_original,
        )
    else:
        results.store_steps(obj, start, solve.shapes, output)
    _write_record(obj, solve)


def share_result(solve: Solve, obj: bpy.types.Object, others: list[bpy.types.Object]) -> None:
    """Pass the result of a solve on to other objects that had the same mesh before."""
    before = others[0].data
    meshes = {before, *(each.adaptive_fairing.control for each in others)} - {None}
    for other in others:
        display_of(obj).share(other)
        _write_record(other, solve)
    if before.users == 0:
        before.name, obj.data.name = f"{before.name} before", before.name
    for mesh in meshes:
        remove_mesh(mesh)


def _density(solve: Solve) -> np.ndarray:
    """Density (n,) of the last step, or for `denoise` of the result."""
    if solve.steps:
        return solve.steps[-1].density
    return shown_density(solve.positions, solve.triangles, FairingSettings())


def find_object(solve: Solve) -> bpy.types.Object:
    """Find the object of a solve, even if it was renamed.

    Raises
    ------
    FairingError
        It was deleted, or is no mesh any more.
    """
    obj = object_of(solve.session_uid)
    if obj is None or obj.type != "MESH":
        raise FairingError(rpt_("the object was deleted during the run"))
    return obj


def require_unchanged(solve: Solve, positions: np.ndarray) -> None:
    """Check that an object still has the positions (n, 3) that a solve has read.

    Raises
    ------
    FairingError
        It has others.
    """
    if not np.array_equal(positions, solve.vertices):
        raise FairingError(rpt_("the mesh was changed during the run; nothing was written"))


def start_positions(obj: bpy.types.Object, *, from_original: bool) -> np.ndarray:
    """Positions (n, 3) that a run starts from: those shown, or the original ones if there are any.

    For a refined result, the positions of its control mesh.
    """
    with control_read(obj):
        return _start(obj, from_original)


def _start(obj: bpy.types.Object, from_original: bool) -> np.ndarray:
    display = display_of(obj)
    original = display.original() if from_original else None
    return display.shown() if original is None else original


def object_of(session_uid: int) -> bpy.types.Object | None:
    """Find an object by its number, which it keeps as long as the file is open."""
    return next((obj for obj in bpy.data.objects if obj.session_uid == session_uid), None)


def _write_record(obj: bpy.types.Object, solve: Solve) -> None:
    """Write the measures and the notes of the run to the record of the object."""
    record = obj.adaptive_fairing
    result = solve.denoised
    record.tau = 0.0 if solve.is_denoise else solve.steps[-1].tau
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
