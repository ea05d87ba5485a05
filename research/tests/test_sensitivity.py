"""The tool that moves one parameter of `denoise` after the other."""

import numpy as np
import pytest
from support.meshes import icosphere, noisy_ball

from adaptive_fairing.core.denoising.parameters import PARAMETERS, parameters
from research.denoising import sensitivity
from research.denoising.pairs import Pair


def test_numbers_are_moved_and_counts_become_other_counts():
    assert sensitivity.moved(2.0, 1.25) == 2.5
    assert sensitivity.moved(0.95, 1.25) == 1
    assert sensitivity.moved(3, 1.25) == 4
    assert sensitivity.moved(2, 0.8) == 1
    assert sensitivity.moved(400, 0.8) == 320
    assert sensitivity.moved((1, 8, 20), 1.25) == (2, 10, 25)


@pytest.mark.parametrize("factor", [0.8, 1.25])
def test_every_parameter_can_be_moved(factor):
    for name in sensitivity.NAMES:
        value = getattr(PARAMETERS, name)
        other = sensitivity.moved(value, factor)
        assert np.shape(other) == np.shape(value)
        assert other != value, name


def test_one_row_for_each_parameter_with_what_it_changes():
    """More noise than is estimated blurs a ball more; it has no spikes."""
    clean, faces = icosphere(3)
    noisy, _ = noisy_ball(3, 0.02)
    pair = Pair("ball", "sphere", "tuning", "normal:0.2", clean, noisy, faces)
    names = ["noise_factor", "most_explained"]
    moving, still = sensitivity.changes([pair], names, 1.25)
    assert len(moving) == 4
    assert all(abs(change) > 1e-4 for change in moving)
    assert still == [0, 0, 0, 0]
    assert parameters() is PARAMETERS
