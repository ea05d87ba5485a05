"""Noise that is stronger in one place than in another."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import DenoiseSettings, TriangleTopology, denoise
from adaptive_fairing.core.denoising import mesh_parts, mixing
from adaptive_fairing.core.denoising.noise.noisy_surface import NoisySurface
from adaptive_fairing.core.denoising.noise.unevenness import unevenness
from adaptive_fairing.core.denoising.parameters import PARAMETERS
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface

VERTICES, FACES = meshes.icosphere(5)
FRAME = TriangleSurface(TriangleTopology(FACES, len(VERTICES)), VERTICES)
ALL = np.ones(len(VERTICES), dtype=bool)
GROWING = 0.2 * (1 + VERTICES[:, 0])
LEVEL = np.full(len(VERTICES), 0.2)


def noisy(sizes, seed=0):
    heights = sizes * np.random.default_rng(seed).normal(size=len(VERTICES))
    return VERTICES + FRAME.raised(heights)


def factors(sizes, level=LEVEL, seed=0):
    return unevenness(NoisySurface(noisy(sizes, seed), FRAME), level, ALL)


def error(points):
    """Root mean square distance to the sphere, in edges."""
    return np.sqrt(np.mean((np.linalg.norm(points, axis=1) - 1) ** 2)) / np.mean(FRAME.spacing)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("size", [0.05, 0.2, 0.4])
def test_even_noise_is_even(size, seed):
    level = np.full(len(VERTICES), size)
    assert factors(level, level, seed) is None


@pytest.mark.parametrize("seed", range(3))
def test_noise_that_grows_from_one_end_to_the_other_is_told_where_it_is_strong(seed):
    found = 0.2 * factors(GROWING, seed=seed)
    strong, middle = GROWING > 0.3, abs(GROWING - 0.2) < 0.05
    assert np.median(found[strong] / GROWING[strong]) == pytest.approx(1, abs=0.15)
    assert np.median(found[middle] / GROWING[middle]) == pytest.approx(1, abs=0.15)
    # It is weaker where it is weak, but what is left of nothing is not told exactly.
    assert np.median(found[GROWING < 0.05]) < 0.12


def test_noise_as_weak_as_detail_is_not_raised():
    level = np.full(len(VERTICES), 0.04)
    found = factors(0.2 * GROWING, level)
    assert found is not None
    assert found.max() <= 1


def test_few_vertices_tell_nothing():
    few = np.arange(len(VERTICES)) < PARAMETERS.fewest_to_tell - 1
    assert unevenness(NoisySurface(noisy(GROWING), FRAME), LEVEL, few) is None


def test_what_is_not_judged_has_the_factor_1():
    judged = VERTICES[:, 2] > 0
    found = unevenness(NoisySurface(noisy(GROWING), FRAME), LEVEL, judged)
    assert (found[~judged] == 1).all()
    assert (found[judged] != 1).any()


@pytest.mark.parametrize("clean", ["keep", "detail", "denoise"])
def test_noise_is_removed_where_it_is_strong_and_where_it_is_weak(clean):
    """As even noise half of the strong noise would stay."""
    points = noisy(GROWING)
    result = denoise(points, FACES, DenoiseSettings(clean=clean))
    assert error(result.positions) < 0.25 * error(points)
    weak, strong = GROWING < 0.1, GROWING > 0.3
    assert np.median(result.noise[strong]) > 3 * np.median(result.noise[weak])


def test_where_it_does_not_look_like_noise_noise_is_even(monkeypatch):
    """Uneven noise that removes clusters may be shape: then it counts as even, as it did before."""
    looks = mixing._certainty

    def strictly(before, after, verdict, clean):
        certainty, clusters = looks(before, after, verdict, clean)
        return certainty * (verdict.unevenness is None), clusters

    points = noisy(GROWING)
    uneven = denoise(points, FACES).positions
    monkeypatch.setattr(mixing, "_certainty", strictly)
    rejected = denoise(points, FACES).positions
    monkeypatch.setattr(mesh_parts, "unevenness", lambda *_: None)
    even = denoise(points, FACES).positions
    assert np.allclose(rejected, even, rtol=0, atol=1e-12)
    assert error(uneven) < 0.7 * error(even)
