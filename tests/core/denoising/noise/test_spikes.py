"""Spikes, taken off before the filters spread them, and normal noise, which is not touched."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import DenoiseSettings, TriangleTopology, denoise
from adaptive_fairing.core.denoising.noise.noisy_surface import NoisySurface
from adaptive_fairing.core.denoising.noise.spikes import (
    is_impulsive,
    left_of_spikes,
    put_back_of,
    spike_law,
    without_spikes,
)
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface

SHAPES = {"sphere": meshes.icosphere(4), "graded": meshes.graded_sphere(4)}


def frame_of(shape):
    vertices, faces = SHAPES[shape]
    return TriangleSurface(TriangleTopology(faces, len(vertices)), vertices)


def with_spikes(shape, below=0.0, seed=0):
    """Heights in local edge lengths: at every fifth vertex far more than at the others."""
    vertices, _ = SHAPES[shape]
    generator = np.random.default_rng(seed)
    is_spike = generator.random(len(vertices)) < 0.2
    heights = np.where(is_spike, 0.45, below) * generator.normal(size=len(vertices))
    return vertices + frame_of(shape).raised(heights)


def are_spikes(shape, heights):
    """For heights (n,) in local edge lengths, with the level that their median tells."""
    frame = frame_of(shape)
    points = SHAPES[shape][0] + frame.raised(heights)
    level = np.full(len(heights), np.median(np.abs(heights)) / 0.6745)
    everywhere = np.ones(len(heights), dtype=bool)
    return is_impulsive(NoisySurface(points, frame), level, everywhere)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("seed", range(10))
def test_normal_noise_is_not_impulsive(shape, seed):
    n = len(SHAPES[shape][0])
    assert not are_spikes(shape, 0.2 * np.random.default_rng(seed).normal(size=n))


@pytest.mark.parametrize("shape", SHAPES)
def test_heavy_tails_are_told_from_normal_noise(shape):
    """One vertex in ten has three times the standard deviation of the others."""
    found = []
    for seed in range(10):
        generator = np.random.default_rng(seed)
        n = len(SHAPES[shape][0])
        scale = np.where(generator.random(n) < 0.1, 0.6, 0.2)
        found.append(are_spikes(shape, scale * generator.normal(size=n)))
    # A few thousand vertices may look calm by chance.
    assert np.count_nonzero(found) >= 9


@pytest.mark.parametrize("shape", SHAPES)
def test_spikes_come_off_and_the_others_stay(shape):
    vertices, _ = SHAPES[shape]
    frame = frame_of(shape)
    points = with_spikes(shape)
    everywhere = np.ones(len(points), dtype=bool)
    calm, _ = without_spikes(NoisySurface(points, frame), everywhere, everywhere)
    before = np.linalg.norm(points - vertices, axis=1) / frame.spacing
    after = np.linalg.norm(calm - vertices, axis=1) / frame.spacing
    assert np.sqrt(np.mean(after**2)) < 0.45 * np.sqrt(np.mean(before**2))
    assert np.mean(after > 0.25) < 0.05
    moved = (calm != points).any(axis=1)
    assert np.mean(moved[before < 0.01]) < 0.05


@pytest.mark.parametrize("height", [-0.6, 0.6])
def test_creases_stay_beside_a_spike(height):
    """Vertices of a crease stand out beside one, and then those beside them, to the corners."""
    vertices, faces = meshes.cube(4)
    frame = TriangleSurface(TriangleTopology(faces, len(vertices)), vertices)
    everywhere = np.ones(len(vertices), dtype=bool)
    on_crease = np.flatnonzero(np.isclose(np.abs(vertices), 1).sum(axis=1) == 2)
    others = []
    for spike in on_crease[::9]:
        points = vertices + frame.raised(np.where(np.arange(len(vertices)) == spike, height, 0))
        calm, _ = without_spikes(NoisySurface(points, frame), everywhere, everywhere)
        off = np.linalg.norm(calm - vertices, axis=1) / frame.spacing
        others.append(np.count_nonzero(np.delete(off, spike) > 0.1))
    assert np.mean(others) < 10


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("below", [0.01, 0.02])
def test_no_spike_survives(shape, below):
    vertices, faces = SHAPES[shape]
    frame = frame_of(shape)
    points = with_spikes(shape, below=below)
    result = denoise(points, faces)
    assert result.plan.impulsive.max() > 0.8
    assert any("impulsive" in note for note in result.notes)
    assert result.other_readings == ()  # "denoise anyway" would be odd beside that note
    left = np.linalg.norm(result.positions - vertices, axis=1) / frame.spacing
    assert np.mean(left > 0.25) < 0.03
    assert np.sqrt(np.mean(left**2)) < 0.1


def test_spikes_of_a_boundary_come_off_too():
    vertices, faces = meshes.flat_grid(40, 40)
    topology = TriangleTopology(faces, len(vertices))
    generator = np.random.default_rng(0)
    heights = np.where(generator.random(len(vertices)) < 0.2, 0.45, 0.01)
    points = vertices + np.outer(heights * generator.normal(size=len(vertices)), [0, 0, 1])
    result = denoise(points, faces, DenoiseSettings(boundary="free"))
    edge = topology.on_boundary
    left, before = (np.sqrt(np.mean(each[edge, 2] ** 2)) for each in (result.positions, points))
    assert left < 0.4 * before


def put_back(points, frame):
    everywhere = np.ones(len(points), dtype=bool)
    positions, spikes = without_spikes(NoisySurface(points, frame), everywhere, everywhere)
    return frame.along_normal(points - positions), spikes


def test_a_vertex_that_rises_out_of_the_noise_becomes_a_spike_gradually():
    vertices, _ = SHAPES["sphere"]
    frame, noise = frame_of("sphere"), 0.05 * np.random.default_rng(0).normal(size=len(vertices))
    middle, heights = 1000, np.linspace(0, 1, 401)
    moved, spikes = [], []
    for height in heights:
        noise[middle] = height
        back, part = put_back(vertices + frame.raised(noise), frame)
        moved.append(back[middle])
        spikes.append(part[middle])
    assert spikes[0] == 0 and spikes[-1] == 1
    assert np.any((np.array(spikes) > 0.25) & (np.array(spikes) < 0.75))
    assert moved[0] == 0 and moved[-1] == pytest.approx(1, abs=0.2)
    assert np.abs(np.diff(moved)).max() < 0.1


def test_of_two_neighbours_that_stand_out_alike_rounding_does_not_choose_one():
    vertices, faces = SHAPES["sphere"]
    frame, noise = frame_of("sphere"), 0.05 * np.random.default_rng(0).normal(size=len(vertices))
    first, second = faces[1000, :2]
    results = []
    for higher, lower in ((first, second), (second, first)):
        noise[higher], noise[lower] = 0.8 + 1e-9, 0.8 - 1e-9
        results.append(put_back(vertices + frame.raised(noise), frame)[0])
    assert np.abs(results[0] - results[1]).max() < 1e-6
    assert results[0][[first, second]] == pytest.approx(0.8, abs=0.2)


def test_other_frames_lose_their_spikes_too():
    vertices, faces = SHAPES["sphere"]
    frame = frame_of("sphere")
    plan = denoise(with_spikes("sphere", below=0.02), faces).plan
    result = denoise(with_spikes("sphere", below=0.02, seed=1), faces, plan=plan)
    left = np.linalg.norm(result.positions - vertices, axis=1) / frame.spacing
    assert np.sqrt(np.mean(left**2)) < 0.1


@pytest.mark.parametrize("shape", SHAPES)
def test_normal_noise_is_denoised_as_before(shape):
    vertices, faces = SHAPES[shape]
    frame = frame_of(shape)
    heights = 0.2 * np.random.default_rng(2).normal(size=len(vertices))
    assert not denoise(vertices + frame.raised(heights), faces).plan.impulsive.any()


def test_steps_of_voxels_are_no_spikes():
    """Heights in whole steps, averaged twice with the neighbours', as contours are."""
    frame = frame_of("sphere")
    vertices, faces = SHAPES["sphere"]
    steps = np.random.default_rng(0).choice([-2.0, 0.0, 0.0, 2.0], len(vertices))
    points = vertices + frame.raised(frame.spread(steps, 2))
    assert not denoise(points, faces).plan.impulsive.any()


