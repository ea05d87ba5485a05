"""Smoothing radius in local edge lengths, and the time τ that gives it on a mesh.

Diffusion over a time T spreads a point of the surface over a radius sqrt(2T), the standard
deviation of the heat kernel of the plane in one direction.  As T = τ d_i per step, τ alone does not
say how much detail is removed.  The radius divided by the local edge length does: below about one
edge only noise is removed, above three or four edges shapes of that size are removed too.

The ratio of two lengths is the same in the solver's frame and in object units.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from ..mesh.density import mesh_density
from ..mesh.input_checks import plain_array
from ..mesh.solver_mesh import SolverFrame, SolverSurface, solvable_surface
from ..mesh.topology import TriangleTopology, checked_triangles
from ..runtime.arrays import FloatArray
from .settings import TAU_RANGE, FairingSettings
from .timestep_field import local_times

EXTREME_FRACTION = 0.01
"""Fraction of the vertices that counts as the densest, and as the coarsest, part of a mesh."""


@dataclass(frozen=True)
class RadiusScale:
    """Growth of the smoothing radius with time in three parts of one mesh.

    Attributes
    ----------
    densest, typical, coarsest : float
        Smoothing radius there after a total time of 1, in local edge lengths.
    edge_densest, edge_typical, edge_coarsest : float
        Local edge length there, in object units.
    """

    densest: float
    typical: float
    coarsest: float
    edge_densest: float
    edge_typical: float
    edge_coarsest: float

    def radii(self, time: float) -> tuple[float, float, float]:
        """Smoothing radii after a total time, in local edge lengths.

        Parameters
        ----------
        time : float
            τ of one step, or its sum over several: squared radii add up.

        Returns
        -------
        (densest, typical, coarsest)
        """
        root = time**0.5
        return self.densest * root, self.typical * root, self.coarsest * root


def radius_scale(
    vertices: ArrayLike,
    faces: ArrayLike,
    settings: FairingSettings,
    *,
    surface: SolverSurface | None = None,
) -> RadiusScale:
    """Measure how far a unit of time smooths in the densest and coarsest parts of a mesh.

    Parameters
    ----------
    vertices : (n, 3)
        Positions in object units.
    faces : (m, 3)
        Triangles, as for `fair_steps`.
    settings : FairingSettings
        Method, density and frame count; τ, radius and the number of steps do not.
    surface : SolverSurface, optional
        Of these triangles (`PreparedMesh.surface`), where it is known.

    Raises
    ------
    InputError
        The faces are not triangles, or no edge has a length above 0.

    Source: T(x) = τ D(x) of section 3.2 of the paper; the radius sqrt(2T) from the heat kernel.
    """
    topology, positions, scale = _in_frame(vertices, faces, settings, surface)
    density = _density(topology, positions, settings)
    edges, radii = _edges_and_radii(topology, positions, settings, density)
    if not len(edges):
        raise InputError(
            "no edge of the mesh has a length, or no triangle an area: there is nothing to smooth"
        )
    by_length = np.argsort(edges)
    n_extreme = max(round(EXTREME_FRACTION * len(by_length)), 1)
    parts = by_length[:n_extreme], by_length, by_length[-n_extreme:]
    return RadiusScale(
        *(float(np.median(radii[part])) for part in parts),
        *(float(np.median(edges[part]) / scale) for part in parts),
    )


def equivalent_uniform_tau(
    vertices: ArrayLike, faces: ArrayLike, settings: FairingSettings
) -> float:
    """Find the τ of the uniform method that gives as much diffusion time as an adaptive method.

    Returns
    -------
    float
        Mean of τ d_i over the vertices that have a triangle.

    Parameters and errors as in `radius_scale`, but τ counts.
    """
    topology, positions, _ = _in_frame(vertices, faces, settings)
    density = _density(topology, positions, settings)
    tau = tau_of_run(topology, positions, settings, density)
    per_tau = local_times(settings, np.ones_like(density), density)
    return tau * float(per_tau[~topology.is_loose].mean())


def suggest_tau(scale: RadiusScale, radius: float, steps: int) -> float:
    """Find the τ by which all steps together reach a wanted radius in the typical part.

    Parameters
    ----------
    scale : RadiusScale
    radius : float
        Wanted radius after the last step, in local edge lengths.
    steps : int
    """
    return _tau(scale.typical, radius, steps)


def tau_of_run(
    topology: TriangleTopology,
    positions: FloatArray,
    settings: FairingSettings,
    density: FloatArray,
) -> float:
    """Find the τ of a run: that of the settings, or the one that their radius asks for.

    Parameters
    ----------
    topology : TriangleTopology
    positions : (n, 3)
        Where the run starts, in the solver's frame.
    settings : FairingSettings
    density : (n,)
        d_i there.

    Raises
    ------
    InputError
        The radius asks for a τ outside `TAU_RANGE`.
    """
    if settings.tau is not None:
        return settings.tau
    _, radii = _edges_and_radii(topology, positions, settings, density)
    if not len(radii):
        return 1.0  # no length, or no time that could move anything, whatever τ is
    tau = _tau(float(np.median(radii)), settings.radius, settings.steps)
    if not TAU_RANGE[0] < tau < TAU_RANGE[1]:
        raise InputError(
            f"a radius of {settings.radius:g} edges means τ = {tau:g} on this mesh, which no solve "
            'can take; choose another radius, or normalize="box"'
        )
    return tau


def _tau(typical: float, radius: float, steps: int) -> float:
    return (radius / typical) ** 2 / steps


def _edges_and_radii(
    topology: TriangleTopology,
    positions: FloatArray,
    settings: FairingSettings,
    density: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Local edges (k,), and the smoothing radius in them (k,) after a time of 1.

    Vertices without an edge of positive length, or without time, are left out.
    """
    edges = mesh_density(topology, positions, "edge_length", smoothing_passes=0)
    per_tau = local_times(settings, np.ones_like(density), density)
    used = np.flatnonzero((edges > 0) & (per_tau > 0))
    return edges[used], np.sqrt(2 * per_tau[used]) / edges[used]


def _in_frame(
    vertices: ArrayLike,
    faces: ArrayLike,
    settings: FairingSettings,
    surface: SolverSurface | None = None,
) -> tuple[TriangleTopology, FloatArray, float]:
    """Topology of the solver's mesh, positions in the solver's frame, scale of that frame."""
    points = plain_array(vertices, "vertices").astype(np.float64)
    triangles = checked_triangles(faces, len(points))
    if not len(triangles):
        raise InputError("the mesh has no triangles: there is no surface to fair")
    surface = surface or solvable_surface(points, triangles)
    frame = SolverFrame.of(points, surface, settings.normalize)
    return surface.topology, frame.inward(points), frame.scale


def _density(
    topology: TriangleTopology, positions: FloatArray, settings: FairingSettings
) -> FloatArray:
    return mesh_density(topology, positions, settings.density, settings.density_passes)
