"""Metric of the diffusion: mesh, surface and bending."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import TriangleTopology
from adaptive_fairing.core.denoising.lifted_metric import (
    LiftedMetric,
    boundary_flux,
    linear_elements,
    squared_edges,
)
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface
from adaptive_fairing.core.linalg.edge_matrix import EdgePattern

BUMPY = meshes.random_closed(2)


def matrices(metric, vertices, faces, spacing=None):
    surface = TriangleSurface(TriangleTopology(faces, len(vertices)), vertices)
    surface.smooth_spacing = np.ones(len(vertices)) if spacing is None else spacing
    both = linear_elements(EdgePattern(surface.topology), metric.lengths(surface))
    return [matrix.full() for matrix in both]


def largest_difference(a, b):
    return abs(a - b).max() / abs(b).max()


def area(vertices, faces):
    a, b, c = vertices[faces].swapaxes(0, 1)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


def test_mass_adds_up_to_the_area_and_its_rows_to_a_third_of_the_triangles_around():
    vertices, faces = BUMPY
    mass, _ = matrices(LiftedMetric(surface_fraction=1), vertices, faces)
    assert mass.sum() == pytest.approx(area(vertices, faces), rel=1e-12)
    for vertex, row in enumerate(mass.sum(axis=1)):
        around = faces[(faces == vertex).any(axis=1)]
        assert row == pytest.approx(area(vertices, around) / 3, rel=1e-12)


def test_the_energy_of_a_linear_function_is_its_slope_times_the_area():
    vertices, faces = meshes.flat_grid(7, 5)
    rng = np.random.default_rng(0)
    vertices[:, :2] += rng.uniform(-0.2, 0.2, (len(vertices), 2))
    _, stiffness = matrices(LiftedMetric(surface_fraction=1), vertices, faces)
    slope = np.array([0.3, -2.0])
    values = vertices[:, :2] @ slope
    assert values @ (stiffness @ values) == pytest.approx(slope @ slope * area(vertices, faces))


def test_the_area_has_the_gradient_that_the_stiffness_matrix_gives():
    """∂A / ∂x = L x, for a closed surface: the cotangent formula."""
    vertices, faces = BUMPY
    _, stiffness = matrices(LiftedMetric(surface_fraction=1), vertices, faces)
    move = np.random.default_rng(3).normal(size=vertices.shape)
    step = 1e-5
    change = area(vertices + step * move, faces) - area(vertices - step * move, faces)
    assert np.vdot(move, stiffness @ vertices) == pytest.approx(change / (2 * step), rel=1e-6)


def test_triangles_that_have_collapsed_to_a_point_leave_a_mass_in_single_precision():
    """As rounded coordinates leave them: all triangles around a vertex may have."""
    vertices, faces = meshes.icosphere(2)
    around = np.unique(faces[(faces == 20).any(axis=1)])
    vertices[around] = vertices[20]
    surface = TriangleSurface(TriangleTopology(faces, len(vertices)), vertices)
    squares = LiftedMetric(surface_fraction=1).lengths(surface)
    for matrix in linear_elements(EdgePattern(surface.topology), squares):
        single = matrix.in_precision(np.float32)
        assert (single.diagonal() > 0).all()
        assert single.is_finite()


def test_lengths_from_the_mesh_alone_do_not_see_the_surface():
    vertices, faces = BUMPY
    moved = vertices + np.random.default_rng(0).normal(size=vertices.shape)
    before, after = (matrices(LiftedMetric(), points, faces) for points in (vertices, moved))
    for a, b in zip(before, after, strict=True):
        assert (a != b).nnz == 0


def test_a_triangle_of_the_mesh_is_equilateral_with_unit_edges():
    vertices, faces = BUMPY
    mass, stiffness = matrices(LiftedMetric(), vertices, faces)
    assert mass.sum() == pytest.approx(len(faces) * np.sqrt(3) / 4, rel=1e-12)
    assert abs(stiffness.sum(axis=1)).max() < 1e-12 * abs(stiffness).max()


@pytest.mark.parametrize("metric", [LiftedMetric(1, 0.3), LiftedMetric(0, 0.1)])
def test_size_and_place_do_not_matter(metric):
    vertices, faces = BUMPY
    spacing = np.random.default_rng(1).uniform(0.5, 2, len(vertices))
    turn, _ = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    moved = 7.5 * vertices @ turn.T + [3, -2, 1]
    before = matrices(metric, vertices, faces, spacing)
    after = matrices(metric, moved, faces, 7.5 * spacing)
    for a, b in zip(before, after, strict=True):
        assert largest_difference(a, b) < 1e-9


def test_on_a_sphere_bending_enlarges_all_lengths_alike():
    """III = g / r², and the stiffness matrix in two dimensions does not depend on the scale."""
    radius, angle = 2.0, 0.25
    vertices, faces = meshes.icosphere(4)
    flat_mass, flat_stiffness = matrices(LiftedMetric(1), radius * vertices, faces)
    mass, stiffness = matrices(LiftedMetric(1, angle), radius * vertices, faces)
    factor = 1 + 1 / (angle * radius) ** 2
    x = vertices[:, 0]
    assert x @ (mass @ x) == pytest.approx(factor * (x @ (flat_mass @ x)), rel=5e-3)
    assert x @ (stiffness @ x) == pytest.approx(x @ (flat_stiffness @ x), rel=5e-3)


def test_along_a_cylinder_distances_stay_and_around_it_they_grow():
    """∫ ∇f · ∇f for f = z and f = x: only the second one crosses the bending."""
    vertices, faces = meshes.open_cylinder(96, 48)
    angle = 0.5
    factor = np.sqrt(1 + 1 / angle**2)
    flat_mass, flat = matrices(LiftedMetric(1), vertices, faces)
    mass, lifted = matrices(LiftedMetric(1, angle), vertices, faces)
    x, _, z = vertices.T
    assert mass.sum() == pytest.approx(factor * flat_mass.sum(), rel=0.01)
    assert z @ (lifted @ z) == pytest.approx(factor * (z @ (flat @ z)), rel=0.01)
    # The normals on the boundary are those of one side: an error of the first order.
    assert x @ (lifted @ x) == pytest.approx((x @ (flat @ x)) / factor, rel=0.015)


def test_less_the_flux_through_its_boundary_a_plane_has_no_bending():
    vertices, faces = meshes.flat_grid(7, 5)
    vertices[:, :2] += np.random.default_rng(0).uniform(-0.2, 0.2, (len(vertices), 2))
    surface = TriangleSurface(TriangleTopology(faces, len(vertices)), vertices)
    squares = squared_edges(faces, vertices)
    _, stiffness = linear_elements(EdgePattern(surface.topology), squares)
    bending, flux = stiffness.product(vertices.T).T, boundary_flux(surface, squares)
    assert abs(bending).max() > 0.1
    assert abs(bending - flux).max() < 1e-13
