"""Loop's rules on a mesh with creases: refinement, limit positions, tangents, as matrices.

A sharp edge is treated as a boundary of both sides: its curve is the cubic B-spline of the sharp
edges alone, and what lies on one side of it does not reach the other.  A dart, where a crease ends
inside the surface, follows the smooth vertex rule.

Sources: C. Loop 1987; kinds of vertices from H. Hoppe et al., Piecewise smooth surface
reconstruction, 1994.  Two of Hoppe's edge rules are not used: 5/8, 3/8 beside irregular crease
vertices makes the curve depend on the valences of both sides, and the smooth rule beside a dart
carries the sides across the crease.  The solver's boundary has neither.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy import sparse

from ..mesh.loop_masks import limit_weight, loop_alpha
from ..runtime.arrays import FloatArray, IndexArray
from .refined_topology import CORNER, CREASE, DART, RefinedTopology


def refinement_matrix(mesh: RefinedTopology) -> sparse.csr_array:
    """Assemble the step from the control points of a mesh to those of `mesh.finer`.

    Returns
    -------
    (n_vertices + n_edges, n_vertices) csr_array
        Rows are not negative and add up to 1.
    """
    return sparse.csr_array(sparse.vstack([vertex_matrix(mesh), _edge_rows(mesh)], format="csr"))


def vertex_matrix(mesh: RefinedTopology) -> sparse.csr_array:
    """Assemble the rows of the refinement matrix for the vertices that are kept."""
    valences = np.arange(1, mesh.ring_size.max(initial=0) + 1)
    weight = np.append(0.0, loop_alpha(valences) / valences)
    return _vertex_rows(mesh, weight, crease_weight=1 / 8)


def limit_matrix(mesh: RefinedTopology) -> sparse.csr_array:
    """Assemble the map from control points to the limit positions of the vertices.

    Returns
    -------
    (n_vertices, n_vertices) csr_array
        Rows add up to 1.

    Source: (3.6) of the paper inside; the cubic B-spline's (1/6, 2/3, 1/6) on sharp edges; at a
    dart the left eigenvector of the subdivision matrix.
    """
    valences = np.arange(1, mesh.ring_size.max(initial=0) + 1)
    weight = np.append(0.0, limit_weight(valences))
    return _vertex_rows(mesh, weight, crease_weight=1 / 6, at_darts=0)


def _vertex_rows(
    mesh: RefinedTopology, weight: FloatArray, crease_weight: float, at_darts: int | None = None
) -> sparse.csr_array:
    """Weigh neighbours by valence, along creases by `crease_weight`; the rest is the vertex's."""
    n, size = mesh.n_vertices, mesh.ring_size
    own = np.where(mesh.kind == CORNER, 0.0, weight[size])
    if not mesh.has_sharp_edges:
        keep = 1 - size * own
        around = np.repeat(own, size)
    else:
        own[mesh.kind == CREASE] = 0
        keep = 1 - size * own
        around = np.repeat(own, size)
        is_crease = np.repeat(mesh.kind == CREASE, size)
        around[is_crease & mesh.is_sharp[mesh.ring_edges]] = crease_weight
        keep[mesh.kind == CREASE] = 1 - 2 * crease_weight
        if at_darts is not None:
            darts = dart_rings(mesh)
            around[darts.places] = darts.weights(at_darts)
            keep[darts.vertices] = darts.weights_of_vertex(at_darts)
    # Each row begins with the vertex itself.
    first = mesh.ring_start[:-1] + np.arange(n, dtype=np.int32)
    is_around = np.ones(n + len(mesh.ring), dtype=bool)
    is_around[first] = False
    indices = np.empty(len(is_around), dtype=np.int32)
    data = np.empty(len(is_around))
    indices[first], data[first] = np.arange(n), keep
    indices[is_around], data[is_around] = mesh.ring, around
    starts = mesh.ring_start + np.arange(n + 1, dtype=np.int32)
    rows = sparse.csr_array((data, indices, starts), shape=(n, n))
    if mesh.has_sharp_edges or (mesh.kind == CORNER).any():
        rows.eliminate_zeros()
    return rows


def _edge_rows(mesh: RefinedTopology) -> sparse.csr_array:
    """3/8 of the ends and 1/8 of the opposite corners; on sharp edges 1/2 of the ends alone."""
    n_edges = len(mesh.edges)
    indices = np.concatenate([mesh.edges, mesh.opposite], axis=1)
    data = np.empty((n_edges, 4))
    data[:] = 3 / 8, 3 / 8, 1 / 8, 1 / 8
    data[mesh.is_sharp] = 1 / 2, 1 / 2, 0, 0
    starts = np.arange(0, 4 * n_edges + 1, 4, dtype=np.int32)
    shape = (n_edges, mesh.n_vertices)
    rows = sparse.csr_array((data.reshape(-1), indices.reshape(-1), starts), shape=shape)
    if mesh.has_sharp_edges:
        rows.eliminate_zeros()
    return rows


