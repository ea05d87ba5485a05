"""Contrasts: half-normal deviates of the size of the noise, to which shape only adds."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import TriangleTopology
from adaptive_fairing.core.denoising.noise.contrast import half_normal, hinges, roughness
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface


def frame_of(vertices, faces):
    return TriangleSurface(TriangleTopology(faces, len(vertices)), vertices)


def uneven_plane(n=60):
    points, faces = meshes.flat_grid(n, n)
    points = points + 0.15 * np.random.default_rng(0).normal(size=points.shape) * [1, 1, 0]
    points[:, 0] *= 1 + points[:, 0] / n  # coarser on one side
    return points, faces


@pytest.mark.parametrize("contrast", [roughness, hinges])
@pytest.mark.parametrize("amplitude", [0.01, 0.1, 0.2])
def test_white_noise_makes_half_normal_contrasts_of_its_size(contrast, amplitude):
    points, faces = uneven_plane()
    frame = frame_of(points, faces)
    inside = ~frame.topology.on_boundary
    noise = amplitude * np.random.default_rng(1).normal(size=len(points))
    value = contrast(points + frame.raised(noise), frame).among(inside).value
    for quantile in (0.1, 0.3, 0.5, 0.9):
        found = np.quantile(value, quantile) / half_normal(quantile)
        assert found == pytest.approx(amplitude, rel=0.1)


@pytest.mark.parametrize("contrast", [roughness, hinges])
def test_fineness_is_the_variance_of_noise_of_one_amplitude(contrast):
    points, faces = uneven_plane()
    frame = frame_of(points, faces)
    inside = ~frame.topology.on_boundary
    noise = 0.1 * np.random.default_rng(2).normal(size=(len(points), 1)) * [0, 0, 1]
    found = contrast(points + noise, frame).among(inside)
    relative = found.value / np.sqrt(found.fineness)
    assert np.sqrt(np.mean(np.square(relative))) == pytest.approx(0.1, rel=0.05)


def test_hinges_do_not_see_how_a_flat_face_is_triangulated():
    """The ends of a prism are zigzags of slivers: rough for differences, without a hinge."""
    vertices, faces = meshes.sliver_prism(40)
    frame = frame_of(vertices, faces)
    everywhere = np.ones(len(vertices), dtype=bool)
    found = hinges(vertices, frame).among(everywhere)
    assert found.deviation(found.value) < 1e-9
    rough = roughness(vertices, frame)
    assert rough.deviation(rough.value) > 0.1


def test_turning_and_scaling_change_nothing():
    points, faces = meshes.torus(24, 12)
    points = points + 0.02 * np.random.default_rng(3).normal(size=points.shape)
    turn, _ = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))
    for contrast in (roughness, hinges):
        first = contrast(points, frame_of(points, faces)).value
        moved = 7 * points @ turn.T
        np.testing.assert_allclose(contrast(moved, frame_of(moved, faces)).value, first, rtol=1e-6)
