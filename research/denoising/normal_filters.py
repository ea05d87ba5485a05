"""Filters of face normals from the literature, and the update of the vertices that follows them.

Written from the papers' equations:

- Y. Zheng, H. Fu, O. K.-C. Au and C.-L. Tai, Bilateral normal filtering for mesh denoising, 2011
  (the local scheme, eqs. 2 to 4).
- W. Zhang, B. Deng, J. Zhang, S. Bouaziz and L. Liu, Guided mesh normal filtering, 2015.
- X. Sun, P. L. Rosin, R. R. Martin and F. C. Langbein, Fast and effective feature-preserving mesh
  denoising, 2007 (the update of the vertices, in both).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from tools.geometry.triangles import Faces, FloatArray, inner_edges, scaled_normals, unit

VERTEX_STEPS = 10
"""Updates of the vertices after the normals were filtered."""

RADIUS = 2.0
"""Of a face's neighbourhood in guided filtering, over the mean distance of adjacent centres."""

LEAST = 1e-9
"""Against a division by zero where all normals of a patch are equal."""


def bilateral_filter(
    vertices: FloatArray, faces: Faces, sweep: tuple[float, ...], sigma: float
) -> Iterator[FloatArray]:
    """Bilateral normal filtering, local scheme; the sweep counts filterings of the normals.

    At a difference `sigma` of normals, σ_s of the paper, weights fall to exp(-1/2).
    """
    centre, normal, area = _geometry(vertices, faces)
    first, second = _around(faces)
    spread = _centre_distance(centre, faces)
    weight = area[second] * _gauss(centre[first] - centre[second], spread)
    done = 0
    for value in sweep:
        for _ in range(int(value) - done):
            now = weight * _gauss(normal[first] - normal[second], sigma)
            normal = unit(csr_array((now, (first, second)), (len(faces),) * 2) @ normal)
        done = int(value)
        yield fit_vertices(vertices, faces, normal)


def guided_filter(
    vertices: FloatArray, faces: Faces, sweep: tuple[float, ...], sigma: float
) -> Iterator[FloatArray]:
    """Guided normal filtering; the sweep counts iterations, each with its update of the vertices.

    At a difference `sigma` of guiding normals, σ_r of the paper, weights fall to exp(-1/2).
    """
    centre, normal, area = _geometry(vertices, faces)
    spread = _centre_distance(centre, faces)
    first, second = cKDTree(centre).query_pairs(RADIUS * spread, output_type="ndarray").T
    itself = np.arange(len(faces))
    first, second = np.concatenate([[first, second], [second, first], [itself, itself]], axis=1)
    patches = _Patches(faces)
    done = 0
    for value in sweep:
        for _ in range(int(value) - done):
            centre, normal, area = _geometry(vertices, faces)
            guide = patches.guide(normal, area)
            weight = area[second] * _gauss(centre[first] - centre[second], spread)
            weight *= _gauss(guide[first] - guide[second], sigma)
            filtered = csr_array((weight, (first, second)), (len(faces),) * 2) @ normal
            vertices = fit_vertices(vertices, faces, unit(filtered))
        done = int(value)
        yield vertices


