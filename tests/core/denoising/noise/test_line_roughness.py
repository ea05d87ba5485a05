"""Roughness along the smoothest line, which creases do not raise even where they are everywhere."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import DenoiseSettings, TriangleTopology, denoise
from adaptive_fairing.core.denoising.noise.contrast import roughness
from adaptive_fairing.core.denoising.noise.level import variance_law
from adaptive_fairing.core.denoising.noise.noisy_surface import NoisySurface
from adaptive_fairing.core.denoising.parameters import PARAMETERS
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface


def plane(n=48):
    """Straight rows of triangles with edges of about 1, no two alike."""
    vertices, faces = meshes.flat_grid(n, n)
    return vertices + 0.15 * np.random.default_rng(0).normal(size=vertices.shape) * [1, 0, 0], faces


def grating():
    """A plane of rows at random heights: creases everywhere, each of them straight."""
    vertices, faces = plane()
    row = np.rint(vertices[:, 1] / np.sqrt(0.75)).astype(int)
    height = 0.5 * np.random.default_rng(3).normal(size=row.max() + 1)
    return vertices + height[row][:, None] * [0, 0, 1], vertices, faces


def levels(points, smooth, faces):
    """Of both measures, inside."""
    topology = TriangleTopology(faces, len(points))
    frame = TriangleSurface(topology, smooth)
    inside = ~topology.on_boundary
    model = variance_law(roughness(points, frame), inside)
    lines = NoisySurface(points, frame).lines
    return (
        np.median(model.level(frame.spacing)[inside]),
        np.median(lines.least[inside]) / np.median(lines.least_of_noise[inside]),
    )


@pytest.mark.parametrize("amplitude", [0.05, 0.1, 0.2, 0.4])
def test_known_noise_is_found(amplitude):
    """One estimate has a standard error of 5 %, the mean of ten one of 1.6 %."""
    vertices, faces = plane()
    spacing = TriangleSurface(TriangleTopology(faces, len(vertices)), vertices).spacing
    found = []
    for seed in range(10):
        noise = amplitude * spacing * np.random.default_rng(seed).normal(size=len(vertices))
        found.append(levels(vertices + noise[:, None] * [0, 0, 1], vertices, faces)[1])
    assert np.mean(found) == pytest.approx(amplitude, rel=0.05)


def test_a_grating_is_smooth_along_its_folds():
    points, flat, faces = grating()
    level, along_lines = levels(points, flat, faces)
    assert level > 2 * PARAMETERS.clean_roughness
    assert along_lines < PARAMETERS.clean_roughness / 4


def test_noise_on_a_grating_is_noise():
    """One line in three is free of creases: what is found is more than there is, not less."""
    points, flat, faces = grating()
    spacing = TriangleSurface(TriangleTopology(faces, len(points)), flat).spacing
    noise = 0.2 * spacing * np.random.default_rng(2).normal(size=len(points))
    _, along_lines = levels(points + noise[:, None] * [0, 0, 1], flat, faces)
    assert 0.19 < along_lines < 0.4


def test_auto_leaves_a_clean_grating_alone():
    points, _, faces = grating()
    result = denoise(points, faces, DenoiseSettings(boundary="free"))
    assert np.array_equal(result.positions, points)
    assert "no noise found" in result.notes[-1]
