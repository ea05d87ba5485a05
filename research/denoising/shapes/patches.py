"""Open surfaces: flat, bent and torn ones, with corners, holes and jagged boundaries."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from tools.geometry.triangles import Faces, FloatArray

from .meshing import MeshArrays
from .parametric import triangulated


def square() -> MeshArrays:
    """Make a flat square."""
    place, faces = patch([polygon([(-1, -1), (1, -1), (1, 1), (-1, 1)], 0.045)], 0.045)
    return np.column_stack([place, np.zeros(len(place))]), faces


def ell() -> MeshArrays:
    """Make a gently bent sheet like the letter L."""
    corners = [(-1, -1), (1, -1), (1, -0.1), (0, -0.1), (0, 1), (-1, 1)]
    place, faces = patch([polygon(corners, 0.035)], 0.035)
    x, y = place.T
    return np.column_stack([place, 0.25 * np.cos(1.5 * x) + 0.1 * np.sin(3 * y)]), faces


def sieve() -> MeshArrays:
    """Make a bumpy disc with a wavy boundary, and a round hole, a star and a square in it."""
    square_hole = polygon([(0.2, -0.6), (0.6, -0.6), (0.6, -0.2), (0.2, -0.2)], 0.035)
    loops = [
        ring((0, 0), 1.1, 190, (0.05, 7)),
        ring((-0.45, -0.35), 0.28, 50),
        ring((0, 0.5), 0.27, 70, (0.25, 5)),
        square_hole,
    ]
    place, faces = patch(loops, 0.035)
    x, y = place.T
    bumps = 0.15 * np.sin(2.5 * x + 1) * np.cos(3 * y) + 0.03 * np.sin(8 * x - 5 * y)
    return np.column_stack([place, bumps]), faces


def half_pipe() -> MeshArrays:
    """Bend a rectangle to half of a pipe."""
    reach = np.pi / 2
    corners = [(-reach, -1.5), (reach, -1.5), (reach, 1.5), (-reach, 1.5)]
    place, faces = patch([polygon(corners, 0.06)], 0.06)
    return np.column_stack([np.sin(place[:, 0]), place[:, 1], np.cos(place[:, 0])]), faces


def cap() -> MeshArrays:
    """Make more than half of a ball, densest at its top."""
    place, faces = patch([ring((0, 0), 1.0, 170)], 0.037)
    radius = np.linalg.norm(place, axis=1)
    angle, turn = 1.8 * radius**1.3, np.arctan2(place[:, 1], place[:, 0])
    size = np.sin(angle)
    return np.stack([size * np.cos(turn), size * np.sin(turn), np.cos(angle)], axis=1), faces


def patch(loops: Sequence[FloatArray], spacing: float) -> tuple[FloatArray, Faces]:
    """Triangulate the part of the plane inside an odd number of loops (k, 2), irregularly."""
    generator = np.random.default_rng(17)
    boundaries = np.concatenate(loops)
    low, high = boundaries.min(axis=0), boundaries.max(axis=0)
    rows = np.arange(low[1], high[1], spacing * 0.75**0.5)
    columns = np.arange(low[0], high[0], spacing)
    x, y = np.meshgrid(columns, rows)
    x[::2] += spacing / 2
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    points += 0.25 * spacing * generator.uniform(-1, 1, points.shape)
    is_far = cKDTree(boundaries).query(points)[0] > 0.6 * spacing
    points = np.concatenate([boundaries, points[is_far & are_inside(points, loops)]])
    faces = triangulated(points)
    return points, faces[are_inside(points[faces].mean(axis=1), loops)]


def are_inside(points: FloatArray, loops: Sequence[FloatArray]) -> np.ndarray:
    """Whether each point (n, 2) lies inside an odd number of loops."""
    inside = np.zeros(len(points), dtype=bool)
    for start in loops:
        way = np.roll(start, -1, axis=0) - start
        gap = points[:, None, 1] - start[:, 1]
        is_level = way[:, 1] == 0
        part = gap / np.where(is_level, 1, way[:, 1])
        is_right = points[:, None, 0] < start[:, 0] + part * way[:, 0]
        spans = (gap >= 0) != (gap >= way[:, 1])
        inside ^= np.count_nonzero(is_right & spans & ~is_level, axis=1) % 2 == 1
    return inside


def polygon(corners: Sequence[tuple[float, float]], spacing: float) -> FloatArray:
    """Make points along a polygon with these corners."""
    sides = zip(np.array(corners), np.roll(corners, -1, axis=0), strict=True)
    return np.concatenate(
        [
            np.linspace(start, end, round(np.linalg.norm(end - start) / spacing), endpoint=False)
            for start, end in sides
        ]
    )


def ring(
    centre: tuple[float, float], radius: float, n: int, wave: tuple[float, int] = (0.0, 1)
) -> FloatArray:
    """Make n points on a circle whose radius has waves: their part of it, and how many."""
    turn = 2 * np.pi * np.arange(n) / n
    size = radius * (1 + wave[0] * np.cos(wave[1] * turn))
    return centre + size[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
