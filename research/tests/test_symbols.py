"""Damping on the plane: assembled matrices against exact Fourier symbols; linear elements."""

from __future__ import annotations

import numpy as np
import pytest
from support.reference import linear_mass_matrix, linear_stiffness_matrix

from adaptive_fairing.core import TriangleTopology, mesh_density
from research.claims.bandwidth import (
    ACROSS_EDGES,
    RADIUS,
    plane_damping,
    sphere_damping,
    wave_vector,
)
from research.claims.linear_elements import fair_linear, mass_matrix, stiffness_matrix
from research.claims.shapes import flat_hexagon
from research.tests.symbols import linear_symbols, loop_symbols
from tools.geometry.triangles import icosphere

LENGTHS = np.array([1.75, 2.0, 3.0, 5.0, 17.0])


def test_damping_of_the_assembled_matrices_is_that_of_the_exact_symbols():
    damping = plane_damping(LENGTHS)
    waves, time = wave_vector(LENGTHS, ACROSS_EDGES), 0.5 * RADIUS**2
    loop, linear = (m / (m + time * s) for m, s in (loop_symbols(waves), linear_symbols(waves)))
    np.testing.assert_allclose(damping.loop, loop, rtol=1e-6)
    np.testing.assert_allclose(damping.linear, linear, rtol=1e-12)


def test_waves_without_end_are_not_damped():
    mass, stiffness = loop_symbols(np.zeros((1, 2)))
    area = 0.75**0.5
    assert mass == pytest.approx([area])  # partition of unity
    assert stiffness == pytest.approx([0.0], abs=1e-12)
    mass, stiffness = linear_symbols(np.zeros((1, 2)))
    assert (*mass, *stiffness) == pytest.approx((area, 0.0))


def test_eigenvalues_of_the_symbols_are_k_squared_with_their_orders():
    """Order 6 for quartic splines with cubic reproduction, order 2 for hats."""
    lengths = np.array([20.0, 40.0])
    waves = wave_vector(lengths, 0.3)
    exact = np.sum(waves**2, axis=1)
    for (mass, stiffness), order in ((loop_symbols(waves), 6), (linear_symbols(waves), 2)):
        error = stiffness / mass / exact - 1
        assert (error > 0).all()  # Rayleigh quotients come from above
        assert np.log2(error[0] / error[1]) == pytest.approx(order, abs=0.1)


def test_symbols_are_periodic_in_the_reciprocal_lattice():
    edges = np.array([[1.0, 0.0], [0.5, 0.75**0.5]])
    shift = 2 * np.pi * np.linalg.inv(edges).T[0]
    waves = wave_vector(LENGTHS, 0.2)
    for symbols in (loop_symbols, linear_symbols):
        for one, other in zip(symbols(waves), symbols(waves + shift), strict=True):
            np.testing.assert_allclose(one, other, rtol=1e-7, atol=1e-9)


def test_damping_on_the_sphere_nears_the_exact_one():
    damping = sphere_damping((2, 4, 8))
    np.testing.assert_allclose(damping.loop, damping.exact, atol=1e-3)
    assert (np.abs(damping.loop - damping.exact) < np.abs(damping.linear - damping.exact)).all()


def test_linear_matrices_are_those_of_an_independent_computation():
    vertices, triangles = icosphere(1)
    vertices = vertices * [1.0, 1.3, 0.7]
    for ours, reference in (
        (mass_matrix(vertices, triangles), linear_mass_matrix(vertices, triangles)),
        (stiffness_matrix(vertices, triangles), linear_stiffness_matrix(vertices, triangles)),
    ):
        np.testing.assert_allclose(ours.toarray(), reference.toarray(), atol=1e-13)


def test_a_constant_timestep_divides_the_linear_mass_matrix():
    vertices, triangles = icosphere(1)
    scaled = mass_matrix(vertices, triangles, np.full(len(vertices), 0.25))
    np.testing.assert_allclose(scaled.toarray(), 4 * mass_matrix(vertices, triangles).toarray())


def test_one_linear_step_solves_the_scheme_s_equation():
    vertices, triangles = icosphere(2)
    vertices = vertices * [3.0, 2.0, 2.5]  # fits [-3, 3]³ as it is
    tau = 0.02
    density = mesh_density(TriangleTopology(triangles, len(vertices)), vertices)
    mass = mass_matrix(vertices, triangles, tau * density)
    moved = fair_linear(vertices, triangles, tau, 1)
    residual = mass @ (moved - vertices) + stiffness_matrix(vertices, triangles) @ moved
    scale = np.linalg.norm(mass @ vertices, axis=0)
    assert (np.linalg.norm(residual, axis=0) / scale < 2e-6).all()


def test_shapes():
    vertices, triangles = icosphere(2)
    assert (len(vertices), len(triangles)) == (162, 320)
    assert np.linalg.norm(vertices, axis=1) == pytest.approx(np.ones(162))
    assert (np.linalg.det(vertices[triangles]) > 0).all()
    vertices, triangles = flat_hexagon(3)
    assert (len(vertices), len(triangles)) == (37, 54)
    assert vertices[0] == pytest.approx([0, 0, 0])
    sides = vertices[triangles] - np.roll(vertices[triangles], 1, axis=1)
    np.testing.assert_allclose(np.linalg.norm(sides, axis=2), 1.0)
    normal = np.cross(sides[:, 1], sides[:, 2])
    assert (normal[:, 2] > 0).all()
