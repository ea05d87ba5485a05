"""Tuned numbers of the automatic method, varied for the calling thread alone."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import denoise
from adaptive_fairing.core.denoising.parameters import PARAMETERS, parameters, using

OTHER = replace(PARAMETERS, noise_factor=2.0)


def test_the_parameters_cannot_be_changed():
    with pytest.raises(FrozenInstanceError):
        PARAMETERS.noise_factor = 2.0


def test_other_parameters_hold_inside_the_block_alone():
    assert parameters() is PARAMETERS
    with using(OTHER):
        assert parameters() is OTHER
        with using(PARAMETERS):
            assert parameters() is PARAMETERS
        assert parameters() is OTHER
    assert parameters() is PARAMETERS


def test_an_error_in_the_block_ends_it():
    with pytest.raises(ZeroDivisionError), using(OTHER):
        raise ZeroDivisionError
    assert parameters() is PARAMETERS


def test_other_threads_keep_their_parameters():
    with ThreadPoolExecutor(1) as pool, using(OTHER):
        assert pool.submit(parameters).result() is PARAMETERS


def test_a_run_follows_the_parameters_of_its_block():
    points, faces = meshes.noisy_ball(3, 0.02)
    usual = denoise(points, faces)
    with using(OTHER):
        more = denoise(points, faces)
    assert more.radius > usual.radius
    assert np.array_equal(denoise(points, faces).positions, usual.positions)
