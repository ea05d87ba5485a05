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
from .control_mesh import LEVELS, control_read, is_refined
from .display import display_of
from .mesh_arrays import read_positions, read_triangles
from .refined_object import control_surface


class Field(NamedTuple):
    """Numbers per vertex (n,) and their unit: value · unit is in object units to a power."""

    values: FloatArray
    unit: float
    power: int


POWERS = {"DISPLACEMENT": 1, "REMOVED": 1, "CURVATURE": -1, "GAUSSIAN": -2}
"""Power of a length in the unit of a field; that of the density depends on its measure."""


def measure_field(obj: bpy.types.Object, field: str, settings: FairingSettings) -> Field:
    """Compute a field on the shape that an object shows, and its unit.

    Parameters, errors: as in `field_values`.
    """
    if field != "DENSITY":
        return Field(field_values(obj, field, settings), 1.0, POWERS[field])
    values, scale = _density_and_scale(*_surface_shown(obj), settings)
    power = 1 if settings.density == "edge_length" else 2
    return Field(values, scale**-power, power)


def field_values(
    obj: bpy.types.Object,
    field: str,
    settings: FairingSettings,
) -> FloatArray:
    """Compute a field on the shape that an object shows, modifiers aside.

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
    (n,) array
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
    if field == "DISPLACEMENT":
        return np.linalg.norm(display_of(obj).shown() - _positions_before(obj), axis=1)
    shown, triangles = _surface_shown(obj)
    if field == "DENSITY":
        return shown_density(shown, triangles, settings)
    if field in CURVATURE_FIELDS:
        return _curvatures(obj)[CURVATURE_FIELDS.index(field)]
    # Normals of the shown surface, because those of the original are as noisy as it is.
    normals = vertex_normals_of(triangles, shown)
    removed = np.einsum("id,id->i", _positions_before(obj) - shown, normals)
    return np.where(normals.any(axis=1), removed, np.nan)


def _surface_shown(obj: bpy.types.Object) -> tuple[FloatArray, NDArray[np.int32]]:
    """Read the shape that an object shows: positions (n, 3), triangles (m, 3)."""
    triangles = read_triangles(obj.data)
    if not len(triangles):
        raise InputError("the mesh has no faces: there is no surface to look at")
    return display_of(obj).shown().astype(np.float64), triangles


def _positions_before(obj: bpy.types.Object) -> FloatArray:
    """Read the shape (n, 3) before the runs; that of the mesh if there was no run."""
    original = display_of(obj).original()
    if original is None:
        if obj.adaptive_fairing.shapes:
            raise InputError(rpt_("the shape before the smoothing was not kept"))
        original = read_positions(obj.data)
    return original.astype(np.float64)


def _curvatures(obj: bpy.types.Object) -> FloatArray:
    """Compute mean and Gaussian curvature of the limit surface, (2, n); NaN at loose vertices."""
    levels = LEVELS[obj.adaptive_fairing.surface] if is_refined(obj) else 0
    with control_read(obj):
        cut = control_surface(obj.data)
        positions = display_of(obj).shown().astype(np.float64)[cut.vertex_of]
    values = LimitSurface.from_levels(cut.levels, positions).refined_curvature(levels)
    return RefinedNet(cut, levels).joined(values.T).T


def shown_density(
    positions: FloatArray, triangles: NDArray[np.int32], settings: FairingSettings
) -> FloatArray:
    """Compute the density d_i, (n,), in the solver's frame; NaN at loose vertices."""
    return _density_and_scale(positions, triangles, settings)[0]


def _density_and_scale(
    positions: FloatArray, triangles: NDArray[np.int32], settings: FairingSettings
) -> tuple[FloatArray, float]:
    """Compute the density as `shown_density` does, and a unit of that frame in object units."""
    surface = solvable_surface(positions, triangles)
    frame = SolverFrame.of(positions, surface, settings.normalize)
    topology = surface.topology
    density = mesh_density(
        topology, frame.inward(positions), settings.density, settings.density_passes
    )
    return frame.to_caller(np.where(topology.is_loose, np.nan, density)), frame.scale
