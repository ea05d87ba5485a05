"""Numbers per vertex worth looking at: density, displacement, what was removed, curvature."""

from __future__ import annotations

import bpy
import numpy as np
from bpy.app.translations import pgettext_rpt as rpt_
from numpy.typing import ArrayLike, NDArray

from ...core import FairingSettings, InputError, LoopSpace, TriangleTopology, mesh_density
from ...core.mesh.normals import vertex_normals
from ...core.mesh.solver_mesh import SolverFrame, solvable_surface
from .mesh_arrays import read_mesh

FloatArray = NDArray[np.float64]

COMPARED_FIELDS = ("DISPLACEMENT", "REMOVED")
"""Fields that tell the shown shape from the one before the run."""


def field_values(
    obj: bpy.types.Object,
    field: str,
    settings: FairingSettings,
    before: ArrayLike | None = None,
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
    before
        (n, 3) positions before the run, if known; None takes the undeformed mesh, which is that
        shape unless the result of a run is the final shape alone.

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
    data = read_mesh(obj.data)
    shown = shown_positions(obj, data.vertices)
    if before is not None:
        original = np.asarray(before, dtype=np.float64)
    elif field in COMPARED_FIELDS and _is_final_shape(obj):
        raise InputError(
            rpt_(
                "the shape before the smoothing was not kept: choose another Result than Final "
                "Shape Only to see this"
            )
        )
    else:
        original = data.vertices
    if field == "DISPLACEMENT":
        return np.linalg.norm(shown - original, axis=1)
    if not len(data.triangles):
        raise InputError("the mesh has no faces: there is no surface to look at")
    surface = solvable_surface(original, data.triangles)
    frame = SolverFrame.of(original, surface, settings.normalize)
    topology = surface.topology
    positions = shown[surface.vertex_of]
    if field == "REMOVED":
        moved = original[surface.vertex_of] - positions
        # Of the shown surface: the normals of the one before are as noisy as what was removed.
        removed = np.einsum("id,id->i", moved, vertex_normals(topology, positions))
        return frame.to_caller(np.where(topology.is_loose, np.nan, removed))
    if field == "CURVATURE":
        return frame.to_caller(mean_curvature(topology, positions, settings.quadrature_tolerance))
    density = mesh_density(topology, frame.inward(shown), settings.density, settings.density_passes)
    return frame.to_caller(np.where(topology.is_loose, np.nan, density))


def _is_final_shape(obj: bpy.types.Object) -> bool:
    """Whether a run has moved the vertices themselves, so that no key holds the shape before."""
    return obj.data.shape_keys is None and bool(obj.adaptive_fairing.shapes)


def shown_positions(obj: bpy.types.Object, undeformed: FloatArray) -> FloatArray:
    """Mix the shape keys of an object as Blender does, (n, 3); without keys its positions.

    Relative keys are taken at their values, without vertex groups and muting; absolute keys
    straight between the two neighbours of the evaluation time.
    """
    keys = obj.data.shape_keys
    if keys is None:
        return undeformed
    blocks = keys.key_blocks
    if not keys.use_relative:
        frames = np.array([block.frame for block in blocks])
        after = int(np.clip(np.searchsorted(frames, keys.eval_time), 1, len(frames) - 1))
        span = frames[after] - frames[after - 1]
        share = np.clip((keys.eval_time - frames[after - 1]) / span, 0.0, 1.0)
        before = _key_positions(blocks[after - 1])
        return before + share * (_key_positions(blocks[after]) - before)
    shown = undeformed.copy()
    for block in blocks[1:]:
        if block.value:
            relative_to = _key_positions(block.relative_key)
            shown += block.value * (_key_positions(block) - relative_to)
    return shown


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


def _key_positions(block: bpy.types.ShapeKey) -> FloatArray:
    buffer = np.empty(3 * len(block.points), dtype=np.float32)
    block.points.foreach_get("co", buffer)
    return buffer.reshape(-1, 3).astype(np.float64)
