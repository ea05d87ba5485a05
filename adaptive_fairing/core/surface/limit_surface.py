"""C¹ limit surface of a control mesh: points, normals, curvature and finer meshes."""

from __future__ import annotations

from numbers import Integral
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from ..errors import InputError
from ..loop.patches import PatchSet
from ..mesh.input_checks import checked_vertices
from ..mesh.normals import unit_vectors
from ..mesh.topology import TriangleTopology, require_topology
from ..runtime.arrays import FloatArray, IntArray
from ..runtime.lazy import cached_property
from .curvature import curvature, refined_curvature
from .edge_points import edge_control_points, edge_limits, unit_cross
from .masks import limit_matrix, refinement_matrix, tangent_matrices, vertex_matrix
from .patch_evaluation import PatchEvaluation, SurfacePoints, checked_places
from .refined_topology import CORNER, RefinedTopology, unrefined_topology
from .sectors import Sectors, sector_normals, sectors_of


class Refined(NamedTuple):
    """A mesh on the limit surface.

    Attributes
    ----------
    vertices : (n, 3) float
    triangles : (m, 3) int32
    normals : (n, 3) float
        Unit normals of the limit surface.
    """

    vertices: FloatArray
    triangles: IntArray
    normals: FloatArray


class RefinementLevels:
    """Meshes and matrices of each level of refinement, made once, for any positions.

    Parameters
    ----------
    topology : TriangleTopology
    creases : (k, 2) int
        Vertex pairs of the sharp edges.
    corners : (j,) int
        Vertices that stay where they are.

    Raises
    ------
    InputError
        A crease is not an edge, or a corner is not a vertex.
    """

    def __init__(
        self, topology: TriangleTopology, creases: ArrayLike = (), corners: ArrayLike = ()
    ) -> None:
        is_corner = np.zeros(topology.n_vertices, dtype=bool)
        numbers = np.asarray(corners, dtype=np.int64)
        pairs = np.asarray(creases, dtype=np.int64).reshape(-1, 2)
        for name, indices in (("corners", numbers), ("creases", pairs)):
            if indices.size and not 0 <= indices.min() <= indices.max() < topology.n_vertices:
                raise InputError(f"{name} use vertices outside 0 … {topology.n_vertices - 1}")
        is_corner[numbers] = True
        self._topology = topology
        self._meshes = [unrefined_topology(topology, pairs, is_corner)]
        self._steps: list[sparse.csr_array] = []
        self._vertex_steps: list[sparse.csr_array] = []
        self._sectors: dict[int, Sectors] = {}

    @cached_property
    def limit_matrix(self) -> sparse.csr_array:
        """Map from the control points of level 0 to the limit positions of its vertices."""
        return limit_matrix(self.mesh(0))

    @cached_property
    def _tangents(self) -> tuple[sparse.csr_array, sparse.csr_array]:
        return tangent_matrices(self.mesh(0))

    def mesh(self, level: int) -> RefinedTopology:
        """Make the connectivity after `level` steps, once.

        Raises
        ------
        InputError
            The level is not a whole number of at least 0.
        """
        if not isinstance(level, Integral) or isinstance(level, bool) or level < 0:
            raise InputError(f"levels must be a whole number from 0 on, not {level!r}")
        while len(self._meshes) <= level:
            self._meshes.append(self._meshes[-1].finer)
        return self._meshes[level]

    def refinement_matrix(self, level: int) -> sparse.csr_array:
        """Map from the control points of level `level - 1` to those of `level` ≥ 1."""
        while len(self._steps) < level:
            self._steps.append(refinement_matrix(self.mesh(len(self._steps))))
        return self._steps[level - 1]

    def _vertex_matrix(self, level: int) -> sparse.csr_array:
        """Rows of the refinement matrix from `level` on for the vertices that are kept."""
        while len(self._vertex_steps) <= level:
            self._vertex_steps.append(vertex_matrix(self.mesh(len(self._vertex_steps))))
        return self._vertex_steps[level]

    @cached_property
    def patch_evaluation(self) -> PatchEvaluation:
        """Patches for points at any place of the surface.

        Raises
        ------
        InputError
            There are creases or corners; the patches have none.
        """
        if self.has_creases or (self.mesh(0).kind == CORNER).any():
            raise InputError(
                "single points cannot be evaluated on a surface with creases or corners: refine it"
            )
        return PatchEvaluation(PatchSet(self._topology))

    @property
    def has_creases(self) -> bool:
        """Whether there are sharp edges inside, so that normals differ at one vertex."""
        mesh = self.mesh(0)
        return bool((mesh.is_sharp & (mesh.right >= 0)).any())

    def control_points(self, positions: FloatArray, level: int) -> list[FloatArray]:
        """Control points of all levels up to `level`, each (n, 3), from those of level 0."""
        self.mesh(level)
        control = [positions]
        for step in range(level):
            mesh = self.mesh(step)
            n = mesh.n_vertices
            finer = np.empty((n + len(mesh.edges), 3))
            finer[:n] = self._vertex_matrix(step) @ control[-1]
            edge_control_points(mesh, control[-1], finer[n:])
            control.append(finer)
        return control

    def limit_points(self, control: list[FloatArray]) -> FloatArray:
        """Points of the limit surface at the vertices of the last level, (n, 3).

        A vertex keeps its point on all finer levels, so each is computed on its first level.
        """
        return self._limits(control, has_normals=False)[0]

    def _limits(
        self, control: list[FloatArray], has_normals: bool = True
    ) -> tuple[FloatArray, FloatArray]:
        """Limit points at the vertices of the last level, and on request normals inside."""
        n = [len(points) for points in control]
        points = np.empty((n[-1], 3))
        normals = np.empty((n[-1] if has_normals else 0, 3))
        points[: n[0]] = self.limit_matrix @ control[0]
        if has_normals:
            first, second = self._tangents
            normals[: n[0]] = unit_cross(first @ control[0], second @ control[0])
        for level, finer in enumerate(control[1:]):
            new = slice(n[level], n[level + 1])
            edge_limits(self.mesh(level), finer, points[new], normals[new] if has_normals else None)
        return points, normals

    def sectors(self, level: int) -> Sectors:
        """Sides of creases, the boundary and corners."""
        if level not in self._sectors:
            self._sectors[level] = sectors_of(self.mesh(level))
        return self._sectors[level]

    def points_and_normals(
        self, control: list[FloatArray]
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Compute points and unit normals of the limit surface at the last level's vertices.

        Returns
        -------
        points : (n, 3)
            As `limit_points`.
        normals : (n, 3)
            On creases and at corners the mean of the sides; 0 at loose vertices.
        of_sectors : (s, 3)
            Normals of each side of creases, the boundary and corners.
        """
        points, normals = self._limits(control)
        level = len(control) - 1
        mesh, sectors = self.mesh(level), self.sectors(level)
        of_sectors = sector_normals(mesh, sectors, control[-1])
        at = np.unique(sectors.vertex)
        sums = [np.bincount(sectors.vertex, x, mesh.n_vertices)[at] for x in of_sectors.T]
        normals[at] = unit_vectors(np.stack(sums, axis=1))
        return points, normals, of_sectors

    def corner_normals(self, normals: FloatArray, of_sectors: FloatArray, level: int) -> FloatArray:
        """Spread normals of vertices and sectors over the corners of triangles, (m, 3, 3)."""
        corners, sector = self.sectors(level).corners()
        result = normals[self.mesh(level).triangles]
        result.reshape(-1, 3)[corners] = of_sectors[sector]
        return result


class LimitSurface:
    """Loop's limit surface of a control mesh, with creases.

    Parameters
    ----------
    topology : TriangleTopology
    positions : (n_vertices, 3) float
        Control points.
    creases : (k, 2) int
        Vertex pairs of edges that stay sharp.  Boundary edges count as sharp.  A vertex with two
        sharp edges lies on a smooth curve, a vertex with more is a corner, and at the end of a
        single sharp edge the surface is smooth.
    corners : (j,) int
        Further vertices that stay where they are.

    Raises
    ------
    InputError
        The topology is not a `TriangleTopology`, positions have another shape or are not finite, or
        a crease is not an edge.

    Examples
    --------
    >>> from adaptive_fairing.core import LimitSurface, TriangleTopology
    >>> square = TriangleTopology([(0, 1, 2), (0, 2, 3)], n_vertices=4)
    >>> places = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    >>> surface = LimitSurface(square, places, corners=[0, 1, 2, 3])
    >>> positions, triangles, normals = surface.refined(1)
    >>> len(triangles), positions[:4].tolist() == [list(map(float, place)) for place in places]
    (8, True)

    Source: see `masks`.
    """

    def __init__(
        self,
        topology: TriangleTopology,
        positions: ArrayLike,
        creases: ArrayLike = (),
        corners: ArrayLike = (),
    ) -> None:
        require_topology(topology)
        self.levels = RefinementLevels(topology, creases, corners)
        self.positions = _control_points(positions, topology.n_vertices)

    @classmethod
    def from_levels(cls, levels: RefinementLevels, positions: ArrayLike) -> LimitSurface:
        """Make a surface that shares these refinement levels with others."""
        result = object.__new__(cls)
        result.levels = levels
        result.positions = _control_points(positions, levels.mesh(0).n_vertices)
        return result

    def moved(self, positions: ArrayLike) -> LimitSurface:
        """Make the surface with other positions; it shares all matrices with this one."""
        return LimitSurface.from_levels(self.levels, positions)

    def refinement_matrix(self, level: int) -> sparse.csr_array:
        """Map from the control points of level `level - 1` to those of `level` ≥ 1."""
        return self.levels.refinement_matrix(level)

    @cached_property
    def points(self) -> FloatArray:
        """Points of the limit surface at the vertices, (n, 3); loose vertices stay."""
        return self.levels.limit_points([self.positions])

    @cached_property
    def normals(self) -> FloatArray:
        """Vertex normals of length 1, (n, 3); see `RefinementLevels.points_and_normals`."""
        return self.levels.points_and_normals([self.positions])[1]

    def evaluate(self, triangles: ArrayLike, barycentric: ArrayLike) -> SurfacePoints:
        """Evaluate any points of the surface, exact in irregular patches as well.

        Parameters
        ----------
        triangles : (k,) int
            Triangle of the control mesh that each point belongs to.
        barycentric : (k, 3) float
            Barycentric coordinates in that triangle, at least 0, with the sum 1.

        Returns
        -------
        SurfacePoints
            `points` and unit `normals`, (k, 3) each.

        Raises
        ------
        InputError
            Arrays have the wrong shape or type, a triangle does not exist, a point lies outside its
            triangle, or the surface has creases or corners.

        Source: J. Stam, *Evaluation of Loop Subdivision Surfaces*, 1998, by subdividing towards
        the point instead of eigenvectors.
        """
        evaluation = self.levels.patch_evaluation
        mesh = self.levels.mesh(0)
        numbers, places = checked_places(triangles, barycentric, len(mesh.triangles))
        result = SurfacePoints(np.empty((len(numbers), 3)), np.empty((len(numbers), 3)))
        at_corner = places.max(axis=1, initial=0) == 1
        corner = mesh.triangles[numbers[at_corner], places[at_corner].argmax(axis=1)]
        inside = ~at_corner
        found = evaluation.evaluate(self.positions, numbers[inside], places[inside])
        result.points[inside], result.normals[inside] = found
        if len(corner):
            result.points[at_corner], result.normals[at_corner] = (
                self.points[corner],
                self.normals[corner],
            )
        return result

    def refined(self, levels: int) -> Refined:
        """Cut every triangle into 4 ** levels triangles, with all vertices on the limit surface.

        The vertices of the control mesh come first.  Triangles 4 f … 4 f + 3 of a level come from
        triangle f of the level before, see `refined_topology`.
        """
        control = self.levels.control_points(self.positions, levels)
        points, normals, _ = self.levels.points_and_normals(control)
        return Refined(points, self.levels.mesh(levels).triangles, normals)

    def corner_normals(self, levels: int) -> FloatArray:
        """Compute unit normals at the refined triangles' corners, (m, 3, 3), apart at creases."""
        control = self.levels.control_points(self.positions, levels)
        _, normals, of_sectors = self.levels.points_and_normals(control)
        return self.levels.corner_normals(normals, of_sectors, levels)

    @property
    def mean_curvature(self) -> FloatArray:
        """Mean curvature at the vertices, (n,), in 1 / length; see `curvature.curvature`."""
        return self._curvature[0]

    @property
    def gaussian_curvature(self) -> FloatArray:
        """Gaussian curvature at the vertices, (n,), in 1 / length²; see `curvature.curvature`."""
        return self._curvature[1]

    @cached_property
    def _curvature(self) -> FloatArray:
        return curvature(self.levels.mesh(0), *self.levels.control_points(self.positions, 1))

    def refined_curvature(self, levels: int) -> FloatArray:
        """Mean and Gaussian curvature at the vertices of `refined(levels)`, (2, n)."""
        if levels == 0:
            return self._curvature
        control = self.levels.control_points(self.positions, levels)
        return refined_curvature(self.levels.mesh(levels), control[-1])


def _control_points(positions: ArrayLike, n_vertices: int) -> FloatArray:
    points = checked_vertices(positions)
    if len(points) != n_vertices:
        raise InputError(f"{len(points)} positions for {n_vertices} vertices")
    return points
