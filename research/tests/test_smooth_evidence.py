"""Fit of the evidence for smooth noise: weights that are known come out."""

from __future__ import annotations

import numpy as np
from scipy.special import expit

from adaptive_fairing.core.denoising.parameters import PARAMETERS
from research.denoising.smooth_evidence import Example, fitted_weights, is_told


def test_known_weights_come_out_of_many_examples():
    generator = np.random.default_rng(0)
    known = np.array([-0.5, 2.0, -1.5, 0.7, -0.3])
    measures = generator.normal(size=(20_000, 4))
    odds = measures @ known[:-1] + known[-1]
    is_noise = generator.uniform(size=len(odds)) < expit(odds)
    some = [
        Example("", bool(noise), tuple(row)) for noise, row in zip(is_noise, measures, strict=True)
    ]
    # Twenty thousand examples tell a weight to about 0.02.
    assert np.allclose(fitted_weights([*some, Example("never told", False, None)]), known, atol=0.1)


def test_what_can_not_be_told_is_not():
    weights = np.array([0.0, 0.0, 0.0, 0.0, PARAMETERS.least_evidence])
    assert is_told(Example("", True, (0.0,) * 4), weights)
    assert not is_told(Example("", True, (0.0,) * 4), weights - 0.1)
    assert not is_told(Example("", True, None), weights)
