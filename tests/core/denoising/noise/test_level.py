"""Level of the noise, estimated from the mesh alone."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import TriangleTopology
from adaptive_fairing.core.denoising.noise.contrast import roughness
from adaptive_fairing.core.denoising.noise.level import has_one_length, scan_level, variance_law
from adaptive_fairing.core.denoising.parameters import PARAMETERS
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface

SPHERE = meshes.graded_sphere(4)


def estimated(vertices, faces, smooth):
    topology = TriangleTopology(faces, len(vertices))
    frame = TriangleSurface(topology, smooth)
    return level_of(vertices, frame, ~topology.on_boundary)


def level_of(vertices, frame, is_counted):
    return model_of(vertices, frame, is_counted).level(frame.spacing)


def model_of(vertices, frame, is_counted):
    rough = roughness(vertices, frame)
    return variance_law(rough, is_counted)


def noisy(amplitude, per_edge=True, seed=0):
    """The graded sphere with noise along its normals; the spacing of the clean one."""
    vertices, faces = SPHERE
    spacing = TriangleSurface(TriangleTopology(faces, len(vertices)), vertices).spacing
    unit = spacing if per_edge else np.full(len(vertices), np.median(spacing))
    normals = vertices / np.linalg.norm(vertices, axis=1, keepdims=True)
    noise = np.random.default_rng(seed).normal(size=len(vertices))
    return vertices + (amplitude * unit * noise)[:, None] * normals, amplitude * unit / spacing


@pytest.mark.parametrize("amplitude", [0.1, 0.2, 0.4])
@pytest.mark.parametrize("per_edge", [True, False], ids=["per edge", "one amplitude"])
def test_known_noise_is_found(amplitude, per_edge):
    ratios = []
    for seed in range(4):
        points, true = noisy(amplitude, per_edge, seed)
        ratios.append(estimated(points, SPHERE[1], SPHERE[0]) / true)
    assert np.median(ratios) == pytest.approx(1, abs=0.06)
    assert np.all(np.abs(np.array(ratios) - 1) < 0.35)


def test_a_clean_surface_has_none_beyond_what_clean_meshes_have():
    found = estimated(*SPHERE, SPHERE[0])
    assert found.max() < PARAMETERS.clean_roughness


def test_a_feature_is_no_noise():
    """A quarter of a sphere, wrinkled in the densest part alone."""
    vertices, faces = SPHERE
    densest = TriangleSurface(TriangleTopology(faces, len(vertices)), vertices).spacing.argsort()
    wrinkled = vertices.copy()
    rough = densest[: len(vertices) // 4]
    wrinkled[rough] *= 1 + 0.01 * np.random.default_rng(3).normal(size=(len(rough), 1))
    assert estimated(wrinkled, faces, vertices).max() < PARAMETERS.clean_roughness


def test_one_quiet_part_does_not_hide_the_noise_of_the_others():
    """The coarsest fifth of a sphere, noisy everywhere else."""
    vertices, faces = SPHERE
    points, true = noisy(0.2)
    spacing = TriangleSurface(TriangleTopology(faces, len(vertices)), vertices).spacing
    quiet = (-spacing).argsort()[: len(vertices) // 5]
    points[quiet] = vertices[quiet] + 0.4 * (points[quiet] - vertices[quiet])
    loud = np.setdiff1d(np.arange(len(vertices)), quiet)
    found = estimated(points, faces, vertices)[loud] / true[loud]
    assert np.median(found) == pytest.approx(1, abs=0.1)


def test_the_unit_does_not_matter():
    points, _ = noisy(0.2)
    found = estimated(points, SPHERE[1], SPHERE[0])
    np.testing.assert_allclose(
        estimated(1e-5 * points, SPHERE[1], 1e-5 * SPHERE[0]), found, rtol=1e-9
    )


def test_only_what_is_counted_is_judged():
    points, _ = noisy(0.2)
    topology = TriangleTopology(SPHERE[1], len(points))
    frame = TriangleSurface(topology, SPHERE[0])
    nothing = level_of(points, frame, np.zeros(len(points), dtype=bool))
    assert not nothing.any()


def jittered_sphere():
    """An even mesh but for some jitter: the local edge lengths differ by 8 % at most places."""
    vertices, faces = meshes.icosphere(5)
    moved = vertices + 0.009 * np.random.default_rng(7).normal(size=vertices.shape)
    return moved / np.linalg.norm(moved, axis=1, keepdims=True), faces


@pytest.mark.parametrize("per_edge", [True, False], ids=["per edge", "one amplitude"])
def test_kinds_of_noise_are_told_apart_even_where_edges_hardly_differ(per_edge):
    """By thousands of vertices that each say very little."""
    vertices, faces = jittered_sphere()
    frame = TriangleSurface(TriangleTopology(faces, len(vertices)), vertices)
    assert 0.05 < np.std(np.log(frame.spacing)) < 0.12
    right = 0
    for seed in range(20):
        heights = 0.2 * np.random.default_rng(seed).normal(size=len(vertices))
        if not per_edge:
            heights *= frame.spacing.mean() / frame.spacing
        everywhere = np.ones(len(vertices), dtype=bool)
        model = model_of(vertices + frame.raised(heights), frame, everywhere)
        own = model.per_length / np.median(frame.spacing) ** 2
        right += (own < 0.2 * model.per_edge) == per_edge
    assert right >= 18


def test_one_amplitude_is_found_at_every_vertex():
    """As a function of each vertex's own edges, not of the mean density around it."""
    vertices, faces = SPHERE
    points, true = noisy(0.2, per_edge=False)
    found = estimated(points, faces, vertices)
    assert np.std(np.log(found / true)) < 0.08
    assert np.std(np.log(true)) > 0.3


