"""From a dense mesh to a feature-adaptive one: Blender's Decimate, then better triangles."""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from tools.geometry.blender_meshes import add_modifier, evaluated, new_object
from tools.geometry.triangles import (
    corner_angles,
    edge_lengths,
    local_edge_lengths,
    normals,
    vertex_normals,
)

from .implicit import Array, Primitive, project
from .meshing import Faces

LEAST_LEVEL = 0.04
"""Vertex-group weight of the densest parts."""


def decimate(
    vertices: Array, triangles: Faces, weights: Array, n_triangles: int, contrast: float
) -> tuple[Array, Faces]:
    """Collapse edges by quadric error until `n_triangles` are left.

    Parameters
    ----------
    vertices, triangles
        The dense mesh, (n, 3) and (m, 3).
    weights
        (n,) in [0, 1]; edges between vertices of weight one are collapsed last.
    n_triangles
        How many triangles to keep.
    contrast
        How strongly the weights count against the quadric error.
    """
    item = new_object(vertices, triangles)
    group = item.vertex_groups.new(name="detail")
    # The modifier collapses vertices of weight one first and never those of weight zero.
    # To the quadric error of an edge it adds contrast * length * (1 - level), summed over the
    # ends: the power makes room between slightly and not at all detailed parts.
    levels = np.round(LEAST_LEVEL**weights, 2)
    for level in np.unique(levels):
        group.add(np.flatnonzero(levels == level).tolist(), float(level), "REPLACE")
    add_modifier(
        item,
        "DECIMATE",
        ratio=n_triangles / len(triangles),
        use_collapse_triangulate=True,
        vertex_group=group.name,
        vertex_group_factor=contrast,
    )
    result = evaluated(item)
    bpy.data.meshes.remove(item.data)  # the object goes with it
    return result


def improve(
    solid: Primitive, vertices: Array, triangles: Faces, rounds: int, flat: float
) -> tuple[Array, Faces]:
    """Flip edges and move vertices within the surface, so that no triangle stays a sliver.

    An edge may be flipped where the cosine between its triangles' normals is above `flat`.
    """
    for _ in range(rounds):
        triangles = flip_edges(vertices, triangles, flat)
        vertices = _relax(vertices, triangles)
        step = 0.5 * float(np.median(edge_lengths(vertices, triangles)))
        vertices = project(solid, vertices, step, rounds=2)
    return vertices, flip_edges(vertices, triangles, flat)


def flip_edges(vertices: Array, triangles: Faces, flat: float, rounds: int = 30) -> Faces:
    """Flip edges while that makes the smallest angle of the two triangles larger.

    An edge stays where the surface bends sharply across it, where the flipped edge exists
    already, and where an end would be left with fewer than four triangles.
    """
    triangles = triangles.copy()
    for _ in range(rounds):
        chosen = _best_flips(vertices, triangles, flat)
        if not len(chosen):
            break
        first, second, (a, b, c, d) = chosen[:, 0], chosen[:, 1], chosen[:, 2:].T
        triangles[first] = np.stack([c, a, d], axis=1)
        triangles[second] = np.stack([d, b, c], axis=1)
    return triangles


def _best_flips(vertices: Array, triangles: Faces, flat: float) -> NDArray[np.int64]:
    """Return rows (triangle, triangle, a, b, c, d): edges ab to become cd, no triangle twice."""
    n_vertices = len(vertices)
    half = np.concatenate(
        [triangles[:, [0, 1, 2]], triangles[:, [1, 2, 0]], triangles[:, [2, 0, 1]]]
    ).astype(np.int64)
    owner = np.tile(np.arange(len(triangles)), 3)
    key = half[:, 0] * n_vertices + half[:, 1]
    order = np.argsort(key)
    twin_key = half[:, 1] * n_vertices + half[:, 0]
    twin = order[np.searchsorted(key[order], twin_key)]
    once = half[:, 0] < half[:, 1]
    half_edge, twin = np.flatnonzero(once), twin[once]
    a, b, c = half[half_edge].T
    d = half[twin, 2]
    before = [np.stack([a, b, c], 1), np.stack([b, a, d], 1)]
    after = [np.stack([c, a, d], 1), np.stack([d, b, c], 1)]
    smallest = [
        np.minimum(*(corner_angles(vertices, pair).min(axis=1) for pair in pairs))
        for pairs in (before, after)
    ]
    gain = smallest[1] - smallest[0]
    normal = [normals(vertices, pair) for pair in before + after]
    average = normal[0] + normal[1]
    is_flat = np.einsum("kd,kd->k", normal[0], normal[1]) > flat
    keeps_side = np.all([np.einsum("kd,kd->k", item, average) > 1.2 for item in normal[2:]], 0)
    valence = np.bincount(triangles.ravel(), minlength=n_vertices)
    has_valence = (valence[a] > 4) & (valence[b] > 4) & (valence[c] < 11) & (valence[d] < 11)
    new_key = np.minimum(c, d) * n_vertices + np.maximum(c, d)
    exists = np.isin(new_key, key[once])
    wanted = np.flatnonzero(is_flat & keeps_side & has_valence & ~exists & (gain > 1e-6))
    wanted = wanted[np.argsort(-gain[wanted], kind="stable")]
    rows = np.stack([owner[half_edge], owner[twin], a, b, c, d], axis=1)[wanted]
    # Two flips must share neither triangles nor corners, or valences and edges could go wrong.
    used = np.zeros(n_vertices, dtype=bool)
    keep = []
    for position, row in enumerate(rows[:, 2:]):
        if not used[row].any():
            used[row] = True
            keep.append(position)
    return rows[keep]


def _relax(vertices: Array, triangles: Faces) -> Array:
    """Move vertices half-way to the area-weighted centre of their triangles, tangentially.

    A triangle counts by its area over the local mean square edge, so that the gradation from
    coarse to dense stays as it is.
    """
    local = local_edge_lengths(vertices, triangles)
    corners = vertices[triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    weight = np.linalg.norm(cross, axis=1) / local[triangles].mean(axis=1) ** 2
    centre = corners.mean(axis=1)
    total, share = np.zeros_like(vertices), np.zeros(len(vertices))
    for k in range(3):
        np.add.at(total, triangles[:, k], weight[:, None] * centre)
        np.add.at(share, triangles[:, k], weight)
    move = 0.5 * (total / share[:, None] - vertices)
    normal = vertex_normals(vertices, triangles)
    move -= np.einsum("nd,nd->n", move, normal)[:, None] * normal
    return vertices + move
