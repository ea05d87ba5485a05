"""Result of `denoise`: its shapes, and what lies between them."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import DenoiseSettings, denoise
from adaptive_fairing.core.denoising.plan import STRENGTHS

POINTS, FACES = meshes.noisy_ball(3, 0.03)


@pytest.fixture(scope="module")
def result():
    return denoise(POINTS, FACES)


def test_every_strength_has_a_shape_and_that_of_the_settings_is_chosen(result):
    assert tuple(result.strengths) == STRENGTHS
    assert np.array_equal(result.positions, result.shapes[2])
    moves = [np.linalg.norm(shape - POINTS) for shape in result.shapes]
    assert moves[:3] == sorted(moves[:3])
    # Beyond that next to all noise is gone, and filters change places that are worth the same.
    np.testing.assert_allclose(moves[3:], max(moves), rtol=0.01)
    assert result.is_changed


def test_at_a_strength_between_two_it_is_between_their_shapes(result):
    assert np.array_equal(result.at(0), POINTS)
    for strength, shape in zip(result.strengths, result.shapes, strict=True):
        np.testing.assert_allclose(result.at(strength), shape, rtol=0, atol=1e-15)
    between = result.shapes[2] + 0.25 * (result.shapes[3] - result.shapes[2])
    np.testing.assert_allclose(result.at(1.125), between, rtol=0, atol=1e-15)
    first = POINTS + (result.shapes[0] - POINTS) / 4
    np.testing.assert_allclose(result.at(0.125), first, rtol=0, atol=1e-15)
    assert np.array_equal(result.at(9), result.shapes[-1])


def test_what_has_not_moved_is_exactly_where_it_was_at_any_strength():
    is_free = np.arange(len(POINTS)) % 3 > 0
    result = denoise(POINTS, FACES, weights=is_free.astype(float))
    for strength in np.linspace(0, 2, 21):
        assert np.array_equal(result.at(strength)[~is_free], POINTS[~is_free])


def test_the_strength_of_the_settings_scales_all_and_its_shape_is_the_same(result):
    stronger = denoise(POINTS, FACES, DenoiseSettings(strength=1.5))
    np.testing.assert_allclose(stronger.strengths, 1.5 * result.strengths)
    removed = np.linalg.norm(result.shapes[3] - POINTS)
    assert np.linalg.norm(stronger.positions - result.shapes[3]) < 1e-6 * removed
    assert stronger.radius > result.radius


def test_a_clean_mesh_is_not_changed_and_the_notes_say_why():
    clean = denoise(*meshes.icosphere(3))
    assert not clean.is_changed
    assert clean.radius == 0
    assert clean.noise_level < 0.01
    assert "no noise found" in clean.notes[-1]
