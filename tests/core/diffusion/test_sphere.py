"""Convergence to what is known exactly on spheres and tori, with the observed orders.

The control meshes interpolate: their limit surfaces pass through points of the exact surface.
"""

from functools import lru_cache

import numpy as np
import pytest
from scipy.sparse.linalg import eigsh
from support import meshes
from support.reference import (
    interpolating_control_points,
    limit_matrix,
    linear_mass_matrix,
    linear_stiffness_matrix,
)

from adaptive_fairing.core import FairingSettings, LoopSpace, TriangleTopology, fair

LEVELS = (2, 3, 4)  # icospheres of 320, 1280 and 5120 triangles


@lru_cache
def sphere(level):
    """Control points, faces and Loop space of the unit sphere."""
    vertices, faces = meshes.icosphere(level)
    control = interpolating_control_points(vertices, faces)
    return control, faces, LoopSpace(TriangleTopology(faces, len(vertices)))


def orders(errors):
    """Observed orders between meshes whose edges halve."""
    errors = np.abs(np.asarray(errors))
    return np.log2(errors[:-1] / errors[1:])


def test_area_and_volume_of_the_sphere_converge_with_order_2_5():
    measures = [space.measures(control) for control, _, space in map(sphere, LEVELS)]
    for values, exact in (
        ([m.area for m in measures], 4 * np.pi),
        ([m.volume for m in measures], 4 * np.pi / 3),
    ):
        errors = np.array(values) / exact - 1
        assert abs(errors[-1]) < 1e-5
        assert (orders(errors) > 2.5).all()


def test_curvature_energy_of_the_sphere_converges_to_4_pi():
    """With order one: at the twelve vertices of valence 5 the Loop basis lacks quadratics.

    Where all vertices are regular the order is four, see the torus.
    """
    energies = [
        space.measures(control).curvature_energy for control, _, space in map(sphere, LEVELS)
    ]
    errors = np.array(energies) / (4 * np.pi) - 1
    assert abs(errors[-1]) < 3e-3
    assert (orders(errors) > 1).all()


@pytest.mark.parametrize("radius", [0.001, 1.0, 1000.0])
def test_curvature_energy_has_no_unit(radius):
    control, _, space = sphere(3)
    energy = space.measures(control).curvature_energy
    assert space.measures(radius * control).curvature_energy == pytest.approx(energy, rel=1e-10)


def test_measures_of_a_torus_converge_with_order_4():
    """Area 4 pi^2 R r, volume 2 pi^2 R r^2, curvature energy pi^2 R^2 / (r sqrt(R^2 - r^2))."""
    errors = []
    for n in (8, 16, 32):
        vertices, faces = meshes.torus(2 * n, n, major=2, minor=1)
        control = interpolating_control_points(vertices, faces)
        measures = LoopSpace(TriangleTopology(faces, len(vertices))).measures(control)
        errors.append(
            [
                measures.area / (8 * np.pi**2) - 1,
                measures.volume / (4 * np.pi**2) - 1,
                measures.curvature_energy / (4 * np.pi**2 / np.sqrt(3)) - 1,
            ]
        )
    assert np.abs(errors[-1]).max() < 1e-5
    assert (orders(errors) > 3.9).all()


def smallest_eigenvalues(stiffness, mass):
    """The first 16 eigenvalues, which on the unit sphere are l (l + 1) for l = 0 ... 3."""
    # A small Krylov space from a random start can miss one of several equal eigenvalues.
    start = np.random.default_rng(0).standard_normal(mass.shape[0])
    values = eigsh(stiffness, k=16, M=mass, sigma=-0.1, v0=start, ncv=80, return_eigenvectors=False)
    return np.sort(values)


def test_eigenvalues_of_the_sphere_beside_linear_elements():
    """Order three against two, and at 2562 vertices 80 times and more closer to l (l + 1)."""
    degree = np.repeat([0, 1, 2, 3], [1, 3, 5, 7])
    exact = degree * (degree + 1)
    loop_errors, linear_errors = [], []
    for level in LEVELS:
        control, faces, space = sphere(level)
        loop = smallest_eigenvalues(space.stiffness_matrix(control), space.mass_matrix(control))
        vertices = meshes.icosphere(level)[0]
        linear = smallest_eigenvalues(
            linear_stiffness_matrix(vertices, faces), linear_mass_matrix(vertices, faces)
        )
        for values, errors in ((loop, loop_errors), (linear, linear_errors)):
            assert abs(values[0]) < 1e-8
            errors.append([np.abs(values - exact)[degree == k].max() for k in (1, 2, 3)])
    loop_errors, linear_errors = np.array(loop_errors), np.array(linear_errors)
    assert (loop_errors[-1] < [5e-5, 2e-4, 5e-4]).all()
    assert (80 * loop_errors[-1] < linear_errors[-1]).all()
    assert (np.log2(loop_errors[0] / loop_errors[-1]) / 2 > 2.9).all()
    np.testing.assert_allclose(orders(linear_errors), 2, atol=0.1)


def limit_radii(positions, faces):
    return np.linalg.norm(limit_matrix(faces, len(positions)) @ positions, axis=1)


def test_one_implicit_step_shrinks_the_sphere_at_the_mean_curvature_rate():
    """x' = 2 H n: one implicit step scales the unit sphere by 1 / (1 + 2 tau), order two in h."""
    tau = 0.01
    errors = []
    for level in LEVELS:
        control, faces, _ = sphere(level)
        settings = FairingSettings(
            method="uniform", tau=tau, steps=1, normalize=False, cg_tolerance=1e-12
        )
        result = fair(control, faces, settings)
        errors.append(np.abs(limit_radii(result.positions, faces) * (1 + 2 * tau) - 1).max())
    assert errors[-1] < 1e-4
    assert (orders(errors) > 1.9).all()


def test_many_small_steps_follow_the_exact_radius():
    """r(t)^2 = 1 - 4 t, with order one in the timestep."""
    control, faces, _ = sphere(3)
    end = 0.1
    errors = []
    for steps in (4, 8, 16):
        settings = FairingSettings(
            method="uniform", tau=end / steps, steps=steps, normalize=False, cg_tolerance=1e-10
        )
        result = fair(control, faces, settings)
        assert result.steps[-1].time == pytest.approx(end, rel=1e-14)
        errors.append(limit_radii(result.positions, faces).mean() - np.sqrt(1 - 4 * end))
    assert abs(errors[-1]) < 0.01
    np.testing.assert_allclose(orders(errors), 1, atol=0.15)
