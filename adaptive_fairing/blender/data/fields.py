"""Numbers per vertex worth looking at: density, displacement, what was removed, curvature."""

from __future__ import annotations

import bpy
import numpy as np
from bpy.app.translations import pgettext_rpt as rpt_
from numpy.typing import NDArray

from ...core import FairingSettings, InputError, LoopSpace, TriangleTopology, mesh_density
from ...core.mesh.normals import vertex_normals
from ...core.mesh.solver_mesh import SolverFrame, solvable_surface
from .attributes import COMPARED_FIELDS
from .mesh_arrays import read_positions, read_triangles
from .results import original_positions, shown_positions

FloatArray = NDArray[np.float64]


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
        "DENSITY", "DISPLACEMENT", "REMOVED" or "CURVATURE".
    settings
        Say how the density is measured.

    Returns
    -------
    (n,) array
        Density d_i in the solver's frame; displacement from the shape before in object units, or
        of what was removed the part along the normal, positive where a bump was taken off; mean
        curvature in 1 / object units. NaN where the field has no value.

    Raises
    ------
    InputError
        The mesh has no faces, which all but the displacement need; or the shape before is not
        known, which displacement and what was removed are measured from.
    """
    shown = shown_positions(obj).astype(np.float64)
    original = original_positions(obj)
    if original is None:
        original = read_positions(obj.data)
        if field in COMPARED_FIELDS and obj.adaptive_fairing.shapes:
            raise InputError(rpt_("the shape before the smoothing was not kept"))
    original = original.astype(np.float64)
    triangles = read_triangles(obj.data)
    if field == "DISPLACEMENT":
        return np.linalg.norm(shown - original, axis=1)
    if not len(triangles):
        raise InputError("the mesh has no faces: there is no surface to look at")
    if field == "REMOVED":
        # Of the shown surface: the normals of the one before are as noisy as what was removed.
        normals = _vertex_normals(shown, triangles)
        removed = np.einsum("id,id->i", original - shown, normals)
        return np.where(normals.any(axis=1), removed, np.nan)
    surface = solvable_surface(original, triangles)
    frame = SolverFrame.of(original, surface, settings.normalize)
    topology = surface.topology
    positions = shown[surface.vertex_of]
    if field == "CURVATURE":
        return frame.to_caller(mean_curvature(topology, positions, settings.quadrature_tolerance))
    return shown_density(shown, triangles, settings)


def shown_density(
    positions: FloatArray, triangles: NDArray[np.int32], settings: FairingSettings
) -> FloatArray:
    """Compute the density d_i, (n,), in the solver's frame; NaN at loose vertices."""
    surface = solvable_surface(positions, triangles)
    frame = SolverFrame.of(positions, surface, settings.normalize)
    topology = surface.topology
    density = mesh_density(
        topology, frame.inward(positions), settings.density, settings.density_passes
    )
    return frame.to_caller(np.where(topology.is_loose, np.nan, density))


def _vertex_normals(positions: FloatArray, triangles: NDArray[np.int32]) -> FloatArray:
    """Compute unit normals, (n, 3), weighted by area; 0 without a triangle. A slider waits."""
    a, b, c = (positions[triangles[:, corner]] for corner in range(3))
    of_triangles = np.cross(b - a, c - a)
    corners = triangles.ravel()
    normals = np.stack(
        [
            np.bincount(corners, np.repeat(of_triangles[:, axis], 3), len(positions))
            for axis in range(3)
        ],
        axis=1,
    )
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0)


def mean_curvature(
    topology: TriangleTopology, positions: FloatArray, quadrature_tolerance: float
) -> FloatArray:
    """Estimate the mean curvature at the vertices, positive where the surface bulges outward.

    Parameters
    ----------
    topology
        Connectivity.
    positions
        (n, 3) control points.
    quadrature_tolerance
        As in `FairingSettings`.

    Returns
    -------
    (n,) array
        1/r on a sphere of radius r; NaN on the boundary, where a boundary term is missing, and at
        loose vertices.

    Source: Δx = 2 H n, tested with the basis functions: L X = −∫ φi Δx, and the row sums of M for
    ∫ φi; H = (L X)_i · n_i / (2 ∫ φi) with the outward normal n.
    """
    space = LoopSpace(topology, quadrature_tolerance)
    lumped = space.mass_matrix(positions) @ np.ones(len(positions))
    flow = space.stiffness_matrix(positions) @ positions
    has_value = ~topology.on_boundary & ~topology.is_loose & (lumped > 0)
    curvature = np.full(len(positions), np.nan)
    normals = vertex_normals(topology, positions)
    along = np.einsum("id,id->i", flow[has_value], normals[has_value])
    curvature[has_value] = along / (2.0 * lumped[has_value])
    return curvature
