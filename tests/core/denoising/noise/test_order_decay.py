"""Correlation of noise at neighbouring vertices, and the level that it stands for."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import TriangleTopology, denoise
from adaptive_fairing.core.denoising.noise.noisy_surface import NoisySurface
from adaptive_fairing.core.denoising.noise_model import NoiseCorrelation
from adaptive_fairing.core.denoising.parameters import PARAMETERS
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface

SHAPES = {
    "sphere": meshes.icosphere(5),
    "graded": meshes.graded_sphere(5),
    "torus": meshes.torus(96, 48),
}


def frame_of(vertices, faces):
    return TriangleSurface(TriangleTopology(faces, len(vertices)), vertices)


def noisy(vertices, faces, coefficient, amplitude):
    """Positions, and the noise along the normals in local edge lengths."""
    frame = frame_of(vertices, faces)
    white = np.random.default_rng(4).normal(size=len(vertices))
    noise = NoiseCorrelation(coefficient).applied(white, frame)
    noise *= amplitude / noise.std()
    return vertices + (noise * frame.spacing)[:, None] * frame.normals, noise


def found(points, smooth, faces):
    everywhere = np.ones(len(points), dtype=bool)
    frame = frame_of(smooth, faces)
    return NoisySurface(points, frame).fading.correlation(everywhere)


@pytest.mark.parametrize("amplitude", [0.05, 0.1, 0.4])
@pytest.mark.parametrize("shape", SHAPES)
def test_white_noise_is_found_white(shape, amplitude):
    vertices, faces = SHAPES[shape]
    points, _ = noisy(vertices, faces, 0, amplitude)
    assert found(points, vertices, faces) == NoiseCorrelation()


@pytest.mark.parametrize("coefficient", [0.53, 0.55])
@pytest.mark.parametrize("shape", SHAPES)
def test_a_known_correlation_is_found(shape, coefficient):
    vertices, faces = SHAPES[shape]
    points, _ = noisy(vertices, faces, coefficient, 0.4)
    correlation = found(points, vertices, faces)
    assert correlation.coefficient == pytest.approx(coefficient, abs=0.04)
    white = np.random.default_rng(9).normal(size=len(vertices))
    frame = frame_of(vertices, faces)
    like_it, as_found = (
        NoiseCorrelation(each).applied(white, frame).std()
        for each in (coefficient, correlation.coefficient)
    )
    assert correlation.deviation == pytest.approx(like_it, rel=0.08)
    # The standard deviation of n numbers is uncertain by 1 / √(2n), 0.01 here.
    assert correlation.deviation == pytest.approx(as_found, rel=0.05)


def test_more_fading_than_that_of_staircases_is_that_of_the_shape():
    vertices, faces = SHAPES["sphere"]
    points, _ = noisy(vertices, faces, 0.7, 0.6)
    correlation = found(points, vertices, faces)
    assert correlation.coefficient == PARAMETERS.correlation_of_staircases


def test_correlation_keeps_a_constant():
    frame = frame_of(*SHAPES["sphere"])
    constant = 1 / frame.spacing
    assert NoiseCorrelation(0.6).applied(constant, frame) == pytest.approx(constant)


def test_auto_finds_and_removes_correlated_noise():
    vertices, faces = SHAPES["torus"]
    points, noise = noisy(vertices, faces, 0.55, 0.35)
    result = denoise(points, faces)
    assert result.noise_level == pytest.approx(0.35, rel=0.15)
    frame = frame_of(vertices, faces)
    left = frame.along_normal(result.positions - vertices)
    assert np.sqrt(np.mean(left**2)) < 0.35 * noise.std()


def test_fine_detail_that_fades_is_shape():
    vertices, faces = SHAPES["torus"]
    points, _ = noisy(vertices, faces, 0.65, 0.2)
    assert found(points, vertices, faces) == NoiseCorrelation()
