"""Surfaces given by coordinates: spheres with poles, terrains, turned and scattered bodies."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull, Delaunay

from ..geometry import FloatArray
from .meshing import MeshArrays, graded, near, remeshed, uneven


def pole_sphere(n_around: int, n_rings: int, bumps: float) -> MeshArrays:
    """Make a sphere of longitudes and latitudes, all of whose longitudes meet in two poles."""
    polar = np.pi * np.arange(1, n_rings) / n_rings
    around = 2 * np.pi * np.arange(n_around) / n_around
    ring = np.stack(np.broadcast_arrays(polar[:, None], around[None]), axis=-1).reshape(-1, 2)
    sine = np.sin(ring[:, 0])
    middle = np.stack(
        [sine * np.cos(ring[:, 1]), sine * np.sin(ring[:, 1]), np.cos(ring[:, 0])], axis=1
    )
    points = np.concatenate([middle, [[0, 0, 1], [0, 0, -1]]])
    number = np.arange(len(middle)).reshape(n_rings - 1, n_around)
    after = np.roll(number, -1, axis=1)
    north, south = np.full(n_around, len(middle)), np.full(n_around, len(middle) + 1)
    faces = [
        np.stack([number[:-1], number[1:], after[1:]], axis=-1).reshape(-1, 3),
        np.stack([number[:-1], after[1:], after[:-1]], axis=-1).reshape(-1, 3),
        np.stack([north, number[0], after[0]], axis=1),
        np.stack([south, after[-1], number[-1]], axis=1),
    ]
    x, y, z = points.T
    height = 1 + bumps * (np.sin(3 * x + 1) * np.cos(3 * y) + 0.5 * np.sin(5 * z + 2 * x))
    return points * height[:, None] * [1.0, 0.85, 1.2], np.concatenate(faces).astype(np.int32)


def terrain(seed: int, n_points: int, ridged: bool) -> MeshArrays:
    """Make a landscape over a square: points on a jittered lattice, dense at one place."""
    generator = np.random.default_rng(seed)
    n = round(n_points**0.5)
    share = np.stack(np.meshgrid(*[np.linspace(-1, 1, n)] * 2), axis=-1).reshape(-1, 2)
    inside = np.abs(share).max(axis=1) < 1
    share[inside] += generator.uniform(-0.6, 0.6, (inside.sum(), 2)) / n
    # Squeezed towards the point (0.3, -0.2), with the square's sides kept.
    place = share - 0.28 * np.sin(np.pi * share) - 0.06 * (1 - share**2)
    faces = Delaunay(place).simplices
    corner = place[faces]
    first, second = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    area = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    faces = faces[np.abs(area) > 1e-12]
    turned = area[np.abs(area) > 1e-12] < 0
    faces[turned] = faces[turned][:, ::-1]
    height = np.zeros(len(place))
    for octave in range(5):
        frequency = 1.7 * 1.9**octave
        direction = generator.normal(size=(6, 2))
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        phases = generator.uniform(0, 2 * np.pi, 6)
        waves = np.sin(frequency * np.pi * place @ direction.T / 2 + phases)
        height += (1 - np.abs(waves) if ridged else waves).mean(axis=1) * 0.5 / 2.1**octave
    return np.column_stack([place, height]), faces.astype(np.int32)


def turned(profile: FloatArray, n_around: int, crease: float, edge: float) -> MeshArrays:
    """Make a solid of revolution from radii and heights (n, 2), from axis to axis."""
    angle = 2 * np.pi * np.arange(n_around) / n_around
    radius, height = profile[1:-1].T
    ring = np.stack(
        [
            radius[:, None] * np.cos(angle),
            radius[:, None] * np.sin(angle),
            np.broadcast_to(height[:, None], (len(radius), n_around)),
        ],
        axis=-1,
    ).reshape(-1, 3)
    points = np.concatenate([ring, [[0, 0, profile[0, 1]], [0, 0, profile[-1, 1]]]])
    number = np.arange(len(ring)).reshape(len(radius), n_around)
    after = np.roll(number, -1, axis=1)
    first, last = np.full(n_around, len(ring)), np.full(n_around, len(ring) + 1)
    faces = np.concatenate(
        [
            np.stack([number[:-1], after[:-1], after[1:]], axis=-1).reshape(-1, 3),
            np.stack([number[:-1], after[1:], number[1:]], axis=-1).reshape(-1, 3),
            np.stack([first, after[0], number[0]], axis=1),
            np.stack([last, number[-1], after[-1]], axis=1),
        ]
    )
    return remeshed(points, faces.astype(np.int32), edge, crease)


def pawn() -> MeshArrays:
    """Make a chessman: smooth curves that meet in sharp rims; finer at the head."""
    curve = [
        (0, 0), (1.0, 0), (1.0, 0.25), (0.8, 0.3), (0.8, 0.5),
        *[(0.33 + 0.47 * (1 - t) ** 2.2, 0.5 + 1.5 * t) for t in np.linspace(0.05, 1, 22)],
        (0.62, 2.0), (0.62, 2.12), (0.3, 2.17),
        *[(0.5 * np.sin(a), 2.6 - 0.5 * np.cos(a)) for a in np.linspace(0.75, 3.1, 30)],
        (0, 3.1),
    ]  # fmt: skip
    vertices, faces = turned(np.array(curve), 160, 30.0, 0.03)
    return graded(vertices, faces, 13_000, near(vertices, (0, 0, 2.8), 0.9, 1e-5))


def jittered_ball(generator: np.random.Generator, n_points: int) -> MeshArrays:
    """Make a unit sphere of irregular triangles."""
    height = 1 - (2 * np.arange(n_points) + 1) / n_points
    angle = np.pi * (3 - 5**0.5) * np.arange(n_points)
    radius = np.sqrt(1 - height**2)
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=1)
    points += 0.4 * (4 * np.pi / n_points) ** 0.5 * generator.uniform(-1, 1, points.shape)
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    faces = ConvexHull(points).simplices
    corner = points[faces]
    inward = np.einsum("fd,fd->f", np.cross(corner[:, 0], corner[:, 1]), corner[:, 2]) < 0
    faces[inward] = faces[inward][:, ::-1]
    return points, faces.astype(np.int32)


def pieces(seed: int, sizes: tuple[int, ...]) -> MeshArrays:
    """Make separate lumps of alike size, each of another density."""
    generator = np.random.default_rng(seed)
    vertices, faces, count = [], [], 0
    for k, size in enumerate(sizes):
        points, triangles = jittered_ball(generator, size)
        x, y, z = (points @ np.linalg.qr(generator.normal(size=(3, 3)))[0]).T
        lump = 1 + 0.2 * np.sin(2.5 * x + k) * np.cos(2 * y) + 0.08 * np.sin(6 * z + k)
        vertices.append(points * lump[:, None] + [3.0 * k, 0.4 * (k % 2), 0])
        faces.append(triangles + count)
        count += size
    return np.concatenate(vertices), np.concatenate(faces).astype(np.int32)


def engraved() -> MeshArrays:
    """Engrave a ball with lines at the scale of the edges, where the edges are short."""
    generator = np.random.default_rng(12)
    points, faces = jittered_ball(generator, 90_000)
    points, faces = uneven(points, faces, 16_000, near(points, (0, -1, 0.2), 0.7, 0.06))
    x, _, z = points.T
    front = np.exp(-4 * np.sum(np.square(points - [0, -1, 0.2]), axis=1))
    lines = 0.012 * front * (np.sin(46 * x + 9 * z) + np.sin(52 * z - 14 * x))
    lump = 1 + 0.1 * np.sin(2 * x + 1) * np.cos(3 * z)
    return points * (lump + lines)[:, None], faces
