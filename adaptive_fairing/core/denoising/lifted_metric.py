"""Metrics of diffusion that follow the mesh and the bending of a surface.

The paper's scalar diffusion tensor makes diffusion faster where the mesh is coarser.  Taken
further, the mesh itself gives the unit of length in every direction,

    ĝ = (1 - s) m + s g / h² + III / a²,

with the metric m in which every triangle is equilateral with unit edges, the surface's own metric
g in units of the local edge length h, and the third fundamental form III, in which the length of a
path is the angle by which the normal turns.  Two points are distant if many edges lie between them,
or if the normal turns by many times the angle a.  So diffusion with the Laplace-Beltrami operator
of ĝ runs along creases, not across them.

Here ĝ is constant on every triangle, and given by the squared lengths of its edges,

    q_ij = (1 - s) + s |x_i - x_j|² / h² + |n_i - n_j|² / a²

with the unit normals n of the vertices.  Functions are linear on every triangle.  That takes a
sixth of the matrix entries of the Loop basis; the filters are as good (research/notes.md).

Source: the anisotropic diffusion of the paper's references [3] and [4], written as a metric in the
spirit of N. Sochen, R. Kimmel and R. Malladi, A general framework for low level vision, 1998.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..linalg.edge_matrix import EdgeMatrix, EdgePattern
from ..runtime.arrays import FloatArray, IntArray
from ..runtime.threads import chunks
from .parameters import parameters
from .triangle_surface import TriangleSurface

# Triangles whose edges fit into the cache.
TRIANGLES_PER_CHUNK = 8192

# A triangle's metric counts as at least this definite: determinant relative to the
# square of the edges' squared lengths.
LEAST_DETERMINANT = 1e-8

# And an edge counts as at least so long, squared: a triangle may have collapsed to a point.
LEAST_SQUARE = 1e-12


class LiftedMetric(NamedTuple):
    """Parameters of ĝ.

    Attributes
    ----------
    surface_fraction : float
        s in [0, 1]: 0 takes lengths from the mesh alone, 1 from the surface.
    angle : float or None
        a > 0 in radians; None leaves the bending out.
    """

    surface_fraction: float = 0.0
    angle: float | None = None

    def lengths(
        self, surface: TriangleSurface, smooth: TriangleSurface | None = None
    ) -> FloatArray:
        """Squared lengths q of every triangle's edges in the metric ĝ of a surface, (3, m).

        Parameters
        ----------
        surface : TriangleSurface
        smooth : TriangleSurface, optional
            The same surface with less noise, to take the local edge length h from.
        """
        triangles, fraction = surface.topology.triangles, self.surface_fraction
        squares = np.full((3, len(triangles)), 1.0 - fraction)
        if fraction > 0:
            spacing = (smooth or surface).smooth_spacing
            first, second, third = (spacing.take(corners) for corners in triangles.T)
            mean = (first + second + third) / 3
            squares += fraction / mean**2 * squared_edges(triangles, surface.positions)
        if self.angle is not None:
            squares += squared_edges(triangles, surface.normals) / self.angle**2
        return np.maximum(squares, LEAST_SQUARE, out=squares)


def linear_elements(pattern: EdgePattern, squares: FloatArray) -> tuple[EdgeMatrix, EdgeMatrix]:
    """Mass and stiffness matrix for the squared lengths of the triangles' edges, (3, m).

    With `LiftedMetric.lengths`, time in (M + t L) is in squared edge lengths.
    """
    tuned = parameters()
    element = area_elements(squares)
    mass = pattern.summed(
        np.broadcast_to((1 - tuned.lumped_fraction) / 24 * element, (3, len(element)))
    )
    stiffness = pattern.summed(-half_cotangents(squares, element))
    # A third of a triangle belongs to each corner; rows of L add up to 0.
    on_diagonal = (1 + tuned.lumped_fraction) / (1 - tuned.lumped_fraction) * mass.row_sums()
    return mass.with_diagonal(on_diagonal), stiffness.with_diagonal(-stiffness.row_sums())


def boundary_flux(surface: TriangleSurface, squares: FloatArray) -> FloatArray:
    """Integrate ∂x/∂ν φ over the boundary, (n, 3): the part of L x that the boundary causes.

    Without this part L x is 0 on a plane, on its boundary as well as inside.

    Parameters
    ----------
    surface : TriangleSurface
        With positions x.
    squares : (3, m)
        Squared lengths of the triangles' edges in the metric.
    """
    topology, positions = surface.topology, surface.positions
    flux = np.zeros((topology.n_vertices, 3))
    triangle, first = np.divmod(np.flatnonzero(topology.twin < 0), 3)
    own = squares[:, triangle]
    cotangents = half_cotangents(own, area_elements(own))
    second, third, each = (first + 1) % 3, (first + 2) % 3, np.arange(len(first))
    ends = topology.triangles[triangle, first], topology.triangles[triangle, second]
    inner = positions[topology.triangles[triangle, third]]
    # φ of the corner opposite to a boundary edge falls at a constant rate towards it: the flux is
    # what ∫ ∇x · ∇φ says for that corner.  Half of it belongs to each end.
    towards = cotangents[third, each][:, None] * (positions[ends[0]] - inner)
    towards += cotangents[second, each][:, None] * (positions[ends[1]] - inner)
    for end in ends:
        np.add.at(flux, end, towards)
    return flux


def squared_edges(triangles: IntArray, points: FloatArray) -> FloatArray:
    """Squared lengths of every triangle's edges from corner k to the next, (3, n_triangles)."""
    squares = np.empty((3, len(triangles)))
    columns = np.ascontiguousarray(points.T)
    for own in chunks(len(triangles), TRIANGLES_PER_CHUNK):
        edges = edge_vectors(triangles[own], columns)
        np.square(edges, out=edges).sum(axis=0, out=squares[:, own])
    return squares


def edge_vectors(triangles: IntArray, columns: FloatArray) -> FloatArray:
    """Vectors of every triangle's edges from corner k to the next, (d, 3, n_triangles).

    The points are given by columns (d, n).
    """
    numbers = np.ascontiguousarray(triangles.T, dtype=np.intp)
    corners = columns.take(numbers, axis=1, mode="wrap")
    edges = np.empty_like(corners)
    np.subtract(corners[:, 1:], corners[:, :2], out=edges[:, :2])
    np.subtract(corners[:, 0], corners[:, 2], out=edges[:, 2])
    return edges


def area_elements(squares: FloatArray) -> FloatArray:
    """Twice the areas of triangles, (m,), from the squared lengths of their edges, (3, m)."""
    a, b, c = squares
    determinant = (2 * (a * b + b * c + c * a) - (a * a + b * b + c * c)) / 4
    least = LEAST_DETERMINANT * np.square(a + b + c)
    return np.sqrt(np.maximum(determinant, np.maximum(least, np.finfo(float).tiny)))


def half_cotangents(squares: FloatArray, elements: FloatArray) -> FloatArray:
    """Half the cotangents of the angles opposite to each edge, (3, m)."""
    cotangents: FloatArray = (squares.sum(axis=0) - 2 * squares) / (4 * elements)
    return cotangents
