"""The geometry of triangle meshes that tools, benchmarks and tests share; numpy and scipy only."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

FloatArray = NDArray[np.float64]
Faces = NDArray[np.int32]


def edges_of(triangles: Faces) -> NDArray[np.int64]:
    """Return the edges (k, 2), each once, smaller index first."""
    return np.unique(_sides(triangles), axis=0)


def is_closed(triangles: Faces) -> bool:
    """Tell whether every edge has two triangles."""
    return bool(np.all(np.unique(_sides(triangles), axis=0, return_counts=True)[1] == 2))


def boundary_edges(triangles: Faces) -> NDArray[np.int64]:
    """Return the edges (k, 2) that have one triangle, smaller index first."""
    edges, counts = np.unique(_sides(triangles), axis=0, return_counts=True)
    return edges[counts == 1]


def inner_edges(triangles: Faces) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the edges that have two triangles, with the corners of both, and the triangles.

    Returns
    -------
    corners
        (k, 4): an end of the edge, the corner opposite to it in the first triangle, its other end,
        and the corner opposite to it in the second triangle.
    beside
        (k, 2) indices of the triangles.
    """
    sides = _sides(triangles)
    order = np.lexsort(sides.T)
    twice = (sides[order[:-1]] == sides[order[1:]]).all(axis=1)
    pair = np.stack([order[:-1][twice], order[1:][twice]], axis=1)
    side, beside = np.divmod(pair, len(triangles))
    start, end, opposite = (triangles[beside[:, 0], (side[:, 0] + k) % 3] for k in range(3))
    other = triangles[beside[:, 1], (side[:, 1] + 2) % 3]
    return np.stack([start, opposite, end, other], axis=1).astype(np.int64), beside


def edge_lengths(vertices: FloatArray, triangles: Faces) -> FloatArray:
    """Return the length of every edge."""
    ends = vertices[edges_of(triangles)]
    return np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)


def local_edge_lengths(vertices: FloatArray, triangles: Faces) -> FloatArray:
    """Return the mean length (n,) of the edges at every vertex, 0 where there are none."""
    edges = edges_of(triangles)
    length = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    ends = edges.ravel()
    total = np.bincount(ends, np.repeat(length, 2), minlength=len(vertices))
    return total / np.maximum(np.bincount(ends, minlength=len(vertices)), 1)


def density_ratio(vertices: FloatArray, triangles: Faces) -> float:
    """Return the 99th over the 1st percentile of the vertices' mean edge lengths."""
    low, high = np.percentile(local_edge_lengths(vertices, triangles), [1, 99])
    return float(high / low)


def corner_angles(vertices: FloatArray, triangles: Faces) -> FloatArray:
    """Return the angles (m, 3) in degrees."""
    corners = vertices[triangles]
    after = np.roll(corners, -1, axis=1) - corners
    before = np.roll(corners, 1, axis=1) - corners
    sine = np.linalg.norm(np.cross(after, before), axis=2)
    return np.degrees(np.arctan2(sine, np.einsum("mcd,mcd->mc", after, before)))


def scaled_normals(vertices: FloatArray, triangles: Faces) -> FloatArray:
    """Return normals (m, 3) of the triangles, twice their area long."""
    corners = vertices[triangles]
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def normals(vertices: FloatArray, triangles: Faces) -> FloatArray:
    """Return unit normals (m, 3) of the triangles."""
    return unit(scaled_normals(vertices, triangles))


def vertex_normals(vertices: FloatArray, triangles: Faces) -> FloatArray:
    """Return unit normals (n, 3) of the vertices, triangles weighted by area."""
    corners = triangles.T.ravel()
    columns = scaled_normals(vertices, triangles).T
    return unit(np.stack([np.bincount(corners, np.tile(c, 3), len(vertices)) for c in columns], 1))


