"""Linear elements in the paper's scheme: the finite elements that the Loop basis is to beat."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import cg

from adaptive_fairing.core import FairingError, TriangleTopology, mesh_density
from adaptive_fairing.core.mesh.solver_mesh import FRAME_SIZE
from tools.geometry.triangles import Faces, FloatArray, triangle_areas

MIDPOINTS = np.array([[1, 1, 0], [0, 1, 1], [1, 0, 1]]) / 2
"""Barycentric points of the quadrature rule at the edges' middles, exact for quadratics."""

TOLERANCE = 1e-6


def mass_matrix(
    vertices: FloatArray, triangles: Faces, timestep: FloatArray | None = None
) -> sparse.csr_array:
    """Assemble ∫ t(x)⁻¹ λi λj over the triangles, with t(x) = Σ t_k λ_k (1 without `timestep`).

    Exact without `timestep`; otherwise 1/t is taken at the middles of the edges.
    """
    weight = triangle_areas(vertices, triangles)[:, None] / len(MIDPOINTS)
    if timestep is not None:
        weight = weight / (timestep[triangles] @ MIDPOINTS.T)
    weight = np.broadcast_to(weight, triangles.shape)
    local = np.einsum("fq,qa,qb->fab", weight, MIDPOINTS, MIDPOINTS)
    return _assembled(local, triangles, len(vertices))


def stiffness_matrix(vertices: FloatArray, triangles: Faces) -> sparse.csr_array:
    """Assemble ∫ ∇λi · ∇λj over the triangles: the cotangent matrix."""
    corners = vertices[triangles]
    facing = np.roll(corners, -1, axis=1) - np.roll(corners, 1, axis=1)
    area = triangle_areas(vertices, triangles)
    local = np.einsum("fad,fbd->fab", facing, facing) / (4 * area)[:, None, None]
    return _assembled(local, triangles, len(vertices))


def fair_linear(
    vertices: FloatArray, triangles: Faces, tau: float, steps: int, density_passes: int = 3
) -> FloatArray:
    """Run the adaptive timestep scheme (3.3) with linear elements and edge density.

    Parameters
    ----------
    vertices, triangles
        A closed mesh, (n, 3) and (m, 3).
    tau, steps, density_passes
        As in `FairingSettings`.

    Returns
    -------
    (n, 3)
        Positions after the last step.

    Raises
    ------
    FairingError
        A linear system that was not solved.
    """
    topology = TriangleTopology(triangles, len(vertices))
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    centre, scale = (low + high) / 2, FRAME_SIZE / float((high - low).max())
    current = (vertices - centre) * scale
    for _ in range(steps):
        timestep = tau * mesh_density(topology, current, "edge_length", density_passes)
        mass = mass_matrix(current, triangles, timestep)
        matrix = mass + stiffness_matrix(current, triangles)
        current = _solved(matrix, mass @ current, current)
    return current / scale + centre


def _solved(matrix: sparse.csr_array, right_side: FloatArray, start: FloatArray) -> FloatArray:
    jacobi = sparse.diags_array(1 / matrix.diagonal())
    columns = []
    for load, first in zip(right_side.T, start.T, strict=True):
        column, status = cg(matrix, load, x0=first, rtol=TOLERANCE, M=jacobi)
        if status != 0:
            raise FairingError(f"linear elements: no convergence in {status} iterations")
        columns.append(column)
    return np.stack(columns, axis=1)


def _assembled(local: FloatArray, triangles: Faces, n_vertices: int) -> sparse.csr_array:
    """Sum local matrices (f, a, b) into a sparse matrix."""
    rows = np.repeat(triangles, 3, axis=1).ravel()
    columns = np.tile(triangles, (1, 3)).ravel()
    return sparse.csr_array((local.ravel(), (rows, columns)), shape=(n_vertices, n_vertices))