@pytest.mark.parametrize("least", [0.05, 0.2, 0.4])
@pytest.mark.parametrize("part", [0.1, 0.5])
def test_the_law_of_spikes_is_found_from_the_high_ones(least, part):
    generator = np.random.default_rng(1)
    n = 40_000
    moved = np.abs((generator.random(n) < part) * generator.normal(0, 0.3, n))
    size, found = spike_law(moved, moved > least)
    assert size == pytest.approx(0.3, rel=0.1)
    assert found == pytest.approx(part, rel=0.15)


def test_where_no_spike_was_there_is_no_law():
    assert spike_law(np.zeros(10), np.zeros(10)) == (0, 0)


@pytest.mark.parametrize("moved", [[0.3], [0.3, 0.3, 0.3], [1e-300, 1e-9, 5.0]])
def test_spikes_of_any_sizes_have_a_law(moved):
    """Spikes of one size have no tail that a normal distribution would explain."""
    moved = np.array([*moved, 0, 0, 0, 0])
    size, part = spike_law(moved, moved > 0)
    assert np.isfinite(size) and 0 <= size and 0 < part <= 1


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("part", [0.2, 0.4])
def test_what_is_left_of_spikes_is_as_large_as_it_really_is(shape, part):
    """The median of what is left is less than half of its root mean square."""
    vertices, _ = SHAPES[shape]
    frame, n = frame_of(shape), len(vertices)
    everywhere, ratios = np.ones(n, dtype=bool), []
    for seed in range(4):
        generator = np.random.default_rng(seed)
        heights = (generator.random(n) < part) * generator.normal(0, 0.3, n)
        noisy = NoisySurface(vertices + frame.raised(heights), frame)
        positions, spikes = without_spikes(noisy, everywhere, everywhere)
        calm = NoisySurface(positions, frame, noisy.own)
        moved = frame.along_normal(noisy.positions - calm.positions)
        none = put_back_of(np.zeros(n), calm, everywhere, everywhere)
        _, more = left_of_spikes(calm, moved, spikes, none, everywhere, everywhere)
        true = frame.along_normal(calm.positions - vertices)
        ratios.append(np.sqrt(more) / np.std(true))
        assert np.median(np.abs(true)) < 0.5 * np.std(true)
    # Of one of them it is uncertain by a quarter: few spikes are as large as the largest.
    assert np.mean(ratios) == pytest.approx(1, abs=0.2)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("part", [0.2, 0.4, 0.6])
def test_the_filters_remove_what_is_left_of_spikes(shape, part):
    vertices, faces = SHAPES[shape]
    frame, n = frame_of(shape), len(vertices)
    generator = np.random.default_rng(3)
    heights = (generator.random(n) < part) * generator.normal(0, 0.3, n)
    result = denoise(vertices + frame.raised(heights), faces)
    error = np.std(frame.along_normal(result.positions - vertices))
    assert error < 0.35 * np.std(heights)
