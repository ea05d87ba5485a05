"""Debris and loose vertices, which decide nothing for the rest."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import denoise


def noisy_sphere():
    vertices, faces = meshes.icosphere(4)
    noise = 0.015 * np.random.default_rng(0).normal(size=(len(vertices), 1))
    return vertices * (1 + noise), faces


def denoised(debris):
    """The sphere, denoised beside some debris."""
    points, faces = noisy_sphere()
    together = meshes.merged((points, faces), debris)
    return denoise(*together).positions[: len(points)]


@pytest.mark.parametrize("size", [0.01, 0.3])
def test_a_speck_of_debris_does_not_turn_denoise_off(size):
    points, faces = noisy_sphere()
    vertices, triangles = meshes.tetrahedron()
    alone = denoise(points, faces).positions
    beside = denoised((size * vertices + [1.5, 0.4, 0.2], triangles))
    removed = np.linalg.norm(alone - points)
    assert removed > 0
    # The probes follow the principal axes of all vertices, so that some of the mixture may change.
    assert np.linalg.norm(beside - alone) < 0.2 * removed


@pytest.mark.parametrize("place", [(0, 0, 0), (40, -3, 7)])
def test_a_loose_vertex_changes_next_to_nothing(place):
    points, faces = noisy_sphere()
    alone = denoise(points, faces).positions
    beside = denoised((np.array([place], dtype=float), np.zeros((0, 3), np.int32)))
    assert np.linalg.norm(beside - alone) < 1e-3 * np.linalg.norm(alone - points)


def test_crumbs_of_a_clean_model_are_no_noise():
    """Cut-off corners of walls, as a few vertices each, with hardly any noise."""
    generator = np.random.default_rng(0)
    crumb, triangles = meshes.octahedron()
    places = 2 * generator.normal(size=(48, 3))
    crumbs = [(0.02 * crumb + place, triangles) for place in places]
    points, faces = meshes.merged(meshes.icosphere(4), *crumbs)
    points = points + 1e-4 * generator.normal(size=points.shape)
    assert np.array_equal(denoise(points, faces).positions, points)
