"""Exact repetitions of triangles, by which modelled meshes are told."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import DenoiseSettings, TriangleTopology, denoise
from adaptive_fairing.core.denoising.noise import clean_detail


def single(points):
    """As Blender and most files store coordinates."""
    return np.asarray(points, dtype=np.float32).astype(float)


def cylinder(n=128, rows=7, flutes=0.03):
    """Open ends, and walls a little out of the triangles' way: rough, and exact."""
    angle = 2 * np.pi * np.arange(n) / n
    radius = np.where(np.arange(n) % 2, 1.0, 1 - flutes)
    ring = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    points = np.concatenate([np.column_stack([ring, np.full(n, 0.1 * k)]) for k in range(rows)])
    first = np.arange(n)
    second = (first + 1) % n
    faces = []
    for k in range(rows - 1):
        low, high = k * n, (k + 1) * n
        faces += [np.stack([low + first, low + second, high + second], axis=1)]
        faces += [np.stack([low + first, high + second, high + first], axis=1)]
    return single(points), np.concatenate(faces)


def mirrored_bumps():
    """A rough surface without any pattern, and its mirror image beside it."""
    points, faces = meshes.flat_grid(20, 20)
    points = points + 0.2 * np.random.default_rng(0).normal(size=points.shape)
    points[:, 0] -= points[:, 0].min()
    other = points * [-1, 1, 1] - [1, 0, 0]
    return single(np.concatenate([points, other])), np.concatenate(
        [faces, faces[:, ::-1] + len(points)]
    )


def are_repeated(points, faces):
    centred = points - points.mean(axis=0)
    return clean_detail.are_repeated(TriangleTopology(faces, len(points)), single(centred))


MODELS = {"cylinder": cylinder, "mirrored": mirrored_bumps}


@pytest.mark.parametrize("name", MODELS)
def test_models_repeat_themselves(name):
    points, faces = MODELS[name]()
    assert are_repeated(points, faces).mean() > 0.7


@pytest.mark.parametrize("seed", range(5))
def test_a_scan_with_rounded_depths_is_no_model(seed):
    points, faces = meshes.flat_grid(120, 120)
    depths = 0.05 * np.random.default_rng(seed).normal(size=len(points))
    points[:, 2] = 0.004 * np.round(depths / 0.004)
    assert not are_repeated(points, faces).any()


@pytest.mark.parametrize("amplitude", [0.02, 0.05, 0.2])
@pytest.mark.parametrize("seed", range(5))
def test_noise_never_repeats_itself(amplitude, seed):
    for points, faces in (meshes.flat_grid(60, 60), meshes.icosphere(4), cylinder()):
        edge = np.linalg.norm(points[faces[0, 0]] - points[faces[0, 1]])
        noise = amplitude * edge * np.random.default_rng(seed).normal(size=points.shape)
        assert not are_repeated(points + noise, faces).any()


@pytest.mark.parametrize("step", [0.02, 0.1])
def test_noise_on_rounded_coordinates_is_noise(step):
    """As in compressed scans: many triangles have the lengths of others, but not those around."""
    points, faces = meshes.icosphere(4)
    edge = np.linalg.norm(points[faces[0, 0]] - points[faces[0, 1]])
    noise = 0.1 * edge * np.random.default_rng(0).normal(size=(len(points), 1)) * points
    noisy = step * edge * np.round((points + noise) / (step * edge))
    assert are_repeated(noisy, faces).mean() < 0.01
    before, after = (
        np.std(np.linalg.norm(each, axis=1)) for each in (noisy, denoise(noisy, faces).positions)
    )
    assert after < 0.3 * before


def test_a_rough_model_comes_back_bit_by_bit_with_one_sentence_why():
    points, faces = cylinder()
    result = denoise(points, faces)
    assert not result.is_changed
    assert np.array_equal(result.shapes[-1], points)
    assert result.notes[-1].startswith("looks like a clean low-poly model: ")
    assert "exact copies of others; nothing was changed" in result.notes[-1]


def radial_noise(points, size, seed):
    """Noise of a size in edges between neighbours on a ring."""
    heights = size * 2 * np.pi / 128 * np.random.default_rng(seed).normal(size=(len(points), 1))
    return heights * points * [1, 1, 0]


@pytest.mark.parametrize("size", [0.1, 0.2, 0.3])
@pytest.mark.parametrize("seed", range(3))
def test_its_noisy_version_is_denoised_if_it_has_no_flutes(size, seed):
    points, faces = cylinder(flutes=0)
    noisy = points + radial_noise(points, size, seed)
    result = denoise(noisy, faces)
    before, after = (np.linalg.norm(each - points) for each in (noisy, result.positions))
    assert after < 0.85 * before


@pytest.mark.parametrize("size", [0.02, 0.05, 0.1, 0.2, 0.3])
def test_flutes_as_fine_as_the_edges_do_not_go_with_the_noise(size):
    points, faces = cylinder()
    noisy = points + radial_noise(points, size, 0)
    result = denoise(noisy, faces)
    before, after = (np.linalg.norm(each - points) for each in (noisy, result.positions))
    assert after <= before


def test_denoise_anyway():
    points, faces = cylinder()
    result = denoise(points, faces, DenoiseSettings(clean="denoise"))
    assert result.is_changed
    assert result.noise_level > 0.04
