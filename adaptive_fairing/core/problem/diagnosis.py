"""Diagnosis of a mesh before or beside the solve: notes for the user, and culprits.

The rules are those of `mesh.manifold` and `fem.differential_geometry`; here the vertices to which
they apply are only counted and located.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from ..fem.differential_geometry import THINNEST_ASPECT
from ..mesh.input_checks import plain_array
from ..mesh.normals import dots
from ..mesh.solver_mesh import SolverSurface, solvable_surface
from ..mesh.topology import checked_triangles
from ..runtime.arrays import BoolArray, FloatArray, IndexArray, IntArray
from ..runtime.threads import ordered_map

# Triangles that one thread looks at in one go.
TRIANGLES_PER_CHUNK = 32768


@dataclass(frozen=True)
class MeshProblems:
    """Vertices of a mesh that the solve cannot treat like the others, as ascending indices.

    Attributes
    ----------
    not_finite : (k,) int
        Vertices whose coordinates are not finite: the mesh is refused.
    held : (k,) int
        Vertices where the mesh is cut for the solve; they do not move.
    left_out : (k,) int
        Corners of triangles that are left out, because they repeat a vertex or another triangle.
    thin : (k,) int
        Corners of triangles without area, whose metric is bounded for the solve.
    """

    not_finite: IndexArray
    held: IndexArray
    left_out: IndexArray
    thin: IndexArray

    @property
    def vertices(self) -> IndexArray:
        """Indices of all these vertices together, ascending."""
        parts = (self.not_finite, self.held, self.left_out, self.thin)
        return np.unique(np.concatenate(parts))


def find_problems(
    vertices: ArrayLike, faces: ArrayLike, surface: SolverSurface | None = None
) -> MeshProblems:
    """Locate what `fair_steps` refuses, holds or bounds in a mesh.

    Parameters
    ----------
    vertices : (n, 3) float
        Coordinates that are not finite are allowed here.
    faces : (m, 3) int
    surface : SolverSurface, optional
        What is solved on, where it is known already.

    Raises
    ------
    InputError
        The arrays have the wrong shape or type, or indices are out of range.
    """
    points = plain_array(vertices, "vertices").astype(np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise InputError(f"vertices must have shape (n, 3), not {points.shape}")
    triangles = checked_triangles(faces, len(points))
    is_finite = np.isfinite(points).all(axis=1)
    measurable = triangles[is_finite[triangles].all(axis=1)]
    if surface is None:
        surface = solvable_surface(np.where(is_finite[:, None], points, 0), triangles)
    return MeshProblems(
        not_finite=np.flatnonzero(~is_finite),
        held=np.unique(surface.vertex_of[surface.is_cut]),
        left_out=np.unique(triangles[surface.left_out]).astype(np.intp),
        thin=np.unique(measurable[_is_thin(points, measurable)]).astype(np.intp),
    )


def surface_notes(points: FloatArray, surface: SolverSurface) -> tuple[str, ...]:
    """Describe the defects of a mesh and how it was made solvable, one line each.

    Parameters
    ----------
    points : (n, 3)
        Finite positions of the surface's vertices.
    surface : SolverSurface
    """
    topology = surface.topology
    notes = list(surface.notes)
    n_thin = int(np.count_nonzero(_is_thin(points, topology.triangles)))
    if n_thin:
        notes.append(f"{n_thin} triangles have no area, or hardly any: bounded for the solve")
    # Copies of one vertex, at cuts, lie together because they were made so.
    n_touching = _count_repeated(points[topology.on_boundary & ~surface.is_cut])
    if n_touching:
        notes.append(
            f"{n_touching} boundary vertices lie exactly on another one: the surfaces are not "
            "joined there, merge vertices by distance to join them"
        )
    return tuple(notes)


def _is_thin(points: FloatArray, triangles: IntArray) -> BoolArray:
    """Whether each flat triangle has a metric that `metric_at` bounds, (m,)."""
    columns = np.ascontiguousarray(points.T)
    firsts = range(0, len(triangles), TRIANGLES_PER_CHUNK)

    def of_chunk(first: int) -> IndexArray:
        return first + _may_be_thin(columns, triangles[first : first + TRIANGLES_PER_CHUNK])

    suspects = np.concatenate([np.empty(0, dtype=np.intp), *ordered_map(of_chunk, firsts)])
    is_thin = np.zeros(len(triangles), dtype=bool)
    is_thin[suspects] = _is_thin_at_any_size(points, triangles[suspects])
    return is_thin


def _may_be_thin(columns: FloatArray, triangles: IntArray) -> IndexArray:
    """Find triangles that are nearly thin, or of a size whose squares overflow or underflow."""
    a, b, c = (np.ascontiguousarray(corner) for corner in triangles.T)
    with np.errstate(over="ignore", invalid="ignore"):
        u, v = ([x[end] - x[a] for x in columns] for end in (b, c))
        trace = sum(x * x for x in u) + sum(x * x for x in v)
        normal = [u[k - 2] * v[k - 1] - u[k - 1] * v[k - 2] for k in range(3)]
        # With a factor 2 for rounding; sums that are 0 or not finite decide nothing.
        clear = sum(x * x for x in normal) > (2 * THINNEST_ASPECT * trace) ** 2
    return np.flatnonzero(~clear)


def _is_thin_at_any_size(points: FloatArray, triangles: IntArray) -> BoolArray:
    origin = points[triangles[:, 0]]
    u, v = points[triangles[:, 1]] - origin, points[triangles[:, 2]] - origin
    # Squares of coordinates of any size stay in range if the largest is 1.
    size = np.maximum(np.abs(u).max(axis=1, initial=0), np.abs(v).max(axis=1, initial=0))
    size = np.where(size > 0, size, 1)[:, None]
    u, v = u / size, v / size
    doubled_area = np.linalg.norm(np.cross(u, v), axis=1)
    trace = dots(u, u) + dots(v, v)
    is_thin: BoolArray = doubled_area <= THINNEST_ASPECT * trace
    return is_thin


def _count_repeated(points: FloatArray) -> int:
    """Count the points beyond the first at each place."""
    return len(points) - len(np.unique(points, axis=0)) if len(points) else 0
