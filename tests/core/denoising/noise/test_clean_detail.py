"""Detail of clean meshes, which fades in differences of higher order and is no noise."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import DenoiseSettings, TriangleTopology, denoise
from adaptive_fairing.core.denoising.mesh_parts import MeshParts
from adaptive_fairing.core.denoising.noise.level import variance_law
from adaptive_fairing.core.denoising.noise.noisy_surface import NoisySurface
from adaptive_fairing.core.denoising.parameters import PARAMETERS
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface

SHAPES = {"graded": meshes.graded_sphere(4), "torus": meshes.torus(48, 24)}
EVERY_SHAPE = pytest.mark.parametrize("shape", SHAPES)


def frame_of(shape):
    vertices, faces = SHAPES[shape]
    return TriangleSurface(TriangleTopology(faces, len(vertices)), vertices)


def with_detail(shape, amplitude, seed=0):
    """Bumps of about two edges across, of some local edge lengths."""
    frame = frame_of(shape)
    bumps = np.random.default_rng(seed).normal(size=len(frame.spacing))
    for _ in range(2):
        bumps = (bumps + frame.mean @ bumps) / 2
    bumps *= amplitude / bumps.std()
    return SHAPES[shape][0] + frame.raised(bumps)


def with_noise(shape, amplitude, seed=0):
    frame = frame_of(shape)
    noise = np.random.default_rng(seed).normal(size=len(frame.spacing))
    return SHAPES[shape][0] + frame.raised(amplitude * noise)


def levels(shape, points):
    """Before and after detail was told from noise."""
    frame = frame_of(shape)
    inside = np.ones(len(points), dtype=bool)
    surface = NoisySurface(points, frame)
    rough, of_hinges = (variance_law(each, inside) for each in (surface.roughness, surface.hinges))
    # Hinges count where they are lower by more than chance, 1.167 / √n.
    bound = (1 + 1.167 / np.sqrt(len(points))) * of_hinges.level(frame.spacing)
    lower = np.minimum(1, bound / rough.level(frame.spacing))
    found = MeshParts(frame, ~inside).noise(surface)
    return lower * rough.noise(frame.spacing), found.level


@EVERY_SHAPE
@pytest.mark.parametrize("amplitude", [0.05, 0.07, 0.1, 0.2])
@pytest.mark.parametrize("seed", range(4))
def test_white_noise_stays_noise(shape, amplitude, seed):
    level, kept = levels(shape, with_noise(shape, amplitude, seed))
    np.testing.assert_allclose(kept, level, rtol=1e-12)
    without_clean = (amplitude**4 - PARAMETERS.clean_roughness**4) ** 0.25
    assert np.median(kept) == pytest.approx(without_clean, rel=0.2)


@EVERY_SHAPE
@pytest.mark.parametrize("seed", range(4))
def test_bumps_wider_than_an_edge_are_detail(shape, seed):
    level, kept = levels(shape, with_detail(shape, 0.15, seed))
    assert level.any()
    assert not kept.any()


@EVERY_SHAPE
@pytest.mark.parametrize("strength", [1.0, 4.0])
def test_detail_comes_back_bit_by_bit_at_every_strength(shape, strength):
    """Bumps that are as even and random as smooth noise must be said to be detail."""
    _, faces = SHAPES[shape]
    points = with_detail(shape, 0.15)
    settings = DenoiseSettings(strength=strength, clean="detail")
    as_it_is = denoise(points, faces, settings)
    assert np.array_equal(as_it_is.positions, points)
    assert "as the detail of clean meshes is; nothing was changed" in as_it_is.notes[-1]
    assert as_it_is.noise_level == 0


def test_what_is_rough_and_fades_is_not_taken_for_detail():
    """Contoured volumes: a noise that fades."""
    level, kept = levels("torus", with_detail("torus", 0.8))
    assert np.array_equal(level, kept)


def test_what_is_not_rough_at_all_does_not_fade():
    points, faces = meshes.flat_grid(8, 8)
    frame = TriangleSurface(TriangleTopology(faces, len(points)), points)
    assert not NoisySurface(points, frame).fading.fades(~frame.topology.on_boundary)


def test_few_vertices_of_white_noise_seem_to_fade_by_chance_and_are_not_taken_for_detail():
    frame = frame_of("graded")
    fading = NoisySurface(with_noise("graded", 0.1), frame).fading
    parts = np.array_split(np.arange(len(frame.spacing)), 40)
    counted = [np.isin(np.arange(len(frame.spacing)), part) for part in parts]
    kept = np.array([fading.of_mesh(part)[1] for part in counted])
    assert np.count_nonzero(kept < PARAMETERS.clearly_less) >= 5
    assert sum(fading.fades(part) for part in counted) <= 2
