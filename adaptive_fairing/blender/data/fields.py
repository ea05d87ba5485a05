"""Fields of numbers per vertex: density, displacement, removed noise, curvatures."""

from __future__ import annotations

from typing import NamedTuple

import bpy
import numpy as np
from bpy.app.translations import pgettext_rpt as rpt_
from numpy.typing import NDArray

from ...core import FairingSettings, InputError, LimitSurface, mesh_density
from ...core.mesh.normals import vertex_normals_of
from ...core.mesh.solver_mesh import SolverFrame, solvable_surface
from ...core.runtime.arrays import FloatArray
from ...core.surface.refined_net import RefinedNet
from .color_map import CURVATURE_FIELDS
from .display import display_of
from .display_base import Display
from .mesh_arrays import read_positions, read_triangles
from .refined_object import control_surface
from .shown_surface import LEVELS, control_read


class Field(NamedTuple):
    """Numbers per vertex (n,) and their unit: value · unit is in object units to a power."""

    values: FloatArray
    unit: float
    power: int


POWERS = {"DISPLACEMENT": 1, "REMOVED": 1, "CURVATURE": -1, "GAUSSIAN": -2}
"""Power of a length in the unit of a field; that of the density depends on its measure."""


def measure_field(obj: bpy.types.Object, field: str, settings: FairingSettings) -> Field:
    """Compute a field on the shape that an object shows, modifiers aside, and its unit.

    Parameters
    ----------
    obj
        Mesh object in Object Mode.
    field
        "DENSITY", "DISPLACEMENT", "REMOVED", "CURVATURE" or "GAUSSIAN".
    settings
        Settings that choose how the density is measured.

    Returns
    -------
    Field
        Density d_i in the solver's frame; displacement from the original shape, in object units;
        removed noise, which is the displacement along the normal, positive where a bump was
        removed; mean curvature of the limit surface in 1 / object units, positive where it bulges
        outward; or its Gaussian curvature in 1 / object units². NaN where there is no value.

    Raises
    ------
    InputError
        The mesh has no faces, which all fields but the displacement need; or the original shape is
        not known, which displacement and removed noise need.
    """
    display, triangles = display_of(obj), read_triangles(obj.data)
    if field != "DISPLACEMENT" and not len(triangles):
        raise InputError("the mesh has no faces: there is no surface to look at")
    if field in CURVATURE_FIELDS:
        values = _curvatures(display)[CURVATURE_FIELDS.index(field)]
        return Field(values, 1.0, POWERS[field])
    shown = display.shown().astype(np.float64)
    if field == "DENSITY":
        values, scale = density_and_scale(shown, triangles, settings)
        power = 1 if settings.density == "edge_length" else 2
        return Field(values, scale**-power, power)
    moves = _positions_before(display) - shown
    if field == "DISPLACEMENT":
        return Field(np.linalg.norm(moves, axis=1), 1.0, POWERS[field])
    # Normals of the shown surface, because those of the original are as noisy as it is.
    normals = vertex_normals_of(triangles, shown)
    removed = np.where(normals.any(axis=1), np.einsum("id,id->i", moves, normals), np.nan)
    return Field(removed, 1.0, POWERS[field])


def _positions_before(display: Display) -> FloatArray:
    """Read the shape (n, 3) before the runs; that of the mesh if there was no run."""
    original = display.original()
    if original is None:
        if display.obj.adaptive_fairing.shapes:
            raise InputError(rpt_("the shape before the smoothing was not kept"))
        original = read_positions(display.obj.data)
    return original.astype(np.float64)


def _curvatures(display: Display) -> FloatArray:
    """Compute mean and Gaussian curvature of the limit surface, (2, n); NaN at loose vertices."""
    levels = LEVELS[display.obj.adaptive_fairing.surface] if display.is_refined else 0
    with control_read(display):
        cut = control_surface(display.obj.data)
        positions = display.shown().astype(np.float64)[cut.vertex_of]
    values = LimitSurface.from_levels(cut.levels, positions).refined_curvature(levels)
    return RefinedNet(cut, levels).joined(values.T).T


def density_and_scale(
    positions: FloatArray, triangles: NDArray[np.int32], settings: FairingSettings
) -> tuple[FloatArray, float]:
    """Compute the density d_i, (n,), in the solver's frame, and that frame's unit in object units.

    The density is NaN at loose vertices.
    """
    surface = solvable_surface(positions, triangles)
    frame = SolverFrame.of(positions, surface, settings.normalize)
    topology = surface.topology
    density = mesh_density(
        topology, frame.inward(positions), settings.density, settings.density_passes
    )
    return frame.to_caller(np.where(topology.is_loose, np.nan, density)), frame.scale
