"""Solids of revolution: a chessman, a vase."""

from __future__ import annotations

import numpy as np

from tools.geometry.triangles import FloatArray, grid_faces

from .meshing import MeshArrays, graded, near, remeshed


def turned(profile: FloatArray, n_around: int, crease: float, edge: float) -> MeshArrays:
    """Make a solid of revolution of even triangles; parameters as in `lathe` and `remeshed`."""
    return remeshed(*lathe(profile, n_around), edge, crease)


def lathe(profile: FloatArray, n_around: int) -> MeshArrays:
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
    here = np.arange(n_around)
    after, last_ring = np.roll(here, -1), len(ring) - n_around
    first, last = np.full(n_around, len(ring)), np.full(n_around, len(ring) + 1)
    caps = (first, after, here), (last, last_ring + here, last_ring + after)
    sides = grid_faces(len(radius), n_around, (False, True))[:, ::-1]
    return points, np.concatenate([sides, *(np.stack(cap, axis=1) for cap in caps)])


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


def vase() -> MeshArrays:
    """Make a fluted vase, open at its mouth, whose wall is about as thick as its edges are long."""
    height = np.linspace(0.12, 2.9, 60)
    outer = 0.55 + 0.42 * np.sin(1.25 * height + 0.25) + 0.28 * np.clip(height - 2.2, 0, None) ** 2
    wall = 0.07
    curve = [
        (0, 0), (0.62, 0), (0.66, 0.05), (outer[0], 0.12), *zip(outer[1:], height[1:], strict=True),
        (outer[-1] - wall / 2, height[-1] + 0.03),
        *zip(outer[:2:-1] - wall, height[:2:-1], strict=True), (0, 0.2),
    ]  # fmt: skip
    vertices, faces = turned(np.array(curve), 150, 35.0, 0.042)
    belly = np.exp(-((vertices[:, 2] - 1.2) ** 2) / 0.5)
    angle = np.arctan2(vertices[:, 1], vertices[:, 0]) + 0.5 * vertices[:, 2]
    vertices[:, :2] *= (1 + 0.035 * belly * np.cos(11 * angle))[:, None]
    return graded(vertices, faces, 24_000, near(vertices, (0, 0, 2.9), 1.1, 0.01))
