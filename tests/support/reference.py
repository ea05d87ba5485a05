"""Mass and stiffness matrices of the Loop basis by brute force: no patches, no quadrature rules.

The whole mesh is subdivided k times, every fine vertex is moved to its limit position, and linear
elements are assembled on that fine mesh. Because subdivision is linear, one sparse matrix P maps
the control values to the limit values at the fine vertices, so P^T A P pulls the linear element
matrix A back to the Loop basis. Its error falls like a sum of known powers in k, which Richardson's
extrapolation removes.

Nothing is taken from ``adaptive_fairing``: subdivision rules from Loop's thesis (the smooth part)
and Hoppe et al., "Piecewise smooth surface reconstruction", 1994 (the boundary curve).
"""

from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

LEVELS = (4, 5, 6)

# Error ratios from one level to the next that the extrapolation removes: a linear element of half
# the size has a quarter of the error. Next to an extraordinary vertex of valence n the mesh shrinks
# by lambda = 3/8 + cos(2 pi / n) / 4 only and the error by lambda^2, which is close enough to 1/4
# that the remainder is small: below 6e-6 of the largest entry for valences up to 10, 1e-5 for 44.
RATIOS = (1 / 4, 1 / 16)


class BruteForceSpace:
    """Reference for ``LoopSpace``: matrices and measures on the limit surface of a small mesh.

    Parameters
    ----------
    faces
        Triangles, (n_triangles, 3); every vertex is used by one, boundary curves are allowed.
    levels
        Numbers of subdivision steps; integrals need three consecutive ones.
    """

    def __init__(self, faces: np.ndarray, levels: tuple[int, ...] = LEVELS) -> None:
        self.faces = np.asarray(faces, dtype=np.int64)
        self.n_vertices = int(self.faces.max()) + 1
        self.levels = levels

    @cached_property
    def refinements(self) -> list[tuple[sparse.csr_array, np.ndarray]]:
        """Per level: P (fine vertices x control vertices, limit values) and the fine faces."""
        refinements = []
        values = sparse.csr_array(sparse.eye(self.n_vertices))
        faces = self.faces
        for level in range(max(self.levels) + 1):
            if level in self.levels:
                limit = limit_matrix(faces, values.shape[0])
                refinements.append((sparse.csr_array(limit @ values), faces))
            if level < max(self.levels):
                subdivision, faces = subdivision_matrix(faces, values.shape[0])
                values = sparse.csr_array(subdivision @ values)
        return refinements

    def mass_matrix(self, positions: np.ndarray, timestep: np.ndarray | None = None) -> np.ndarray:
        """Return the integrals of T(x)^-1 phi_i phi_j (T = 1 by default), dense."""

        def pulled_back(refinement: sparse.csr_array, faces: np.ndarray) -> np.ndarray:
            inverse = None if timestep is None else 1 / (refinement @ timestep)
            fine = linear_mass_matrix(refinement @ positions, faces, inverse)
            return (refinement.T @ fine @ refinement).toarray()

        return self._extrapolated(pulled_back)

    def stiffness_matrix(
        self, positions: np.ndarray, diffusivity: np.ndarray | None = None
    ) -> np.ndarray:
        """Return the integrals of c(x) grad phi_i . grad phi_j (c = 1 by default), dense."""

        def pulled_back(refinement: sparse.csr_array, faces: np.ndarray) -> np.ndarray:
            factor = None if diffusivity is None else refinement @ diffusivity
            fine = linear_stiffness_matrix(refinement @ positions, faces, factor)
            return (refinement.T @ fine @ refinement).toarray()

        return self._extrapolated(pulled_back)

    def area(self, positions: np.ndarray) -> float:
        """Return the area of the limit surface."""
        return float(
            self._extrapolated(lambda p, faces: 0.5 * _doubled_areas(p @ positions, faces).sum())
        )

    def volume(self, positions: np.ndarray) -> float:
        """Return the volume inside the closed limit surface."""

        def of_fine_mesh(refinement: sparse.csr_array, faces: np.ndarray) -> float:
            a, b, c = np.moveaxis((refinement @ positions)[faces], 1, 0)
            return np.einsum("fd,fd->", a, np.cross(b, c)) / 6

        return float(self._extrapolated(of_fine_mesh))

    def _extrapolated(self, integral):
        """Evaluate ``integral(P, faces)`` on every level and remove the known error ratios."""
        values = [integral(*refinement) for refinement in self.refinements]
        for ratio in RATIOS:
            values = [(fine - ratio * coarse) / (1 - ratio) for coarse, fine in pairwise(values)]
        return values[0]


