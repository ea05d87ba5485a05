"""Noise of a given width: its level from the contrasts that see it best."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import TriangleTopology
from adaptive_fairing.core.denoising.noise.contrast import hinges
from adaptive_fairing.core.denoising.noise.given_width import passes_of_width
from adaptive_fairing.core.denoising.noise_verdict import IMPULSIVE, noise_verdict
from adaptive_fairing.core.denoising.stage import Stage
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface

SHAPES = {"round": meshes.icosphere(4), "flat": meshes.flat_grid(50, 50)}


def surface_of(vertices, faces):
    return TriangleSurface(TriangleTopology(faces, len(vertices)), vertices)


def with_noise(surface, width, level, seed=0):
    """Positions with noise of a width and a level, (n, 3)."""
    white = np.random.default_rng(seed).normal(size=len(surface.positions))
    heights = surface.spread(white, passes_of_width(width))
    return surface.positions + surface.raised(level * heights / heights.std())


def verdict(surface, positions, width):
    still = np.zeros(len(positions), dtype=bool)
    stage = Stage(surface.topology, positions, still, lambda report: None)
    return noise_verdict(stage, "keep", width)


def found(surface, positions, width):
    """Level where it was judged."""
    judged = verdict(surface, positions, width)
    return np.median(judged.level[judged.stage.parts.is_counted])


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("width", [1, 2, 3])
def test_the_level_is_that_of_the_noise(shape, width):
    surface = surface_of(*SHAPES[shape])
    for level in (0.1, 0.3):
        points = with_noise(surface, width, level)
        assert found(surface, points, width) == pytest.approx(level, rel=0.35)


@pytest.mark.parametrize(("depth", "waves"), [(0.1, 6), (0.2, 5)])
def test_weak_noise_is_not_lost_under_the_bends_of_the_shape(depth, waves):
    """Both bands have more of the shape than of the noise."""
    vertices, faces = meshes.icosphere(5)
    x, y, z = (waves * vertices).T
    lumps = 1 + depth * np.sin(x) * np.sin(y + 1) * np.cos(z)
    surface = surface_of(lumps[:, None] * vertices, faces)
    assert found(surface, with_noise(surface, 4, 0.1), 4) == pytest.approx(0.1, rel=0.35)


@pytest.mark.parametrize("edges", [4, 5, 8])
def test_detail_on_most_of_a_surface_is_no_noise(edges):
    """The level is read where the surface is quiet: two thirds of it have waves of some edges."""
    surface = surface_of(*meshes.flat_grid(90, 90))
    edge, x = surface.spacing.mean(), surface.positions[:, 0]
    waves = np.where(x > x.max() / 3, edge / 2 * np.sin(2 * np.pi / edges * x), 0)
    points = with_noise(surface, 2, 0.1) + np.outer(waves, [0, 0, 1])
    assert found(surface, points, 2) == pytest.approx(0.1, rel=0.35)


def test_noise_of_a_camera_is_even_along_its_rays():
    """It is as strong in depth everywhere, so on a steep slope it is less across the surface."""
    surface = surface_of(*meshes.flat_grid(60, 60))
    x, y = surface.positions[:, :2].T
    clean = np.column_stack([x, y, 0.02 * (x**2 + y**2)])
    white = np.random.default_rng(0).normal(size=len(x))
    depths = surface.spread(white, passes_of_width(2))
    points = clean + np.outer(0.2 * depths / depths.std(), [0, 0, 1])
    judged = verdict(surface_of(clean, surface.topology.triangles), points, 2)
    seen, frame = judged.stage.noisy.cosines, judged.stage.frame
    counted = judged.stage.parts.is_counted
    depth = (judged.level * frame.spacing / seen)[counted]
    np.testing.assert_allclose(depth, 0.2, rtol=0.35)


def test_the_unit_does_not_matter():
    surface = surface_of(*SHAPES["round"])
    points = with_noise(surface, 2, 0.2)
    large = surface_of(1e3 * surface.positions + 5, surface.topology.triangles)
    expected = found(surface, points, 2)
    assert found(large, 1e3 * points + 5, 2) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("side", [12, 50])
def test_a_plane_has_none(side):
    """Flat faces tell it on the large one, the bands alone on the small one."""
    surface = surface_of(*meshes.flat_grid(side, side))
    assert found(surface, surface.positions, 2) == 0


def test_rounded_depths_hide_no_noise():
    surface = surface_of(*SHAPES["flat"])
    points = with_noise(surface, 2, 0.2)
    step = 0.12 * surface.spacing.mean()
    points[:, 2] = np.round(points[:, 2] / step) * step
    assert np.mean(hinges(points, surface).value < 1e-9) > 0.3
    assert found(surface, points, 2) == pytest.approx(0.2, rel=0.35)


def test_the_verdict_has_the_correlation_of_the_width():
    surface = surface_of(*SHAPES["round"])
    judged = verdict(surface, with_noise(surface, 2, 0.2), 2)
    white = np.random.default_rng(1).normal(size=len(surface.positions))
    applied = judged.correlation.applied(white, surface)
    assert applied.std() == pytest.approx(judged.correlation.deviation, rel=0.1)
    assert judged.correlation.passes == passes_of_width(2)
    assert not judged.impulsive.any()
    assert judged.notes == ()


def test_passes_give_the_width_they_are_for():
    surface = surface_of(*meshes.torus(120, 120, 1.0, 1.0 - 1e-3))
    impulse = np.zeros(len(surface.positions))
    impulse[0] = 1
    for width in (2, 4, 8):
        kernel = surface.spread(impulse, passes_of_width(width))
        alike = surface.spread(kernel, passes_of_width(width))
        # Along a row of the grid: neighbours lie one edge apart.
        assert alike[width] / alike[0] == pytest.approx(np.exp(-1), abs=0.12)


@pytest.mark.parametrize("width", [1, 3])
def test_besides_noise_of_a_given_width_spikes_are_put_back(width):
    surface = surface_of(*SHAPES["round"])
    generator = np.random.default_rng(2)
    heights = generator.normal(size=len(surface.positions))
    heights[generator.random(len(heights)) > 0.1] = 0
    judged = verdict(surface, with_noise(surface, width, 0.1) + surface.raised(heights), width)
    assert judged.impulsive.any()
    assert judged.notes == (IMPULSIVE,)
    left = surface.along_normal(judged.stage.noisy.positions - surface.positions)
    assert left.std() < 0.6 * np.hypot(0.1, heights.std())
    assert np.median(judged.level) == pytest.approx(0.1, rel=0.5)


def test_white_noise_that_is_found_anyway_is_as_it_was_found():
    surface = surface_of(*SHAPES["round"])
    points = with_noise(surface, 1, 0.2)
    told, by_itself = verdict(surface, points, 1), verdict(surface, points, None)
    assert np.array_equal(told.level, by_itself.level)
    assert told.correlation == by_itself.correlation