def unit(vectors: FloatArray) -> FloatArray:
    """Return vectors (n, 3) of length one; those of no length stay as they are."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.where(lengths > 0, lengths, 1.0)


def triangle_areas(vertices: FloatArray, triangles: Faces) -> FloatArray:
    """Return the areas (m,)."""
    return 0.5 * np.linalg.norm(scaled_normals(vertices, triangles), axis=1)


def signed_volume(vertices: FloatArray, triangles: Faces) -> float:
    """Return the volume inside a closed mesh, negative where its triangles face inwards."""
    return float(np.linalg.det((vertices - vertices.mean(axis=0))[triangles]).sum() / 6)


def icosahedron() -> tuple[FloatArray, Faces]:
    """Return the regular icosahedron in the unit sphere: 12 vertices of valence 5."""
    g = (1 + 5**0.5) / 2
    corners = [
        (-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0),
        (0, -1, g), (0, 1, g), (0, -1, -g), (0, 1, -g),
        (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1),
    ]  # fmt: skip
    triangles = [
        (0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11),
        (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8),
        (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9),
        (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1),
    ]  # fmt: skip
    return unit(np.array(corners)), np.array(triangles, dtype=np.int32)


def icosphere(levels: int) -> tuple[FloatArray, Faces]:
    """Return the icosahedron split 1:4 `levels` times, every new vertex put on the unit sphere.

    It has 10 · 4 ** levels + 2 vertices, 12 of valence 5 and the others regular.
    """
    vertices, triangles = icosahedron()
    for _ in range(levels):
        vertices, triangles = split_1_to_4(vertices, triangles)
        vertices = unit(vertices)
    return vertices, triangles


def split_1_to_4(vertices: FloatArray, triangles: Faces) -> tuple[FloatArray, Faces]:
    """Split every triangle at its edge midpoints; the old vertices keep their indices."""
    edges, edge_of = np.unique(_sides(triangles), axis=0, return_inverse=True)
    a, b, c = triangles.T
    ab, bc, ca = len(vertices) + edge_of.reshape(3, -1)
    split = np.concatenate([(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)], axis=1)
    return np.concatenate([vertices, vertices[edges].mean(axis=1)]), split.T.astype(np.int32)


def grid_faces(n_rows: int, n_columns: int, wraps: tuple[bool, bool]) -> Faces:
    """Return the triangles (m, 3) of a grid of vertices, numbered row by row.

    `wraps` says whether the first row follows the last one, and the first column the last one.
    """
    number = np.arange(n_rows * n_columns).reshape(n_rows, n_columns)
    number = np.pad(number, [(0, int(wrap)) for wrap in wraps], mode="wrap")
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    halves = [np.stack(three, axis=-1).reshape(-1, 3) for three in ((a, b, c), (a, c, d))]
    return np.concatenate(halves).astype(np.int32)


def torus(
    major: float, minor: float, segments: tuple[int, int], shift: float = 0.0
) -> tuple[FloatArray, Faces]:
    """Return a ring about the z axis, of so many segments around it and across.

    It is turned in itself by `shift` segments.
    """
    n_around, n_across = segments
    around = 2 * np.pi * np.arange(n_around)[:, None] / n_around
    across = 2 * np.pi * (np.arange(n_across) + shift) / n_across
    radius = major + minor * np.cos(across)
    height = np.broadcast_to(minor * np.sin(across), segments)
    points = np.stack([radius * np.cos(around), radius * np.sin(around), height], axis=-1)
    return points.reshape(-1, 3), grid_faces(*segments, (True, True))


def spiral(n_points: int) -> FloatArray:
    """Return points (n, 3) spread evenly over the unit sphere along a golden spiral."""
    height = 1 - (2 * np.arange(n_points) + 1) / n_points
    angle = np.pi * (3 - 5**0.5) * np.arange(n_points)
    radius = np.sqrt(1 - height**2)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=1)


def convex_hull(points: FloatArray) -> tuple[FloatArray, Faces]:
    """Return points that are all corners of a convex body, and its triangles, facing outwards."""
    triangles = ConvexHull(points).simplices
    centres = points[triangles].mean(axis=1) - points.mean(axis=0)
    inward = np.einsum("md,md->m", scaled_normals(points, triangles), centres) < 0
    triangles[inward] = triangles[inward][:, ::-1]
    return points, triangles.astype(np.int32)


def _sides(triangles: Faces) -> NDArray[np.int64]:
    """Return the sides (0, 1), (1, 2), (2, 0) of all triangles, (3 m, 2), lower index first."""
    pairs = [triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]
    return np.sort(np.concatenate(pairs), axis=1).astype(np.int64)
