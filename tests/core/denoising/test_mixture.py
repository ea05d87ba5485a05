"""Coefficients of filters at every vertex, from those of its classes."""

import numpy as np
import pytest

from adaptive_fairing.core.denoising.mixture import Mixture


@pytest.fixture(params=[1, 2], ids=["one part", "two parts"])
def mixture(request):
    generator = np.random.default_rng(0)
    weights = generator.dirichlet((1, 1, 1), size=50).T.astype(np.float32)
    by_class = generator.random((request.param, 3, 4))
    by_class[:, :, 2] = 0
    return Mixture(by_class, weights, generator.integers(request.param, size=50, dtype=np.int32))


def test_the_coefficient_at_a_vertex_is_the_mean_of_its_classes(mixture):
    for index in range(4):
        expected = [
            mixture.by_class[part, :, index] @ weights
            for part, weights in zip(mixture.part, mixture.weights.T, strict=True)
        ]
        np.testing.assert_allclose(mixture.coefficients(index), expected, rtol=1e-6)


def test_a_filter_without_coefficients_is_not_used(mixture):
    assert mixture.used.tolist() == [0, 1, 3]


def test_filters_that_are_none_of_these_get_0(mixture):
    wider = mixture.spread([False, True, True, False, True, True])
    assert wider.used.tolist() == [1, 2, 5]
    for index, old in ((1, 0), (2, 1), (5, 3)):
        assert np.array_equal(wider.coefficients(index), mixture.coefficients(old))
