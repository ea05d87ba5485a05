"""Curvature of the limit surface on shapes whose curvature is known."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import LimitSurface, TriangleTopology
from adaptive_fairing.core.surface.curvature import regular_curvature


def surface_of(mesh):
    return LimitSurface(TriangleTopology(mesh[1], len(mesh[0])), mesh[0])


def orders(errors):
    """Powers of the spacing, from errors at halved spacings."""
    return np.log2(np.array(errors[:-1]) / errors[1:])


def torus_errors(n):
    """Largest errors of H and K on a torus of 2n by n vertices, all of them regular."""
    surface = surface_of(meshes.torus(2 * n, n))
    angle = 2 * np.pi * np.arange(n) / n
    distance = 2 + np.cos(angle)
    mean = np.tile((1 + np.cos(angle) / distance) / 2, 2 * n)
    gaussian = np.tile(np.cos(angle) / distance, 2 * n)
    return (
        np.abs(surface.mean_curvature - mean).max(),
        np.abs(surface.gaussian_curvature - gaussian).max(),
    )


def sphere_errors(n):
    """Largest errors of H and K between 45° north and south, where the grid is regular."""
    vertices, faces = meshes.latlong_sphere(2 * n, n - 1)
    surface = surface_of((vertices, faces))
    middle = np.abs(vertices[:, 2]) < np.sqrt(0.5)
    return (
        np.abs(surface.mean_curvature[middle] - 1).max(),
        np.abs(surface.gaussian_curvature[middle] - 1).max(),
    )


@pytest.mark.parametrize("errors_at", [torus_errors, sphere_errors])
def test_second_order(errors_at):
    errors = np.array([errors_at(n) for n in (16, 32, 64, 128)])
    for column in errors.T:
        assert orders(column)[-1] == pytest.approx(2, abs=0.05)


def test_boundary_is_one_sided():
    """A strip of a cylinder, open at both ends: H = 1/2, K = 0, of the second order there too."""
    errors = []
    for n in (16, 32, 64):
        vertices, faces = meshes.open_cylinder(n, n // 4)
        surface = surface_of((vertices, faces))
        assert np.isfinite(surface.mean_curvature).all()
        errors.append(np.abs(surface.mean_curvature - 1 / 2).max())
        assert np.abs(surface.gaussian_curvature).max() < 1e-10
    assert orders(errors)[-1] == pytest.approx(2, abs=0.1)


def difference_errors(surface, level):
    """Errors of H against second differences of the surface around every fourth vertex."""
    refined, fine = surface.refined(level), surface.levels.mesh(level)
    errors = []
    for v in range(0, len(surface.positions), 4):
        ring = fine.ring[fine.ring_start[v] : fine.ring_start[v + 1]]
        normal = refined.normals[v]
        along = np.linalg.svd(normal[None])[2][1:]
        points = refined.vertices[ring] - refined.vertices[v]
        x, y = along @ points[:3].T
        height = points @ normal
        bend = np.linalg.solve(np.stack([x * x, 2 * x * y, y * y], axis=1), height[:3] + height[3:])
        errors.append(surface.mean_curvature[v] + (bend[0] + bend[2]) / 2)
    return np.array(errors)


def test_limit_of_differences():
    """A box spline has no third derivative at vertices, so differences are of the first order."""
    surface = surface_of(meshes.torus(7, 5))
    errors = [difference_errors(surface, level) for level in (4, 5, 6)]
    largest = [np.abs(error).max() for error in errors]
    assert orders(largest)[-1] == pytest.approx(1, abs=0.05)
    assert np.abs(2 * errors[2] - errors[1]).max() < largest[2] / 20


@pytest.mark.parametrize("valence", [3, 4, 5, 7, 9, 20])
def test_extraordinary_vertices_are_bounded_by_their_surroundings(valence):
    """A pole of a sphere: the mean of the exact values half-way to its neighbours."""
    vertices, faces = meshes.latlong_sphere(valence, 4)
    surface = surface_of((vertices, faces))
    north = len(vertices) - 2
    finer = surface.levels.control_points(vertices, 1)[-1]
    half_way = len(vertices) + np.flatnonzero((surface.levels.mesh(0).edges == north).any(axis=1))
    fine = LimitSurface(TriangleTopology(surface.refined(1).triangles, len(finer)), finer)
    assert surface.mean_curvature[north] == pytest.approx(fine.mean_curvature[half_way].mean())
    assert surface.gaussian_curvature[north] == pytest.approx(
        fine.gaussian_curvature[half_way].mean()
    )


@pytest.mark.parametrize("mesh", [meshes.random_closed(2), meshes.bumpy_disc(0)])
def test_refined_vertices_have_the_curvature_of_their_points(mesh):
    """A point's curvature is the same on every level, and extraordinary vertices have some."""
    surface = surface_of(mesh)
    control = surface.levels.control_points(surface.positions, 2)
    for level in (1, 2):
        found = surface.refined_curvature(level)
        assert found.shape == (2, len(surface.refined(level).vertices))
        assert np.isfinite(found).all()
        exact = regular_curvature(surface.levels.mesh(level - 1), control[level - 1])
        known = np.flatnonzero(np.isfinite(exact[0]))
        assert 0 < len(known) < exact.shape[1]
        scale = np.abs(exact[:, known]).max()
        np.testing.assert_allclose(found[:, known], exact[:, known], atol=1e-10 * scale)
        finer = surface.levels.mesh(level)
        for v in np.flatnonzero(np.isnan(regular_curvature(finer, control[level])[0])):
            ring = finer.ring[finer.ring_start[v] : finer.ring_start[v + 1]]
            np.testing.assert_allclose(found[:, v], found[:, ring].mean(axis=1))


def test_scale_and_orientation():
    vertices, faces = meshes.random_closed(2)
    surface, large = surface_of((vertices, faces)), surface_of((10 * vertices, faces))
    np.testing.assert_allclose(large.mean_curvature, surface.mean_curvature / 10, rtol=1e-9)
    np.testing.assert_allclose(
        large.gaussian_curvature, surface.gaussian_curvature / 100, rtol=1e-9
    )
    inside_out = surface_of((vertices, faces[:, ::-1]))
    np.testing.assert_allclose(inside_out.mean_curvature, -surface.mean_curvature, rtol=1e-9)


def test_flat_and_degenerate():
    surface = surface_of(meshes.flat_grid(4, 5))
    assert np.abs(surface.mean_curvature).max() == 0
    assert np.abs(surface.gaussian_curvature).max() == 0
    vertices, faces = meshes.octahedron()
    assert np.isnan(surface_of((0 * vertices, faces)).mean_curvature).all()
