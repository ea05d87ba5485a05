"""What a solve reads from Blender's data, and what it stores there: result, record, density."""

from __future__ import annotations

import bpy
import numpy as np
from bpy.app.translations import pgettext_rpt as rpt_

from ...core import FairingError, FairingSettings
from ...files.output_words import DENOISED, FAIRED
from ..data import results
from ..data.coloring import write_field
from ..data.display import display_of, leaves_keys
from ..data.display_base import Display
from ..data.fields import density_and_scale
from ..data.mesh_arrays import MeshData, read_triangles
from ..data.shown_surface import control_read
from ..data.stored_path import StoredPath
from ..data.targets import remove_mesh, written_or_restored
from .solve import Solve


def read_start(obj: bpy.types.Object, *, from_original: bool = False) -> MeshData:
    """Read what a run starts from: the shape shown, or the original one if there is any.

    Of a refined result, read the control mesh.
    """
    display = display_of(obj)
    with control_read(display):
        return MeshData(_start(display, from_original).astype(float), read_triangles(obj.data))


def _start(display: Display, from_original: bool) -> np.ndarray:
    original = display.original() if from_original else None
    return display.shown() if original is None else original


def store_solve(
    solve: Solve,
    source: bpy.types.Object,
    *,
    way: str,
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
    way
        How the object stores the result, see `properties.way_of`.
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
    require_unchanged(solve, _start(display_of(source), from_original))
    word = DENOISED if solve.is_denoise else FAIRED
    with written_or_restored(source, in_place=leaves_keys(way), word=word) as obj:
        write_result(obj, solve, way, from_original=from_original)
        obj.adaptive_fairing.keeps_density = store_density
        if store_density:
            write_field(obj.data, "DENSITY", _density(solve))
    return obj


def write_result(
    obj: bpy.types.Object, solve: Solve, way: str, *, from_original: bool = False
) -> None:
    """Write the shapes and the record of a result to an object that may be changed.

    Parameters as in `store_solve`.
    """
    path = StoredPath.through(solve.vertices.astype(np.float32), solve.knots, solve.shapes)
    place, weights = solve.knots[solve.shown], solve.weights
    results.store(obj, path, place, way, weights=weights, from_original=from_original)
    _write_record(obj, solve)


def share_result(solve: Solve, obj: bpy.types.Object, others: list[bpy.types.Object]) -> None:
    """Pass the result of a solve on to other objects that had the same mesh before."""
    before, display = others[0].data, display_of(obj)
    meshes = {before, *(each.adaptive_fairing.control for each in others)} - {None}
    for other in others:
        display.share(other)
        _write_record(other, solve)
    if before.users == 0:
        before.name, obj.data.name = f"{before.name} before", before.name
    for mesh in meshes:
        remove_mesh(mesh)


def _density(solve: Solve) -> np.ndarray:
    """Density (n,) of the last step, or for `denoise` of the result."""
    if solve.steps:
        return solve.steps[-1].density
    return density_and_scale(solve.positions, solve.triangles, FairingSettings())[0]


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


def object_of(session_uid: int) -> bpy.types.Object | None:
    """Find an object by its number, which it keeps as long as the file is open."""
    return next((obj for obj in bpy.data.objects if obj.session_uid == session_uid), None)


def _write_record(obj: bpy.types.Object, solve: Solve) -> None:
    """Write the measures and the notes of the run to the record of the object."""
    record, result = obj.adaptive_fairing, solve.denoised
    record.seconds, record.shown = solve.seconds, solve.shown + 1
    record.notes = "\n".join(solve.notes)
    if result is None:
        record.tau, record.stop_reason = solve.steps[-1].tau, solve.stop_reason or "stopped"
        record.iterations = sum(step.solve.iterations for step in solve.steps)
    else:
        record.tau, record.stop_reason = 0.0, ""
        record.iterations = result.solve.iterations
        record.noise, record.noise_length = result.noise_level, result.noise_length
        record.radius, record.is_sharp = result.radius, result.is_sharp
    strengths = [0.0] * len(solve.shapes) if result is None else solve.knots
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
