"""What the time τ means on one mesh: the smoothing radius, counted in local edge lengths.

Diffusion over a time T spreads a point of the surface over a radius sqrt(2T), the standard
deviation of the heat kernel of the plane in one direction.  With T = τ d_i per step, a bare τ says
nothing about how much detail goes; the radius divided by the local edge length does: below about
one edge only noise goes, above three or four edges shapes of that size go too.

The ratio of two lengths is the same in the frame of the solver and in object units.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from ..mesh.density import mesh_density
from ..mesh.solver_mesh import SolverFrame, solvable_surface
from ..mesh.topology import TriangleTopology, checked_triangles
from ..runtime.arrays import FloatArray
from .settings import FairingSettings

EXTREME_FRACTION = 0.01
"""Fraction of the vertices that counts as the densest, and as the coarsest, part of a mesh."""


@dataclass(frozen=True)
class RadiusScale:
    """How the smoothing radius grows with time in three parts of one mesh.

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


def radius_scale(vertices: ArrayLike, faces: ArrayLike, settings: FairingSettings) -> RadiusScale:
    """Measure how far a unit of time smooths in the densest and coarsest parts of a mesh.

    Parameters
    ----------
    vertices : (n, 3)
        Positions in object units.
    faces : (m, 3)
        Triangles, as for `fair_steps`.
    settings : FairingSettings
        The method, the density and the frame; τ and the number of steps play no part.

    Raises
    ------
    InputError
        Faces that are no triangles, or no edge of positive length to measure against.

    Source: T(x) = τ D(x) of section 3.2 of the paper; the radius sqrt(2T) from the heat kernel.
    """
    topology, positions, scale = _in_frame(vertices, faces, settings)
    edges = mesh_density(topology, positions, "edge_length", smoothing_passes=0)
    used = np.flatnonzero(edges > 0)
    if not len(used):
        raise InputError("no edge of the mesh has a length: there is nothing to smooth")
    edges = edges[used]
    radii = np.sqrt(2 * _timestep_per_tau(topology, positions, settings)[used]) / edges
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
    """Find the τ with which the uniform method spends as much time as an adaptive one.

    Returns
    -------
    float
        Mean of τ d_i over the vertices that have a triangle.

    Parameters, errors: as in `radius_scale`, but τ counts.
    """
    topology, positions, _ = _in_frame(vertices, faces, settings)
    per_tau = _timestep_per_tau(topology, positions, settings)
    return settings.tau * float(per_tau[~topology.is_loose].mean())


def suggest_tau(scale: RadiusScale, radius: float, steps: int) -> float:
    """Find the τ with which all steps together smooth over a wanted radius in a typical part.

    Parameters
    ----------
    scale : RadiusScale
    radius : float
        Wanted radius after the last step, in local edge lengths.
    steps : int
    """
    return (radius / scale.typical) ** 2 / steps


def _in_frame(
    vertices: ArrayLike, faces: ArrayLike, settings: FairingSettings
) -> tuple[TriangleTopology, FloatArray, float]:
    """Give the mesh as the solver sees it: topology, positions in its frame, the frame's scale."""
    points = np.asarray(vertices, dtype=np.float64)
    triangles = checked_triangles(np.asarray(faces), len(points))
    if not len(triangles):
        raise InputError("the mesh has no triangles: there is no surface to fair")
    surface = solvable_surface(points, triangles)
    frame = SolverFrame.of(points, surface, settings.normalize)
    return surface.topology, frame.inward(points), frame.scale


def _timestep_per_tau(
    topology: TriangleTopology, positions: FloatArray, settings: FairingSettings
) -> FloatArray:
    """Local time that one unit of τ makes: d_i, or 1 for the uniform method."""
    if settings.method == "uniform":
        return np.ones(topology.n_vertices)
    return mesh_density(topology, positions, settings.density, settings.density_passes)
