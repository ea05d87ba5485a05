"""Contours of whole voxels, and models that repeat themselves as much."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import denoise
from adaptive_fairing.core.denoising.noise.clean_detail import is_voxel_contour


def terraces(seed):
    """Heights in whole steps, as contoured voxels have them."""
    points, faces = meshes.flat_grid(60, 60)
    heights = np.random.default_rng(seed).integers(0, 3, len(points))
    return points + 0.5 * heights[:, None] * [0, 0, 1], faces


def test_whole_steps_are_a_contour():
    points, faces = terraces(1)
    assert is_voxel_contour(faces, points - points.mean(axis=0))


@pytest.mark.parametrize("first", [0, 1800], ids=["all", "the second half"])
def test_noise_of_a_hundredth_of_a_step_makes_it_none(first):
    points, faces = terraces(1)
    points[first:] += 0.005 * np.random.default_rng(2).normal(size=points[first:].shape)
    assert not is_voxel_contour(faces, points - points.mean(axis=0))


def test_flat_and_round_models_are_none():
    for points, faces in (meshes.flat_grid(30, 30), meshes.icosphere(4), meshes.torus(48, 24)):
        assert not is_voxel_contour(faces, points - points.mean(axis=0))


PATTERNS = {
    "grooves": lambda x, y: x % 3 == 0,
    "studs": lambda x, y: (x % 3 == 1) & (y % 3 == 1),
    "bricks": lambda x, y: ((x + 3 * (y // 2 % 2)) % 6 == 0) | (y % 2 == 0),
}


@pytest.mark.parametrize("is_raised", PATTERNS.values(), ids=PATTERNS)
def test_patterns_are_none_and_stay_bit_by_bit(is_raised):
    points, faces = meshes.flat_grid(49, 49)
    row, column = np.divmod(np.arange(50 * 50), 50)
    points[:, 2] = np.where(is_raised(column, row), 0.5, 0)
    assert not is_voxel_contour(faces, points - points.mean(axis=0))
    np.testing.assert_array_equal(denoise(points, faces).positions, points)


def test_nothing_is_no_contour():
    assert not is_voxel_contour(np.zeros((0, 3), int), np.zeros((4, 3)))
