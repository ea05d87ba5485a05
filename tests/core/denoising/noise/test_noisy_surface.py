"""Noisy surface: what a camera saw of it, and the unit in which a camera's noise is even."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import TriangleTopology
from adaptive_fairing.core.denoising.noise.contrast import hinges, roughness
from adaptive_fairing.core.denoising.noise.line_of_sight import LEAST_COSINE
from adaptive_fairing.core.denoising.noise.noisy_surface import NoisySurface
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface

GRID, FACES = meshes.flat_grid(30, 30)
TOPOLOGY = TriangleTopology(FACES, len(GRID))
INNER = ~TOPOLOGY.on_boundary


def surface_of(positions, topology=TOPOLOGY):
    return NoisySurface(positions, TriangleSurface(topology, positions))


def depth_image(slope, noise=0.1, seed=0):
    """A plane of a slope, seen along z by a camera with noise; the frame has none."""
    depth = slope * GRID[:, 0]
    clean = np.column_stack([GRID[:, :2], depth])
    heights = np.random.default_rng(seed).normal(0, noise, len(GRID))
    return NoisySurface(clean + np.outer(heights, [0, 0, 1]), TriangleSurface(TOPOLOGY, clean))


@pytest.mark.parametrize("slope", [0.0, 0.5, 2.0])
def test_a_camera_sees_a_plane_at_the_angle_of_its_slope(slope):
    cosines = depth_image(slope).cosines
    np.testing.assert_allclose(cosines, 1 / np.hypot(1, slope), rtol=1e-6)


def test_a_surface_seen_from_the_side_has_the_least_cosine():
    assert depth_image(1e6, noise=10.0).cosines == pytest.approx(LEAST_COSINE)


def test_in_the_unit_of_a_camera_the_spacing_goes_with_the_cosines():
    surface = surface_of(np.column_stack([GRID[:, :2], 0.02 * np.square(GRID[:, 0])]))
    seen = surface.in_unit(np.ones(len(surface.positions), bool))
    ratio = seen.frame.spacing / surface.cosines
    np.testing.assert_allclose(ratio, ratio[0], rtol=1e-12)
    assert np.median(seen.frame.spacing) == pytest.approx(np.median(surface.frame.spacing))
    assert seen.positions is surface.positions
    assert np.array_equal(seen.frame.normals, surface.frame.normals)


def test_noise_of_one_length_is_even_in_one_unit():
    vertices, faces = meshes.graded_sphere(4)
    topology = TriangleTopology(faces, len(vertices))
    frame = TriangleSurface(topology, vertices)
    lengths = 0.05 * np.median(frame.spacing) * np.random.default_rng(0).normal(size=len(vertices))
    surface = NoisySurface(vertices + frame.raised(lengths / frame.spacing), frame)
    unit = surface.in_unit(np.ones(len(vertices), bool)).frame.spacing
    np.testing.assert_allclose(unit, np.median(frame.spacing), rtol=1e-12)


def test_a_surface_that_no_camera_saw_keeps_its_unit():
    vertices, faces = meshes.noisy_ball(3, 0.02)
    surface = surface_of(vertices, TriangleTopology(faces, len(vertices)))
    assert surface.cosines is None
    assert surface.in_unit(np.ones(len(vertices), bool)) is surface


def test_an_object_has_a_back_and_terrain_has_none():
    """A ball has one, with a hole as well; less than half of it has none, and hills have none."""
    vertices, faces = meshes.icosphere(3)
    height = vertices[faces].mean(axis=1)[:, 2]
    for least, is_object in ((-2.0, True), (-0.5, True), (0.1, False)):
        topology = TriangleTopology(faces[height > least], len(vertices))
        assert surface_of(vertices, topology).is_object == is_object
    assert not surface_of(np.column_stack([GRID[:, :2], np.sin(GRID[:, 0])])).is_object


def test_contrasts_are_those_of_the_positions_in_units_of_the_frame():
    surface = depth_image(0.5)
    for name, contrast in (("hinges", hinges), ("roughness", roughness)):
        found, expected = getattr(surface, name), contrast(surface.positions, surface.frame)
        assert np.array_equal(found.value, expected.value)
        assert getattr(surface, name) is found, "computed once"
