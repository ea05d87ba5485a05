"""Planes of flat faces: outliers, bent faces, vertices that go onto planes."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core.denoising.plane_fits import PlaneFits

GRID, FACES = meshes.flat_grid(24, 24)
GRID = GRID - GRID.mean(axis=0)
EVERY = np.arange(len(GRID))
ONE_FACE = np.zeros_like(EVERY)
EDGE = np.full(len(GRID), np.linalg.norm(GRID[1] - GRID[0]))


def raised(heights):
    """The grid with heights in edge lengths."""
    return GRID + np.outer(heights * EDGE, [0, 0, 1])


def fits(positions):
    return PlaneFits(positions, EDGE, EVERY, ONE_FACE, 1)


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


def test_a_bow_is_left_by_no_quadric_and_a_crease_is():
    """What two planes leave tells the one from the other."""
    side = GRID[:, 0] / np.abs(GRID[:, 0]).max()
    halves = np.where(side > 0, 1, 0)
    for heights, is_round in ((2 * side**2, True), (3 * np.abs(side), False)):
        positions = raised(heights + noise(3))
        one = PlaneFits(positions, EDGE, EVERY, ONE_FACE, 1, has_outliers=False)
        two = PlaneFits(positions, EDGE, EVERY, halves, 2)
        apart = one.squares_off(two, halves)
        assert (one.left_by_quadrics() < apart) == [is_round]


def test_what_quadrics_leave_of_noise_is_what_their_freedom_leaves():
    left = []
    for seed in range(40):
        planes = PlaneFits(raised(noise(seed)), 0.2 * EDGE, EVERY, ONE_FACE, 1, has_outliers=False)
        left.append(planes.left_by_quadrics()[0])
    freedom = len(GRID) - 6
    assert np.mean(left) == pytest.approx(freedom, abs=4 * np.sqrt(2 * freedom / 40))


def test_vertices_go_the_shortest_way_to_where_their_planes_meet():
    """Vertices of an octahedron: inside of faces, on edges, and at corners of four faces."""
    points, faces = meshes.octahedron()
    for _ in range(3):
        points, faces = meshes.split_1_to_4(points, faces)
    # The octant of each triangle is the number of its face.
    number = (points[faces].mean(axis=1) > 0) @ [4, 2, 1]
    spacing = np.full(len(points), np.sqrt(2) / 8)
    pairs = np.unique(np.stack([faces.ravel(), np.repeat(number, 3)], axis=1), axis=0)
    planes = PlaneFits(points, spacing, *pairs.T, 8)
    moved = points + np.random.default_rng(0).normal(0, 0.02, points.shape)
    result = planes.onto(moved, *pairs.T, np.ones(len(pairs)))
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
    result = planes.onto(raised(heights), planes.vertex, planes.face, part)
    # The term for nearly parallel planes leaves some thousandths of the way.
    assert result[:, 2] == pytest.approx((1 - part) * heights * EDGE, abs=0.005 * EDGE[0])


@pytest.mark.parametrize("averages", [0, 1, 2])
def test_the_less_smooth_noise_says_the_more_a_cubic_explains(averages):
    """Averages divide the variance: noise of what is left says no more of a plane than before."""
    rng, sheets = np.random.default_rng(0), 40
    neighbours = np.eye(len(GRID))
    for corner in range(3):
        neighbours[FACES[:, corner], FACES[:, corner - 1]] = 1
    neighbours = np.maximum(neighbours, neighbours.T)
    average = neighbours / neighbours.sum(axis=1, keepdims=True)
    heights = rng.normal(0, 0.2, (len(GRID), sheets))
    before = heights.var()
    for _ in range(averages):
        heights = average @ heights
    points = np.concatenate([raised(each) for each in heights.T])
    face = np.repeat(np.arange(sheets), len(GRID))
    planes = PlaneFits(points, np.tile(EDGE, sheets), np.arange(len(points)), face, sheets)
    assert planes.own_part() == pytest.approx(heights.var() / before, rel=0.3)