def subdivision_matrix(faces: np.ndarray, n_vertices: int) -> tuple[sparse.csr_array, np.ndarray]:
    """Return one step of Loop subdivision: the matrix (old to new vertices) and the new faces.

    New vertices are the old ones in order, then one per edge. Inside: 3/8 3/8 1/8 1/8 on an edge,
    (1 - n w, w ...) on a vertex with n neighbours, n w = 5/8 - (3/8 + cos(2 pi / n) / 4)^2. On the
    boundary: the midpoint, and 1/8 6/8 1/8 along the curve.
    """
    edges, edge_of, edge_counts = _edges(faces)
    n_edges = len(edges)
    on_boundary = edge_counts == 1

    opposite = faces[:, [2, 0, 1]].T.ravel()  # of the sides (0,1), (1,2), (2,0)
    side_is_inner = ~on_boundary[edge_of]
    edge_rows = np.concatenate([np.repeat(np.arange(n_edges), 2), edge_of[side_is_inner]])
    edge_columns = np.concatenate([edges.ravel(), opposite[side_is_inner]])
    edge_weights = np.concatenate(
        [np.repeat(np.where(on_boundary, 1 / 2, 3 / 8), 2), np.full(side_is_inner.sum(), 1 / 8)]
    )
    edge_matrix = sparse.csr_array(
        (edge_weights, (edge_rows, edge_columns)), shape=(n_edges, n_vertices)
    )

    valence = np.bincount(edges.ravel(), minlength=n_vertices)
    total = 5 / 8 - (3 / 8 + np.cos(2 * np.pi / valence) / 4) ** 2
    vertex_matrix = _vertex_mask(edges, on_boundary, n_vertices, total / valence, 1 / 8)

    ab, bc, ca = n_vertices + edge_of.reshape(3, -1)
    a, b, c = faces.T
    children = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    fine_faces = np.concatenate([np.stack(child, axis=1) for child in children])
    return sparse.csr_array(sparse.vstack([vertex_matrix, edge_matrix])), fine_faces


def limit_matrix(faces: np.ndarray, n_vertices: int) -> sparse.csr_array:
    """Return the map from control values to limit values at the vertices.

    Inside: (1 - n l, l ...) with l = 1 / (n + 3 / (8 w)); on the boundary 1/6 2/3 1/6, the limit of
    the cubic B-spline.
    """
    edges, _, edge_counts = _edges(faces)
    valence = np.bincount(edges.ravel(), minlength=n_vertices)
    total = 5 / 8 - (3 / 8 + np.cos(2 * np.pi / valence) / 4) ** 2
    weight = 1 / (valence + 3 * valence / (8 * total))
    return _vertex_mask(edges, edge_counts == 1, n_vertices, weight, 1 / 6)


def fine_barycentric(n_triangles: int, levels: int) -> np.ndarray:
    """Return where the corners of fine face f lie in the coarse face f mod n_triangles.

    Barycentric coordinates, (4**levels * n_triangles, 3 corners, 3), in the order of the faces that
    ``subdivision_matrix`` makes.
    """
    corners = np.tile(np.eye(3), (n_triangles, 1, 1))
    for _ in range(levels):
        a, b, c = np.moveaxis(corners, 1, 0)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        children = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        corners = np.concatenate([np.stack(child, axis=1) for child in children])
    return corners


