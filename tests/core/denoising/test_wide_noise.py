"""Noise whose width is told: its level, its removal on a coarse level, and what stays."""

from functools import cache

import numpy as np
import pytest
from support.meshes import flat_grid, icosphere

from adaptive_fairing.core import DenoiseSettings, PreparedMesh, TriangleTopology, denoise
from adaptive_fairing.core.denoising.noise.given_width import passes_of_width
from adaptive_fairing.core.denoising.parameters import PARAMETERS
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface


def with_noise(mesh, width, amplitude, seed=0):
    """Add noise of a width along the normals, in local edge lengths, from numbers of our own."""
    vertices, faces = mesh
    surface = TriangleSurface(TriangleTopology(faces, len(vertices)), vertices)
    white = np.random.default_rng(seed).normal(size=len(vertices))
    heights = surface.spread(white, passes_of_width(width))
    return vertices + surface.raised(amplitude * heights / heights.std()), faces, surface


def error(surface, positions):
    """Root mean square distance along the clean normals, in local edge lengths."""
    return np.sqrt(np.mean(np.square(surface.along_normal(positions - surface.positions))))


@cache
def denoised_ball(width, factor=1.0):
    """The result for a sphere with noise of a width, the clean surface, and the preparation.

    The width that is told is larger by a factor.
    """
    x, faces, clean = with_noise(icosphere(6 if width == 8 else 5), width, 0.3)
    prepared, settings = PreparedMesh(x, faces), DenoiseSettings(width=factor * width)
    return denoise(x, faces, settings, prepared=prepared), clean, prepared


@pytest.mark.parametrize("width", [1, 2, 4, 8])
def test_the_level_is_that_of_the_noise(width):
    result, _, _ = denoised_ball(width)
    assert result.noise_level == pytest.approx(0.3, rel=0.35)


@pytest.mark.parametrize("width", [2, 4, 8])
def test_a_width_may_be_told_too_large(width):
    """As if it were as wide, noise would seem 1.5 to 1.7 times as strong."""
    result, clean, _ = denoised_ball(width, 1.25)
    assert result.noise_level == pytest.approx(0.3, rel=0.35)
    assert error(clean, result.positions) < 0.6 * error(clean, result.start)


@pytest.mark.parametrize("width", [2, 4, 8])
def test_noise_of_the_width_goes(width):
    result, clean, _ = denoised_ball(width)
    assert error(clean, result.positions) < 0.6 * error(clean, result.start)
    assert (result.plan.level is not None) == (width == 8)


def test_white_noise_stays_white_if_a_width_is_told():
    x, faces, _ = with_noise(icosphere(5), 1, 0.3)
    smooth, white = (denoise(x, faces, DenoiseSettings(width=each)) for each in (2, 1))
    assert np.array_equal(smooth.positions, white.positions)


def test_wide_noise_is_left_alone_unless_it_is_told():
    x, faces, _ = with_noise(icosphere(5), 8, 0.3)
    assert not denoise(x, faces).is_changed


def test_what_is_finer_than_the_level_stays():
    """Most of a ridge as fine as the mesh stays; the level sees it at some of its vertices."""
    vertices, faces = flat_grid(120, 120)
    x, _, clean = with_noise((vertices, faces), 8, 0.3)
    ridge = np.abs(vertices[:, 0] - vertices[:, 0].mean()) < 0.6 * clean.spacing.mean()
    step = 0.5 * clean.spacing.mean()
    x[ridge, 2] += step
    result = denoise(x, faces, DenoiseSettings(width=8)).positions

    def rise(positions):
        inner = ridge & ~clean.topology.on_boundary
        return np.median((positions - clean.mean @ positions)[inner, 2])

    assert rise(result) > 0.75 * rise(x)
    assert error(clean, result) < error(clean, x)


def test_fixed_boundaries_stay_and_the_surface_does_not_leap_beside_them():
    x, faces, clean = with_noise(flat_grid(100, 100), 8, 0.4)
    result = denoise(x, faces, DenoiseSettings(width=8))
    edge = clean.topology.on_boundary
    move = result.positions - x
    assert not move[edge].any()
    ends = clean.topology.triangles[:, :2]
    leaps = np.abs(clean.along_normal(move)[ends]).max(axis=1)[edge[ends].any(axis=1)]
    assert leaps.max() < 0.25 * np.abs(clean.along_normal(move)).max()


def test_a_plan_treats_other_frames_alike():
    first, clean, prepared = denoised_ball(8)
    settings, faces = DenoiseSettings(width=8), prepared.triangles
    again = denoise(first.start, faces, settings, prepared=prepared, plan=first.plan)
    assert np.array_equal(again.shapes, first.shapes)
    other, _, _ = with_noise(icosphere(6), 8, 0.3, seed=1)
    second = denoise(other, faces, settings, prepared=prepared, plan=first.plan)
    assert error(clean, second.positions) < 0.75 * error(clean, other)


def test_more_strength_removes_more_and_a_limit_holds():
    result, clean, prepared = denoised_ball(8)
    x = result.start
    moves = [np.abs(clean.along_normal(each - x)).mean() for each in result.shapes]
    assert moves == sorted(moves)
    limit = 0.1 * float(clean.spacing.mean())
    settings = DenoiseSettings(width=8, max_deviation=limit)
    bounded = denoise(x, prepared.triangles, settings, prepared=prepared).positions
    assert np.linalg.norm(bounded - x, axis=1).max() <= limit * (1 + 1e-9)


def test_a_level_has_vertices_enough_to_tell_noise_from_shape():
    x, faces, _ = with_noise(icosphere(5), 16, 0.3)
    level = denoise(x, faces, DenoiseSettings(width=16)).plan.level
    assert level.topology.n_vertices >= PARAMETERS.fewest_to_tell_smooth


@pytest.mark.parametrize("width", [2.0, 16.0])
def test_a_mesh_of_few_vertices_needs_no_level(width):
    x, faces, _ = with_noise(icosphere(2), 2, 0.2)
    result = denoise(x, faces, DenoiseSettings(width=width))
    assert result.plan.level is None
    assert np.isfinite(result.shapes).all()


def test_where_weights_are_0_nothing_moves_and_beside_it_the_noise_goes():
    x, faces, clean = with_noise(icosphere(6), 8, 0.3)
    weights = (clean.positions[:, 2] > 0.7).astype(float)
    result = denoise(x, faces, DenoiseSettings(width=8), weights=weights).positions
    assert np.array_equal(result[weights == 0], x[weights == 0])
    inner = clean.positions[:, 2] > 0.8
    heights = [clean.along_normal(each - clean.positions)[inner] for each in (x, result)]
    before, after = (np.sqrt(np.mean(np.square(each))) for each in heights)
    assert after < 0.7 * before
