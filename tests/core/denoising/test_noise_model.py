"""Correlation of noise: white noise mixed with the mean of the neighbours, or averaged."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import TriangleTopology
from adaptive_fairing.core.denoising.noise_model import (
    WHITE,
    NoiseCorrelation,
    VarianceLaw,
    certainty,
)
from adaptive_fairing.core.denoising.parameters import PARAMETERS
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface

VERTICES, FACES = meshes.graded_sphere(3)
FRAME = TriangleSurface(TriangleTopology(FACES, len(VERTICES)), VERTICES)
NOISE = np.random.default_rng(0).normal(size=len(VERTICES))


def mean_around(lengths):
    """Mean over the neighbours, one vertex after the other."""
    edges = meshes.edges_of(FACES)
    both = np.concatenate([edges, edges[:, ::-1]])
    total = np.bincount(both[:, 0], lengths[both[:, 1]])
    return total / np.bincount(both[:, 0])


def test_what_comes_near_to_a_limit_counts_less_and_less():
    parts = np.linspace(-1, 2, 301)
    counts = certainty(parts)
    assert (counts[parts < 0.66] == 1).all()
    assert (counts[parts > 0.999] == 0).all()
    assert (np.diff(counts) <= 0).all()
    assert np.abs(np.diff(counts)).max() < 0.031  # no leap


def test_white_noise_stays_as_it_is():
    assert WHITE.applied(NOISE, FRAME) is NOISE


@pytest.mark.parametrize("coefficient", [0.3, 0.55])
def test_lengths_are_mixed_with_those_of_the_neighbours(coefficient):
    """Not heights in local edge lengths, whose unit differs from vertex to vertex."""
    mixed = NoiseCorrelation(coefficient).applied(NOISE, FRAME)
    lengths = NOISE * FRAME.spacing
    expected = (1 - coefficient) * lengths + coefficient * mean_around(lengths)
    np.testing.assert_allclose(mixed * FRAME.spacing, expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("passes", [1, 2, 4, 8, 16])
def test_noise_of_neighbours_is_as_alike_as_is_said(passes):
    points, faces = meshes.icosphere(5)
    sphere = TriangleSurface(TriangleTopology(faces, len(points)), points)
    smooth = NoiseCorrelation(passes=passes)
    heights = smooth.applied(np.random.default_rng(0).normal(size=len(points)), sphere)
    first, second = heights[meshes.edges_of(faces)].T
    assert np.corrcoef(first, second)[0, 1] == pytest.approx(smooth.of_neighbours, abs=0.03)
    assert WHITE.of_neighbours == 0


@pytest.mark.parametrize("passes", [1, 3])
def test_a_pass_averages_lengths_half_with_those_of_the_neighbours(passes):
    expected = NOISE * FRAME.spacing
    for _ in range(passes):
        expected = (expected + mean_around(expected)) / 2
    smooth = NoiseCorrelation(passes=passes).applied(NOISE, FRAME)
    np.testing.assert_allclose(smooth * FRAME.spacing, expected, rtol=0, atol=1e-12)


def test_the_roughness_of_clean_meshes_is_a_part_of_what_grows_with_the_edges():
    clean, spacing = PARAMETERS.clean_roughness, np.array([0.5, 1.0, 2.0, 4.0])
    one_amplitude = VarianceLaw(0.0, 0.01)
    assert one_amplitude.noise(spacing) == pytest.approx(one_amplitude.level(spacing))
    assert VarianceLaw(0.09, 0.0).noise(spacing) == pytest.approx((0.3**4 - clean**4) ** 0.25)
    assert not VarianceLaw(0.99 * clean**2, 0.0).noise(spacing).any()
    mixed = VarianceLaw(clean**2, 0.01)
    level = mixed.level(spacing)
    assert np.all(mixed.noise(spacing) > (level**4 - clean**4) ** 0.25)
    assert np.all(mixed.noise(spacing) < level)
    assert not VarianceLaw(0.0, 0.0).noise(spacing).any()