class _Patches:
    """Every face with all that share a vertex with it, as candidates for the guidance.

    A face is guided by the mean normal of that patch, of all that it is part of, which is the most
    consistent: whose normals differ little and whose largest difference across an edge is shared by
    many edges, not by one crease.
    """

    def __init__(self, faces: Faces) -> None:
        patch, member = _around(faces)
        itself = np.arange(len(faces))
        patch, member = np.concatenate([[patch, member], [itself, itself]], axis=1)
        order = np.lexsort((member, patch))
        self.patch, self.member = patch[order], member[order]
        self.start = np.searchsorted(self.patch, itself)
        self.sizes = np.bincount(self.patch)
        inside = csr_array((np.ones(len(patch)), (patch, member)), (len(faces),) * 2)
        self.inside = inside
        self.edges = inner_edges(faces)[1]
        # An edge belongs to the patches that have both of its faces.
        n_edges = len(self.edges)
        ends = csr_array(
            (np.ones(2 * n_edges), (self.edges.ravel(), np.repeat(np.arange(n_edges), 2))),
            (len(faces), n_edges),
        )
        both = (inside @ ends).tocoo()
        kept = both.data == 2
        order = np.argsort(both.row[kept], kind="stable")
        self.edge_patch, self.patch_edge = both.row[kept][order], both.col[kept][order]

    def guide(self, normal: FloatArray, area: FloatArray) -> FloatArray:
        """Return the guiding normals (m, 3)."""
        jump = np.linalg.norm(normal[self.edges[:, 0]] - normal[self.edges[:, 1]], axis=1)
        jumps = jump[self.patch_edge]
        total = np.bincount(self.edge_patch, jumps, len(normal))
        largest = np.zeros(len(normal))
        np.maximum.at(largest, self.edge_patch, jumps)
        inconsistency = self._spread(normal) * largest / (LEAST + total)
        # The least of the patches with this face in them: they are those of the faces around it.
        least = np.minimum.reduceat(inconsistency[self.member], self.start)
        is_least = inconsistency[self.member] == least[self.patch]
        rows, first = np.unique(self.patch[is_least], return_index=True)
        best = np.empty(len(normal), dtype=int)
        best[rows] = self.member[is_least][first]
        return unit(self.inside @ (area[:, None] * normal))[best]

    def _spread(self, normal: FloatArray) -> FloatArray:
        """Return the largest difference between two normals of every patch."""
        largest = np.zeros(len(normal))
        for size in np.unique(self.sizes):
            patches = np.flatnonzero(self.sizes == size)
            # Blocks of some megabytes.
            for some in np.array_split(patches, 1 + len(patches) * size**2 // 2_000_000):
                here = normal[self.member[self.start[some][:, None] + np.arange(size)]]
                cosine = (here @ here.transpose(0, 2, 1)).min(axis=(1, 2))
                largest[some] = np.sqrt(np.maximum(2 - 2 * cosine, 0))
        return largest


def fit_vertices(vertices: FloatArray, faces: Faces, normal: FloatArray) -> FloatArray:
    """Move vertices (n, 3) until the faces (m, 3) have the given normals, as Sun et al. do."""
    count = np.maximum(np.bincount(faces.ravel(), minlength=len(vertices)), 1)
    rows, columns = faces.ravel(), np.repeat(np.arange(len(faces)), 3)
    gather = csr_array((1 / count[rows], (rows, columns)), (len(vertices), len(faces)))
    # Σ n nᵀ (c − v) over the faces around a vertex, n nᵀ summed once for all steps.
    outer = (normal[:, :, None] * normal[:, None, :]).reshape(-1, 9)
    own = (gather @ outer).reshape(-1, 3, 3)
    for _ in range(VERTEX_STEPS):
        centre = vertices[faces].mean(axis=1)
        height = np.einsum("fd,fd->f", normal, centre)
        vertices = (
            vertices + gather @ (height[:, None] * normal) - np.einsum("nde,ne->nd", own, vertices)
        )
    return vertices


def _geometry(vertices: FloatArray, faces: Faces) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return centres (m, 3), unit normals (m, 3) and areas (m,)."""
    scaled = scaled_normals(vertices, faces)
    return vertices[faces].mean(axis=1), unit(scaled), 0.5 * np.linalg.norm(scaled, axis=1)


def _around(faces: Faces) -> tuple[np.ndarray, np.ndarray]:
    """Return pairs of different faces that share a vertex, both ways."""
    rows, columns = np.repeat(np.arange(len(faces)), 3), faces.ravel()
    shares = csr_array((np.ones(len(rows)), (rows, columns)), (len(faces), faces.max() + 1))
    pairs = (shares @ shares.T).tocoo()
    different = pairs.row != pairs.col
    return pairs.row[different], pairs.col[different]


def _centre_distance(centre: FloatArray, faces: Faces) -> float:
    """Return the mean distance of the centres of faces that share an edge."""
    beside = inner_edges(faces)[1]
    return float(np.linalg.norm(centre[beside[:, 0]] - centre[beside[:, 1]], axis=1).mean())


def _gauss(difference: FloatArray, sigma: float) -> FloatArray:
    return np.exp(-np.einsum("kd,kd->k", difference, difference) / (2 * sigma**2))
