"""Surfaces given by coordinates: spheres with poles, terrains, turned and scattered bodies."""

from __future__ import annotations

import numpy as np
from scipy.spatial import Delaunay

from tools.geometry.triangles import Faces, FloatArray, convex_hull, grid_faces, spiral

from .meshing import MeshArrays, near, uneven
from .turned import lathe


def pole_sphere(n_around: int, n_rings: int, bumps: float) -> MeshArrays:
    """Make a sphere of longitudes and latitudes, all of whose longitudes meet in two poles."""
    polar = np.pi * np.arange(n_rings + 1) / n_rings
    points, faces = lathe(np.stack([np.sin(polar), np.cos(polar)], axis=1), n_around)
    x, y, z = points.T
    height = 1 + bumps * (np.sin(3 * x + 1) * np.cos(3 * y) + 0.5 * np.sin(5 * z + 2 * x))
    # The profile runs from the north to the south: turned over, the triangles face outwards.
    return points * height[:, None] * [1.0, 0.85, 1.2], faces[:, ::-1]


def terrain(seed: int, n_points: int, ridged: bool) -> MeshArrays:
    """Make a landscape over a square: points on a jittered lattice, dense at one place."""
    generator = np.random.default_rng(seed)
    n = round(n_points**0.5)
    share = np.stack(np.meshgrid(*[np.linspace(-1, 1, n)] * 2), axis=-1).reshape(-1, 2)
    inside = np.abs(share).max(axis=1) < 1
    share[inside] += generator.uniform(-0.6, 0.6, (inside.sum(), 2)) / n
    # Squeezed towards the point (0.3, -0.2), with the square's sides kept.
    place = share - 0.28 * np.sin(np.pi * share) - 0.06 * (1 - share**2)
    faces = triangulated(place)
    height = np.zeros(len(place))
    for octave in range(5):
        frequency = 1.7 * 1.9**octave
        direction = generator.normal(size=(6, 2))
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        phases = generator.uniform(0, 2 * np.pi, 6)
        waves = np.sin(frequency * np.pi * place @ direction.T / 2 + phases)
        height += (1 - np.abs(waves) if ridged else waves).mean(axis=1) * 0.5 / 2.1**octave
    return np.column_stack([place, height]), faces


def crater(n_points: int = 9_500) -> MeshArrays:
    """Make a volcano's island with a jagged coast: points in a spiral, densest at the crater."""
    generator = np.random.default_rng(31)
    share = np.sqrt((np.arange(n_points) + 0.5) / n_points)
    angle = np.pi * (3 - 5**0.5) * np.arange(n_points)
    disc = share[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    disc += 0.5 / n_points**0.5 * generator.uniform(-1, 1, disc.shape)
    n_boundary = round(3.2 * n_points**0.5)
    turn = 2 * np.pi * np.arange(n_boundary) / n_boundary
    inner = disc[np.linalg.norm(disc, axis=1) < 1 - 1.2 / n_points**0.5]
    disc = np.concatenate([inner, np.stack([np.cos(turn), np.sin(turn)], axis=1)])
    faces = triangulated(disc)
    radius, angle = np.linalg.norm(disc, axis=1), np.arctan2(disc[:, 1], disc[:, 0])
    coast = 1 + 0.12 * np.sin(3 * angle + 1) + 0.06 * np.sin(8 * angle) + 0.03 * np.sin(17 * angle)
    # Drawn towards the middle, and out to the coast near the boundary.
    place = 2 * disc * (radius**0.7 * (1 + radius**3 * (coast - 1)))[:, None]
    far = np.linalg.norm(place - [0.1, 0.05], axis=1)
    gullies = np.sin(26 * angle + 4 * far) * np.exp(-(((far - 0.9) / 0.4) ** 2))
    height = 0.9 * np.exp(-1.6 * far) + 0.04 * gullies
    height -= 0.55 * np.exp(-((far / 0.32) ** 4))
    height += 0.03 * np.tanh(2 * np.sin(9 * place[:, 0] + 3 * place[:, 1])) * np.clip(far - 1, 0, 1)
    height += 0.01 * np.sin(21 * place[:, 0]) * np.cos(19 * place[:, 1])
    return np.column_stack([place, height]), faces


def triangulated(points: FloatArray) -> Faces:
    """Return Delaunay's triangles of points (n, 2), counter-clockwise, none without an area."""
    faces = Delaunay(points).simplices
    corner = points[faces]
    first, second = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    area = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    faces[area < 0] = faces[area < 0][:, ::-1]
    return faces[np.abs(area) > 1e-12].astype(np.int32)


def knot(n_along: int = 420, n_around: int = 26) -> MeshArrays:
    """Make a trefoil of a ribbed band, its rings closer to each other on one side."""
    step = 2 * np.pi * np.arange(n_along) / n_along
    t = step + 0.45 * np.sin(step)
    radius = 2 + np.cos(3 * t)
    centre = np.stack([radius * np.cos(2 * t), radius * np.sin(2 * t), 1.1 * np.sin(3 * t)], axis=1)
    before, after = np.roll(centre, 1, axis=0), np.roll(centre, -1, axis=0)
    along = (after - before) / np.linalg.norm(after - before, axis=1, keepdims=True)
    out = [np.array([0.0, 0.0, 1.0])]
    for way in [*along, along[0]]:
        carried = out[-1] - (out[-1] @ way) * way
        out.append(carried / np.linalg.norm(carried))
    first, last = out[1], out[-1]
    # What is carried once around comes back turned: every ring takes its share of that.
    turn = np.arctan2(np.cross(first, last) @ along[0], first @ last)
    out = np.array(out[1:-1])
    side = np.cross(out, along)
    angle = 2 * np.pi * np.arange(n_around) / n_around
    turned_by = angle + turn * np.arange(n_along)[:, None] / n_along
    across = 0.42 + 0.03 * np.cos(24 * t)[:, None] + 0.04 * np.cos(4 * angle)
    points = centre[:, None] + across[..., None] * (
        np.cos(turned_by)[..., None] * out[:, None] + np.sin(turned_by)[..., None] * side[:, None]
    )
    return points.reshape(-1, 3), grid_faces(n_along, n_around, (True, True))


def jittered_ball(generator: np.random.Generator, n_points: int) -> MeshArrays:
    """Make a unit sphere of irregular triangles."""
    points = spiral(n_points)
    points += 0.4 * (4 * np.pi / n_points) ** 0.5 * generator.uniform(-1, 1, points.shape)
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    return convex_hull(points)


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
