"""What the time τ means on one mesh: the smoothing radius, counted in local edge lengths.

Diffusion over a time T spreads a point of the surface over a radius sqrt(2T) (the standard
deviation of the heat kernel in one direction). With T = τ d_i per step, a bare τ says nothing about
how much detail goes; the radius divided by the local edge length does: below about one edge only
noise goes, above three or four edges shapes of that size go too.

All of it lives in the frame of the solver, where the mesh's box fits [-3, 3]^3; a ratio of two
lengths is the same in every frame.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .density import mesh_density
from .errors import InputError
from .topology import TriangleTopology

FRAME_SIZE = 6.0
"""Longest side of the mesh's box in the frame of the solver (the paper's [-3, 3]^3)."""

EXTREME_SHARE = 0.01
"""Share of the vertices that counts as the densest and as the coarsest part."""


@dataclass(frozen=True)
class RadiusScale:
    """How the smoothing radius grows with time in three parts of one mesh.

    Attributes
    ----------
    edge_densest, edge_typical, edge_coarsest
        Local edge length there, in object units.
    densest, typical, coarsest
        Smoothing radius there after a total time Στ = 1, in local edge lengths. The radius after
        another time is this factor times the root of it.
    """

    edge_densest: float
    edge_typical: float
    edge_coarsest: float
    densest: float
    typical: float
    coarsest: float

    def radii(self, time: float) -> tuple[float, float, float]:
        """Smoothing radius in local edge lengths after a total time (sum of τ over the steps).

        Returns
        -------
        tuple of float
            In the densest, a typical and the coarsest part.
        """
        root = float(np.sqrt(time))
        return self.densest * root, self.typical * root, self.coarsest * root


def local_edge_lengths(topology: TriangleTopology, positions: np.ndarray) -> np.ndarray:
    """Mean length of the edges at every vertex.

    Parameters
    ----------
    topology
        Connectivity of the mesh.
    positions
        Vertex positions, (n, 3).

    Returns
    -------
    ndarray
        (n,), in the unit of the positions; NaN at a vertex without an edge.
    """
    triangles = topology.triangles
    edges = np.concatenate((triangles[:, :2], triangles[:, 1:], triangles[:, ::2]))
    edges = np.unique(np.sort(edges, axis=1), axis=0)
    lengths = np.linalg.norm(positions[edges[:, 0]] - positions[edges[:, 1]], axis=1)
    ends = edges.ravel()
    total = np.bincount(ends, np.repeat(lengths, 2), minlength=len(positions))
    count = np.bincount(ends, minlength=len(positions))
    return np.divide(total, count, out=np.full(len(positions), np.nan), where=count > 0)


def radius_scale(
    vertices: np.ndarray,
    faces: np.ndarray,
    *,
    method: str,
    density: str = "edge_length",
    density_passes: int = 3,
    normalize: bool = True,
) -> RadiusScale:
    """Measure how far a unit of time smooths in the densest and coarsest parts of a mesh.

    Parameters
    ----------
    vertices
        (n, 3) positions in object units.
    faces
        (m, 3) triangles.
    method, density, density_passes, normalize
        As in `FairingSettings`. For "uniform" the timestep is τ everywhere, else τ times the
        smoothed density d_i.

    Raises
    ------
    InputError
        If no vertex has an edge of positive length, so that there is nothing to measure against.

    Source: paper, section 3.3: T(x) = τ D(x); radius sqrt(2T) from the heat kernel of the plane.
    """
    vertices = np.asarray(vertices, dtype=np.float64)
    topology = TriangleTopology(faces, len(vertices))
    lengths = local_edge_lengths(topology, vertices)
    used = np.flatnonzero(lengths > 0.0)
    if not len(used):
        raise InputError("the mesh has no edge of positive length; there is nothing to smooth")
    box = np.ptp(vertices, axis=0).max()
    to_frame = FRAME_SIZE / box if normalize else 1.0
    if method == "uniform":
        multiplier = np.ones(len(vertices))
    else:
        multiplier = mesh_density(topology, vertices * to_frame, density, density_passes)

    edges = lengths[used]
    radii = np.sqrt(2.0 * multiplier[used]) / (edges * to_frame)
    order = np.argsort(edges)
    share = max(1, int(EXTREME_SHARE * len(order)))
    parts = order[:share], order, order[-share:]
    return RadiusScale(
        *(float(np.median(edges[part])) for part in parts),
        *(float(np.median(radii[part])) for part in parts),
    )


def suggest_tau(scale: RadiusScale, radius: float, steps: int) -> float:
    """τ with which all steps together smooth over a wanted radius in a typical part.

    Parameters
    ----------
    scale
        What `radius_scale` measured.
    radius
        Wanted radius after the last step, in local edge lengths.
    steps
        Number of steps.
    """
    return (radius / scale.typical) ** 2 / steps