def tangent_matrices(mesh: RefinedTopology) -> tuple[sparse.csr_array, sparse.csr_array]:
    """Assemble two maps from control points to limit tangents inside, Σ cos(2πj/n) x_j and sin.

    Their cross product points outward.  Rows of vertices on creases and the boundary are
    meaningless.
    """
    valences = np.arange(mesh.ring_size.max(initial=0) + 1)
    table_start = np.append(0, np.cumsum(valences))
    turn = np.concatenate([np.arange(n) / max(n, 1) for n in valences])
    shift = (table_start[mesh.ring_size] - mesh.ring_start[:-1]).astype(np.int32)
    place = np.repeat(shift, mesh.ring_size)
    place += np.arange(len(mesh.ring), dtype=np.int32)
    cosines, sines = np.cos(2 * np.pi * turn)[place], np.sin(2 * np.pi * turn)[place]
    if mesh.has_sharp_edges:
        darts = dart_rings(mesh)
        cosines[darts.places], sines[darts.places] = darts.weights(1), darts.weights(2)
    shape = (mesh.n_vertices, mesh.n_vertices)
    first = sparse.csr_array((cosines, mesh.ring, mesh.ring_start), shape=shape)
    second = sparse.csr_array((sines, mesh.ring, mesh.ring_start), shape=shape)
    if mesh.has_sharp_edges and len(darts.vertices):
        own = np.zeros(mesh.n_vertices)
        own[darts.vertices] = darts.weights_of_vertex(1)
        first = sparse.csr_array(first + sparse.diags_array(own))
    return first, second


class DartRings(NamedTuple):
    """Rings of the darts, each from its crease on.

    Attributes
    ----------
    vertices : (k,) int
    valences : tuple of int
    places : (sum of valences,) int
        Into the mesh's `ring`, one dart after the other.
    """

    vertices: IndexArray
    valences: tuple[int, ...]
    places: IndexArray

    def weights(self, row: int) -> FloatArray:
        """Weights of the ring entries in a row of `dart_masks`."""
        parts = [dart_masks(n)[row, 1:] for n in self.valences]
        return np.concatenate(parts) if parts else np.empty(0)

    def weights_of_vertex(self, row: int) -> FloatArray:
        """Weights of the darts themselves in a row of `dart_masks`."""
        return np.array([dart_masks(n)[row, 0] for n in self.valences])


def dart_rings(mesh: RefinedTopology) -> DartRings:
    """Collect the rings of the darts; they are few."""
    vertices = np.flatnonzero(mesh.kind == DART)
    places = [np.empty(0, dtype=np.intp)]
    for v in vertices.tolist():
        around = np.arange(mesh.ring_start[v], mesh.ring_start[v + 1])
        first = int(mesh.is_sharp[mesh.ring_edges[around]].argmax())
        places.append(np.roll(around, -first))
    valences = tuple(mesh.ring_size[vertices].tolist())
    return DartRings(vertices, valences, np.concatenate(places))


@lru_cache(maxsize=256)
def dart_masks(valence: int) -> FloatArray:
    """Limit position and two tangents of a dart, (3, 1 + valence): the vertex, then its ring.

    The ring begins at the crease.  Left eigenvectors of the subdivision matrix, of the eigenvalue 1
    and of the largest ones below, which belong to a motion that is symmetric about the crease and
    to one that is antisymmetric.
    """
    n = valence
    step = np.zeros((n + 1, n + 1))
    alpha = float(loop_alpha(n))
    step[0] = np.append(1 - alpha, np.full(n, alpha / n))
    ring = np.arange(n)
    for j, value in ((0, 3 / 8), (1, 1 / 8), (n - 1, 1 / 8)):
        step[1 + ring, 1 + (ring + j) % n] += value
    step[1:, 0] = 3 / 8
    step[1] = 0
    step[1, :2] = 1 / 2
    mirror = np.zeros((n + 1, n + 1))
    mirror[0, 0] = 1
    mirror[1 + ring, 1 + (-ring) % n] = 1
    values, vectors = np.linalg.eig((step @ (np.eye(n + 1) + mirror) / 2).T)
    symmetric = vectors[:, np.argsort(-values.real)[:2]].real.T
    limit = symmetric[0] / symmetric[0].sum()
    along = symmetric[1] * np.sign(symmetric[1, 1])
    across = np.append(0.0, np.sin(2 * np.pi * ring / n))
    masks = np.stack([limit, along, across])
    masks.setflags(write=False)
    return masks
