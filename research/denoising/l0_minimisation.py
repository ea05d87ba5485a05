"""L0 minimisation of the area-based edge operator: as few bent edges as possible.

Written from the equations of L. He and S. Schaefer, Mesh denoising via L0 minimization, 2013.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.sparse import csr_array, eye_array
from scipy.sparse.linalg import splu

from tools.geometry.triangles import Faces, FloatArray, inner_edges, normals

FIRST, LAST, GROWTH = 1e-3, 1e3, 2**0.5
"""Weight β of the edge operator: where it starts, where it ends, how it grows."""

REGULARISATION, DECAY = 0.1, 0.5
"""Weight α of the regularisation over the mean dihedral angle, and how it falls at every step."""

CORNERS = np.array([1.0, -1.0, 1.0, -1.0])
"""The regularisation: opposite corners of a pair of triangles stay in balance."""


def l0_minimisation(
    vertices: FloatArray, faces: Faces, sweep: tuple[float, ...]
) -> Iterator[FloatArray]:
    """Minimise |p − p*|² + λ |D p|₀ with p* the noisy mesh and D p a vector per inner edge.

    Parameters
    ----------
    vertices, faces
        (n, 3) noisy positions and (m, 3) triangles.
    sweep
        λ over the squared mean edge times the mean dihedral angle in radians.
    """
    diamonds, beside = inner_edges(faces)
    normal = normals(vertices, faces)
    cosine = np.einsum("kd,kd->k", normal[beside[:, 0]], normal[beside[:, 1]])
    angle = float(np.arccos(np.clip(cosine, -1, 1)).mean())
    sides = vertices[diamonds[:, 0]] - vertices[diamonds[:, 2]]
    edge = float(np.linalg.norm(sides, axis=1).mean())
    balance = _operator(np.broadcast_to(CORNERS, diamonds.shape), diamonds, len(vertices))
    for value in sweep:
        cost = value * edge**2 * angle
        yield _minimised(vertices, diamonds, balance, cost, REGULARISATION * angle)


def _minimised(
    noisy: FloatArray, diamonds: np.ndarray, balance: csr_array, cost: float, alpha: float
) -> FloatArray:
    """Alternate between the sparse differences δ and the positions p, for growing β."""
    positions, beta = noisy, FIRST
    identity, balance = eye_array(len(noisy)), (balance.T @ balance).tocsr()
    while beta < LAST:
        operator = _operator(edge_weights(positions[diamonds]), diamonds, len(noisy))
        bend = operator @ positions
        bend[np.einsum("kd,kd->k", bend, bend) <= cost / beta] = 0.0
        matrix = identity + alpha * balance + beta * (operator.T @ operator)
        solver = splu(
            matrix.tocsc(), "MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
        positions = solver.solve(noisy + beta * (operator.T @ bend))
        beta, alpha = beta * GROWTH, alpha * DECAY
    return positions


def edge_weights(corner: FloatArray) -> FloatArray:
    """Return the weights (k, 4) of the area-based edge operator.

    `corner` (k, 4, 3) are the corners p1 to p4 of two triangles p1 p2 p3 and p1 p3 p4. The weights
    sum to zero, and weighted sums of the corners of flat pairs are zero, whatever their shape.
    """
    p1, p2, p3, p4 = corner.transpose(1, 0, 2)
    along = p3 - p1
    area_2 = np.linalg.norm(np.cross(p2 - p1, along), axis=1)
    area_4 = np.linalg.norm(np.cross(along, p4 - p1), axis=1)
    both = np.maximum(area_2 + area_4, np.finfo(float).tiny)
    w2, w4 = area_4 / both, area_2 / both
    square = np.maximum(np.einsum("kd,kd->k", along, along), np.finfo(float).tiny)

    # Where on the edge the feet of the heights of p2 and p4 lie: 0 at p1, 1 at p3.
    foot_2, foot_4 = (np.einsum("kd,kd->k", p - p1, along) / square for p in (p2, p4))
    w3 = -(w2 * foot_2 + w4 * foot_4)
    return np.stack([-(w2 + w3 + w4), w2, w3, w4], axis=1)


def _operator(weights: FloatArray, diamonds: np.ndarray, n_vertices: int) -> csr_array:
    rows = np.repeat(np.arange(len(diamonds)), 4)
    return csr_array((weights.ravel(), (rows, diamonds.ravel())), (len(diamonds), n_vertices))
