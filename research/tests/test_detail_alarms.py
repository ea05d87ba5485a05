"""Kinds of fine detail: the same on every run, and about as high as noise."""

import numpy as np
import pytest

from research.denoising.detail_alarms import DETAIL, Texture

PLACES = np.stack(np.meshgrid(*[np.arange(40.0)] * 2, [0.0]), axis=-1).reshape(-1, 3)


@pytest.mark.parametrize("kind", DETAIL)
def test_detail_is_repeatable_and_less_than_an_edge_high(kind):
    first, second = (DETAIL[kind](Texture(PLACES, np.random.default_rng(0))) for _ in range(2))
    assert np.array_equal(first, second)
    assert first.shape == (len(PLACES),)
    assert 0.02 < first.std() < 1


def test_waves_have_unit_variance_and_their_length():
    waves = Texture(PLACES, np.random.default_rng(0)).waves(8.0).reshape(40, 40)
    assert waves.std() == pytest.approx(1, abs=0.3)
    steps = np.diff(waves, axis=0)
    # A wave of length l has slopes of variance (2 π / l)² / 3 along each axis.
    assert steps.std() == pytest.approx(2 * np.pi / 8 / 3**0.5, rel=0.3)
