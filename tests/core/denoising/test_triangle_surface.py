"""Measures of a triangle surface: edge lengths, normals, heights, creases."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import TriangleTopology
from adaptive_fairing.core.denoising.parameters import PARAMETERS
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface


def surface_of(points, faces):
    return TriangleSurface(TriangleTopology(faces, len(points)), points)


def test_spacing_is_the_mean_distance_to_the_neighbours():
    points, faces = meshes.random_closed(3)
    spacing = surface_of(points, faces).spacing
    for vertex in range(len(points)):
        ring = np.setdiff1d(faces[(faces == vertex).any(axis=1)], [vertex])
        lengths = np.linalg.norm(points[ring] - points[vertex], axis=1)
        assert spacing[vertex] == pytest.approx(lengths.mean(), rel=1e-12)


def test_spacing_is_never_0():
    """Beside a sphere: one that is a single point, and a vertex without triangles."""
    points, faces = meshes.merged(meshes.icosphere(2), (np.zeros((12, 3)), meshes.icosahedron()[1]))
    surface = surface_of(np.vstack([points, np.full((1, 3), 9.0)]), faces)
    for spacing in (surface.spacing, surface.smooth_spacing):
        assert spacing[-1] == 1
        assert 0 < spacing[-13:-1].max() < 1e-6 * spacing[:-13].min()
    assert (surface_of(0 * points, faces).spacing == 1).all()


def test_heights_along_the_normals_are_in_local_edge_lengths():
    surface = surface_of(*meshes.graded_sphere(3))
    heights = np.random.default_rng(0).normal(size=len(surface.positions))
    raised = surface.raised(heights)
    np.testing.assert_allclose(surface.along_normal(raised), heights, rtol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(raised, axis=1), np.abs(heights) * surface.spacing)


def test_a_vertex_rises_over_the_mean_of_its_neighbours():
    surface = surface_of(*meshes.flat_grid(9, 9))
    inside = ~surface.topology.on_boundary
    heights = np.random.default_rng(0).normal(size=len(inside)) * inside
    bumpy = surface.positions + heights[:, None] * [0, 0, 1]
    expected = (heights - surface.mean @ heights) / surface.spacing
    np.testing.assert_allclose(surface.rises(bumpy)[inside], expected[inside], atol=1e-12)
    # A step of averaging goes half of the way there.
    np.testing.assert_allclose(surface.spread(heights, 1), (heights + surface.mean @ heights) / 2)
    assert surface.spread(heights, 2).std() < surface.spread(heights, 1).std()


@pytest.mark.parametrize("turn", [-0.1, 0.1])
def test_creases_are_the_edges_where_triangles_meet_at_an_angle(turn):
    """A sheet that is folded along its middle row of 8 edges."""
    points, faces = meshes.flat_grid(8, 8)
    angle = PARAMETERS.short_fit_angle + turn
    middle = points[:, 1].max() / 2
    way = np.maximum(points[:, 1] - middle, 0)
    points[:, 1] -= way * (1 - np.cos(angle))
    points[:, 2] = way * np.sin(angle)
    surface = surface_of(points, faces)
    n_inner = (3 * len(faces) - 4 * 8) / 2
    assert surface.crease_part == pytest.approx(8 / n_inner if turn > 0 else 0)


def test_one_triangle_has_no_inner_edge():
    assert surface_of(*meshes.single_triangle()).crease_part == 0
