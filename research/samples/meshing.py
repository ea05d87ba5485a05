"""From an implicit solid to a dense closed triangle mesh: marching tetrahedra."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from tools.geometry.triangles import Faces

from .implicit import Array, Primitive, project

BLOCK = 8
"""Lattice cells per block; the field is evaluated only in blocks near the surface."""


def dense_mesh(solid: Primitive, cell: float) -> tuple[Array, Faces]:
    """Mesh the zero set of a solid at one resolution.

    Parameters
    ----------
    solid
        The shape; its box bounds the lattice.
    cell
        Lattice spacing, in the solid's units.

    Returns
    -------
    vertices, triangles
        (n, 3) positions on the zero set and (m, 3) vertex indices, oriented outwards.

    Source: marching tetrahedra (Doi and Koide 1991), which always give a closed manifold.
    """
    margin = 3 * cell
    origin = solid.lower - margin
    blocks = np.ceil((solid.upper + margin - origin) / (BLOCK * cell)).astype(int)
    values = _sparse_lattice(solid, origin, cell, blocks)
    nodes = _tetrahedra(values)
    pairs = _cut(nodes, values.ravel()[nodes] < 0)
    edges, corner = np.unique(np.sort(pairs.reshape(-1, 2), axis=1), axis=0, return_inverse=True)
    vertices = origin + cell * _crossings(values, edges)
    vertices, triangles = _largest_piece(vertices, corner.reshape(-1, 3))
    return project(solid, vertices, step=0.5 * cell, rounds=1), triangles


def _sparse_lattice(solid: Primitive, origin: Array, cell: float, blocks: Array) -> NDArray:
    """Return field values on the lattice, exact near the surface and ±1 elsewhere."""
    block_ids = np.stack(np.meshgrid(*map(np.arange, blocks), indexing="ij"), -1).reshape(-1, 3)
    width = BLOCK * cell
    centres = origin + (block_ids + 0.5) * width
    at_centre = solid.distance(centres)
    values = np.repeat(np.sign(at_centre).reshape(blocks), BLOCK, axis=0)
    values = np.repeat(np.repeat(values, BLOCK, axis=1), BLOCK, axis=2).astype(np.float32)
    # The fields are distances only roughly, hence the factor above half a block's diagonal.
    active = block_ids[np.abs(at_centre) < 1.3 * width]
    local = np.stack(np.meshgrid(*[np.arange(BLOCK)] * 3, indexing="ij"), -1).reshape(-1, 3)
    for batch in np.array_split(active, max(1, len(active) // 400)):
        nodes = (batch[:, None, :] * BLOCK + local).reshape(-1, 3)
        values[tuple(nodes.T)] = solid.distance(origin + cell * nodes)
    return values


def _tetrahedra(values: NDArray) -> NDArray[np.int64]:
    """Return the lattice nodes (n, 4) of all tetrahedra in the cells crossed by the surface.

    Every cell is cut into six tetrahedra around its diagonal (Kuhn's triangulation), the same
    way everywhere, so that neighbouring cells agree. All are positively oriented.
    """
    inside = values < 0
    corners = list(itertools.product((0, 1), repeat=3))
    shape = np.array(values.shape) - 1
    count = sum(
        inside[tuple(slice(c, c + s) for c, s in zip(corner, shape, strict=True))].astype(np.int8)
        for corner in corners
    )
    cells = np.argwhere((count > 0) & (count < 8))
    strides = np.array([values.shape[1] * values.shape[2], values.shape[2], 1])
    base = cells @ strides
    result = []
    for order in itertools.permutations(range(3)):
        steps = strides[list(order)]
        nodes = np.stack(
            [base, base + steps[0], base + steps[0] + steps[1], base + steps.sum()], axis=1
        )
        is_odd = np.linalg.det(np.eye(3)[list(order)]) < 0
        result.append(nodes[:, [0, 2, 1, 3]] if is_odd else nodes)
    return np.concatenate(result)


def _cut(nodes: NDArray[np.int64], inside: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return the triangles (m, 3, 2) cutting the tetrahedra, each corner a pair of nodes."""
    triangles = []
    n_inside = inside.sum(axis=1)
    for first, *others in ((0, 1, 2, 3), (1, 0, 3, 2), (2, 3, 0, 1), (3, 2, 1, 0)):
        for lonely_inside in (True, False):
            lonely = n_inside == (1 if lonely_inside else 3)
            chosen = nodes[lonely & (inside[:, first] == lonely_inside)]
            pairs = [chosen[:, [first, other]] for other in others]
            triangles.append(np.stack(pairs if lonely_inside else pairs[::-1], axis=1))
    for i, j, k, m in (
        (0, 1, 2, 3),
        (0, 2, 3, 1),
        (0, 3, 1, 2),
        (1, 2, 0, 3),
        (1, 3, 2, 0),
        (2, 3, 0, 1),
    ):
        chosen = nodes[(n_inside == 2) & inside[:, i] & inside[:, j]]
        quad = [chosen[:, pair] for pair in ([i, k], [i, m], [j, m], [j, k])]
        triangles.append(np.stack([quad[0], quad[1], quad[2]], axis=1))
        triangles.append(np.stack([quad[0], quad[2], quad[3]], axis=1))
    return np.concatenate(triangles)


def _crossings(values: NDArray, pairs: NDArray[np.int64]) -> Array:
    """Return the point (n, 3), in cells, where the surface crosses each lattice edge.

    The point keeps away from the edge's ends, for well-shaped triangles; the projection that
    follows makes up for it.
    """
    ends = values.ravel()[pairs].astype(float)
    fraction = np.clip(ends[:, 0] / (ends[:, 0] - ends[:, 1]), 0.15, 0.85)[:, None]
    first, second = (np.stack(np.unravel_index(pairs[:, k], values.shape), 1) for k in (0, 1))
    return (1.0 - fraction) * first + fraction * second


def _largest_piece(vertices: Array, triangles: NDArray[np.int64]) -> tuple[Array, Faces]:
    """Return the connected piece with the most vertices: carving may leave loose crumbs."""
    first, second = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]]]).T
    graph = coo_array((np.ones(len(first)), (first, second)), shape=(len(vertices),) * 2)
    _, piece = connected_components(graph, directed=False)
    kept = piece == np.argmax(np.bincount(piece))
    number = np.cumsum(kept) - 1
    return vertices[kept], number[triangles[kept[triangles[:, 0]]]].astype(np.int32)
