"""Unbiased risk estimate, and the mixture for which it is least."""

from dataclasses import replace

import numpy as np
import pytest

from adaptive_fairing.core.denoising.mesh_parts import density_classes
from adaptive_fairing.core.denoising.mixture import least_risk_coefficients
from adaptive_fairing.core.denoising.parameters import PARAMETERS, using

N = 4000
ONE_CLASS = np.ones((1, N))


def signal_and_noise(sigma, seed=0):
    generator = np.random.default_rng(seed)
    signal = np.sin(np.linspace(0, 8 * np.pi, N))
    return signal, sigma * generator.normal(size=N)


def test_one_filter_gets_the_coefficient_of_the_wiener_filter():
    """Shrinking towards 0 removes x itself, with divergence 1: a = σ² n / |x|²."""
    signal, noise = signal_and_noise(1.0)
    observed = signal + noise
    found = least_risk_coefficients(observed[None], np.ones((1, N)), np.ones((1, N)), ONE_CLASS)[0]
    assert found[0, 0] == pytest.approx(N / np.sum(observed**2), rel=1e-4)
    true_risk = [np.mean((observed * (1 - a) - signal) ** 2) for a in np.linspace(0, 1, 101)]
    assert found[0, 0] == pytest.approx(np.argmin(true_risk) / 100, abs=0.03)


def test_the_filter_that_removes_just_the_noise_is_taken():
    signal, noise = signal_and_noise(0.5)
    removed = np.stack([noise, signal + noise])
    found = least_risk_coefficients(removed, np.ones((2, N)), np.full((1, N), 0.25), ONE_CLASS)[0]
    assert found[0, 0] > 0.95
    assert found[0, 1] < 0.02


def test_without_noise_nothing_is_removed():
    removed, all_of_it = np.random.default_rng(1).normal(size=(3, N)), np.ones((3, N))
    clean, noisy = np.zeros((1, N)), np.ones((1, N))
    assert not least_risk_coefficients(removed, all_of_it, clean, ONE_CLASS).any()
    assert not least_risk_coefficients(0 * removed, all_of_it, noisy, ONE_CLASS).any()


def test_coefficients_are_not_negative_and_add_up_to_at_most_one():
    generator = np.random.default_rng(2)
    removed = generator.normal(size=(5, N)) + generator.normal(size=N)
    classes = density_classes(generator.normal(size=N), np.ones(N, dtype=bool))
    for level in (0.3, 3, 100):
        variances = np.full((1, N), level)
        (found,) = least_risk_coefficients(removed, np.ones((5, N)), variances, classes)
        assert found.min() >= 0
        assert np.all(found.sum(axis=1) < 1.02)
    # With more noise than there is of anything, all of the allowed sum is used.
    assert found.sum(axis=1) == pytest.approx(1, abs=0.02)


def test_no_other_mixture_has_less_risk():
    """Against all mixtures of two filters on a grid."""
    generator = np.random.default_rng(3)
    removed = generator.normal(size=(2, N)) + 0.7 * generator.normal(size=N)
    divergence = np.array([[0.9], [0.6]]) * np.ones(N)

    def risk(a):
        return np.sum((a @ removed) ** 2) - 2 * np.sum(a @ divergence)

    chosen = least_risk_coefficients(removed, divergence, np.ones((1, N)), ONE_CLASS)[0, 0]
    grid = np.linspace(0, 1, 41)
    others = min(risk(np.array([a, b])) for a in grid for b in grid if a + b <= 1)
    assert risk(chosen) <= others + 1e-3 * abs(others)


def mean_risk(n, parts, deviation=PARAMETERS.class_deviation):
    """True risk of mixtures of one filter in two classes, over that of removing nothing.

    The filter removes the noise, and a part of a signal as strong, one part for each class.
    """
    generator = np.random.default_rng(0)
    classes = np.repeat(np.eye(2), n // 2, axis=1)
    part = np.repeat(parts, n // 2)
    risks = []
    with using(replace(PARAMETERS, class_deviation=deviation)):
        for _ in range(200):
            signal, noise = generator.normal(size=(2, n))
            removed = (noise + part * signal)[None]
            (found,) = least_risk_coefficients(removed, np.ones((1, n)), np.ones((1, n)), classes)
            left = noise - classes.T @ found[:, 0] * removed[0]
            risks.append(np.mean(left**2))
    return np.mean(risks)


def test_classes_learn_from_each_other():
    """Where they want the same coefficient, few vertices are wrong about it by less."""
    alike = [1.0, 1.0]
    assert mean_risk(60, alike) < 0.99 * mean_risk(60, alike, deviation=1e6)


def test_classes_that_differ_have_their_own_coefficients():
    apart = [0.0, 3.0]
    for n, most in ((4000, 1.001), (400, 1.05)):
        assert mean_risk(n, apart) < most * mean_risk(n, apart, deviation=1e6)
    assert mean_risk(4000, apart) < 0.9 * mean_risk(4000, apart, deviation=1e-6)


def test_the_same_mixture_in_any_unit_of_length():
    generator = np.random.default_rng(5)
    removed = generator.normal(size=(3, N)) + generator.normal(size=N)
    classes = density_classes(generator.normal(size=N), np.ones(N, dtype=bool))
    variances = np.stack([np.linspace(0.5, 1, N)] * 2)
    first, other = (
        least_risk_coefficients(unit * removed, np.ones((3, N)), unit**2 * variances, classes)
        for unit in (1, 1e3)
    )
    np.testing.assert_allclose(other, first, atol=1e-6)