@pytest.mark.parametrize("power", [0, 1], ids=["along the normals", "along the line of sight"])
def test_the_noise_of_a_scan_follows_the_angle_or_the_amplitude(power):
    """Of a roof, steep on one side, with the same amplitude along the normals or along z."""
    grid, faces = meshes.flat_grid(70, 70)
    roof = grid + np.maximum(1.5 * (grid[:, :1] - 35), 0) * [0, 0, 1]
    topology = TriangleTopology(faces, len(grid))
    frame = TriangleSurface(topology, roof)
    cosines = frame.normals[:, 2]
    amplitude = 0.2 * cosines**power
    heights = amplitude / cosines * np.random.default_rng(0).normal(size=len(grid))
    rough = roughness(roof + heights[:, None] * [0, 0, 1], frame)
    # The bends at the crease and on the boundary are no noise.
    is_flat = (np.abs(grid[:, 0] - 35) > 3) & ~topology.on_boundary
    found = scan_level(rough, frame, is_flat, cosines)
    expected = amplitude / frame.spacing
    np.testing.assert_allclose(found[is_flat], expected[is_flat], rtol=0.05)


@pytest.mark.parametrize("per_edge", [True, False], ids=["per edge", "one length"])
def test_noise_has_one_length_or_goes_with_the_edges(per_edge):
    points, _ = noisy(0.05, per_edge)
    topology = TriangleTopology(SPHERE[1], len(points))
    rough = roughness(points, TriangleSurface(topology, SPHERE[0]))
    assert has_one_length(rough, ~topology.on_boundary) == (not per_edge)


@pytest.mark.parametrize("power", [-1, 1], ids=["structured light", "along the line of sight"])
@pytest.mark.parametrize("slope", [0.9, 1.5])
def test_what_is_seen_steeply_does_not_tell_that_noise_has_one_length(power, slope):
    """Only the flat half of a roof tells where the other one is steeper than 45 degrees.

    Structured light errs more where it grazes the surface.
    """
    grid, faces = meshes.flat_grid(70, 70)
    roof = grid + np.maximum(slope * (grid[:, :1] - 35), 0) * [0, 0, 1]
    topology = TriangleTopology(faces, len(grid))
    frame = TriangleSurface(topology, roof)
    cosines = frame.normals[:, 2]
    noise = np.random.default_rng(0).normal(size=len(grid))
    heights = 0.02 * cosines ** (power - 1) * noise
    rough = roughness(roof + heights[:, None] * [0, 0, 1], frame)
    is_flat = (np.abs(grid[:, 0] - 35) > 3) & ~topology.on_boundary
    expected = power < 0 and slope < 1
    assert has_one_length(rough, is_flat, cosines) == expected
