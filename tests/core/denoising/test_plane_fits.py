"""Planes of flat faces: outliers, bent faces, vertices that go onto planes."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core.denoising.flat_faces import PlaneFits

GRID, FACES = meshes.flat_grid(24, 24)
GRID = GRID - GRID.mean(axis=0)
ONE_FACE = np.zeros(len(FACES), dtype=int)
EDGE = np.full(len(GRID), np.linalg.norm(GRID[1] - GRID[0]))


def raised(heights):
    """The grid with heights in edge lengths."""
    return GRID + np.outer(heights * EDGE, [0, 0, 1])


def fits(positions):
    return PlaneFits(positions, EDGE, FACES, ONE_FACE)


def noise(seed, amplitude=0.2):
    return np.random.default_rng(seed).normal(0, amplitude, len(GRID))


def test_the_plane_is_as_near_as_the_noise_allows():
    """The error of three coefficients from n values, √(3 / n) in the mean."""
    errors = []
    for seed in range(40):
        planes = fits(raised(noise(seed)))
        upwards = planes.normals[0] * np.sign(planes.normals[0, 2])
        heights = -(GRID - planes.centres[0]) @ upwards / upwards[2]
        errors.append(np.mean((heights / EDGE) ** 2))
    expected = 0.2 * np.sqrt(3 / len(GRID))
    assert np.sqrt(np.mean(errors)) == pytest.approx(expected, rel=0.3)


def test_outliers_do_not_count():
    heights = np.zeros(len(GRID))
    heights[::10] = 3.0
    planes = fits(raised(heights + noise(0, 1e-3)))
    assert abs(planes.normals[0, 2]) > 1 - 1e-6
    assert abs(planes.centres[0, 2] / EDGE[0]) < 1e-3


def test_noise_is_not_bent_and_a_bow_is():
    side = GRID[:, 0] / np.abs(GRID[:, 0]).max()
    flat = np.array([fits(raised(noise(seed))).bends()[0] for seed in range(100)])
    bent = np.array([fits(raised(noise(seed) + 0.4 * side**2)).bends()[0] for seed in range(100)])
    assert np.mean(flat >= 1) <= 0.02
    assert np.all(bent > 1)


def test_triangles_count_by_their_share():
    heights = noise(2) + np.maximum(GRID[:, 0], 0) / EDGE
    on_left = (GRID[FACES][:, :, 0] <= 1e-9).all(axis=1)

    def normal(share_on_right):
        share = np.where(on_left, 1.0, share_on_right)
        return PlaneFits(raised(heights), EDGE, FACES, ONE_FACE, share).normals[0]

    left_alone = PlaneFits(raised(heights), EDGE, FACES, np.where(on_left, 0, -1)).normals[0]
    assert abs(normal(0) @ left_alone) == pytest.approx(1, abs=1e-9)
    assert abs(normal(1) @ fits(raised(heights)).normals[0]) == pytest.approx(1, abs=1e-12)
    slopes = [abs(np.divide(*normal(share)[[0, 2]])) for share in np.linspace(0, 1, 11)]
    assert np.all(np.diff(slopes) > 0)


def test_vertices_go_the_shortest_way_to_where_their_planes_meet():
    """Vertices of an octahedron: inside of faces, on edges, and at corners of four faces."""
    points, faces = meshes.octahedron()
    for _ in range(3):
        points, faces = meshes.split_1_to_4(points, faces)
    # The octant of each triangle is the number of its face.
    number = (points[faces].mean(axis=1) > 0) @ [4, 2, 1]
    spacing = np.full(len(points), np.sqrt(2) / 8)
    planes = PlaneFits(points, spacing, faces, number)
    moved = points + np.random.default_rng(0).normal(0, 0.02, points.shape)
    result = planes.onto(moved, np.ones(len(planes.vertex)))
    # Less than a hundredth of the way is left, so that nearly parallel planes do not matter.
    height = np.abs(np.abs(result).sum(axis=1) - 1)
    assert height.max() < 0.01 * np.abs(np.abs(moved).sum(axis=1) - 1).max()
    # Inside of a face, where no coordinate is 0, the way is along its normal.
    inside = (np.abs(points) > 1e-9).all(axis=1)
    way = (result - moved)[inside]
    normal = np.sign(points[inside]) / np.sqrt(3)
    across = way - np.einsum("nd,nd->n", way, normal)[:, None] * normal
    assert np.abs(across).max() < 1e-6


def test_vertices_go_the_part_of_the_way_by_which_they_belong():
    heights = noise(1)
    planes = fits(GRID)
    part = np.random.default_rng(0).random(len(GRID))
    result = planes.onto(raised(heights), part)
    # The term for nearly parallel planes leaves some thousandths of the way.
    assert result[:, 2] == pytest.approx((1 - part) * heights * EDGE, abs=0.005 * EDGE[0])


def test_a_vertex_belongs_as_far_as_the_lowest_corner_of_its_best_triangle():
    values = np.random.default_rng(0).random(len(GRID))
    best = fits(GRID).of_best_triangles(values)
    lowest = values[FACES].min(axis=1)
    of_each = [lowest[(FACES == vertex).any(axis=1)].max() for vertex in range(len(GRID))]
    assert np.array_equal(best, of_each)