def interpolating_control_points(positions: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the control points whose limit surface passes through ``positions``."""
    return splu(limit_matrix(faces, len(positions)).tocsc()).solve(positions)


def linear_mass_matrix(
    positions: np.ndarray, faces: np.ndarray, factor: np.ndarray | None = None
) -> sparse.csr_array:
    """Return the mass matrix of linear elements; ``factor`` is linear, given at the vertices."""
    area = 0.5 * _doubled_areas(positions, faces)
    factor = np.ones(len(positions)) if factor is None else factor
    # The integral of x_a x_b x_c over a triangle is 2 A a! b! c! / (a + b + c + 2)! per monomial.
    exact = np.empty((3, 3, 3))
    for i, j, k in np.ndindex(3, 3, 3):
        powers = np.bincount([i, j, k], minlength=3)
        exact[i, j, k] = 2 * np.prod(np.array([1, 1, 2, 6])[powers]) / 120
    return _assembled(np.einsum("f,fc,abc->fab", area, factor[faces], exact), faces, len(positions))


def linear_stiffness_matrix(
    positions: np.ndarray, faces: np.ndarray, factor: np.ndarray | None = None
) -> sparse.csr_array:
    """Return the stiffness matrix of linear elements; ``factor`` is linear, given at vertices."""
    corners = positions[faces]
    opposite = np.roll(corners, -1, axis=1) - np.roll(corners, 1, axis=1)  # the side facing corner
    local = np.einsum("fad,fbd->fab", opposite, opposite)
    local /= 2 * _doubled_areas(positions, faces)[:, None, None]
    if factor is not None:
        local *= factor[faces].mean(axis=1)[:, None, None]
    return _assembled(local, faces, len(positions))


def _vertex_mask(
    edges: np.ndarray,
    on_boundary: np.ndarray,
    n_vertices: int,
    inner_weight: np.ndarray,
    boundary_weight: float,
) -> sparse.csr_array:
    """Return the matrix that weighs neighbours as given and keeps the rest for the vertex.

    A boundary vertex sees its two neighbours along the boundary only.
    """
    is_boundary_vertex = np.zeros(n_vertices, dtype=bool)
    is_boundary_vertex[edges[on_boundary]] = True
    rows = np.concatenate([edges[:, 0], edges[:, 1]])
    columns = np.concatenate([edges[:, 1], edges[:, 0]])
    along_boundary = np.tile(on_boundary, 2)
    weights = np.where(
        is_boundary_vertex[rows], np.where(along_boundary, boundary_weight, 0.0), inner_weight[rows]
    )
    neighbours = sparse.csr_array((weights, (rows, columns)), shape=(n_vertices, n_vertices))
    neighbours.eliminate_zeros()
    return neighbours + sparse.diags_array(1 - np.asarray(neighbours.sum(axis=1)).ravel())


def _edges(faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the edges (n, 2), the edge of each side (0,1), (1,2), (2,0), and faces per edge."""
    sides = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    lower, upper = sides.min(axis=1), sides.max(axis=1)
    n_vertices = int(faces.max()) + 1
    keys, edge_of, counts = np.unique(
        lower * n_vertices + upper, return_inverse=True, return_counts=True
    )
    return np.stack(np.divmod(keys, n_vertices), axis=1), edge_of, counts


def _doubled_areas(positions: np.ndarray, faces: np.ndarray) -> np.ndarray:
    a, b, c = np.moveaxis(positions[faces], 1, 0)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1)


def _assembled(local: np.ndarray, faces: np.ndarray, n_vertices: int) -> sparse.csr_array:
    """Sum local matrices (f, a, b) into a sparse matrix."""
    rows = np.repeat(faces, 3, axis=1).ravel()
    columns = np.tile(faces, (1, 3)).ravel()
    return sparse.csr_array((local.ravel(), (rows, columns)), shape=(n_vertices, n_vertices))
