"""Functions on a surface diffuse by the matrices that fair the surface."""

from functools import lru_cache

import numpy as np
import pytest
from support import meshes
from support.reference import interpolating_control_points

from adaptive_fairing.core import (
    FairingSettings,
    InputError,
    LoopSpace,
    SolverError,
    TriangleTopology,
    fair,
    fair_values,
    mesh_density,
)

METHODS = ("uniform", "adaptive_timestep", "adaptive_tensor")


def random_values(n_vertices, k=3, seed=0):
    return np.random.default_rng(seed).normal(size=(n_vertices, k))


# What a step is ----------------------------------------------------------------------------------


@pytest.mark.parametrize("boundary", ["fixed", "free"])
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    "mesh", [meshes.noisy_ball(2, 0.03), meshes.bumpy_disc(0)], ids=["closed", "open"]
)
def test_coordinates_as_functions_become_the_first_step_of_fair(mesh, method, boundary):
    vertices, faces = mesh
    weights = np.random.default_rng(1).uniform(size=len(vertices))
    weights[::7] = 0
    settings = FairingSettings(method=method, steps=1, boundary=boundary, cg_tolerance=1e-12)
    [values] = fair_values(vertices, faces, vertices, settings, weights=weights)
    moved = fair(vertices, faces, settings, weights=weights).positions
    assert np.abs(moved - vertices).max() > 1e-3
    np.testing.assert_allclose(values, moved, atol=1e-9)
    held = weights == 0
    assert np.array_equal(values[held], vertices[held])


@pytest.mark.parametrize("method", METHODS)
def test_every_step_solves_the_same_system_on_the_surface_that_stays(method):
    vertices, faces = meshes.random_closed(1)
    settings = FairingSettings(
        method=method, tau=0.05, steps=3, cg_tolerance=1e-13, normalize=False
    )
    topology = TriangleTopology(faces, len(vertices))
    space, field = LoopSpace(topology), 0.05 * mesh_density(topology, vertices)
    if method == "uniform":
        field = np.full_like(field, 0.05)
    is_tensor = method == "adaptive_tensor"
    mass = space.mass_matrix(vertices, timestep=None if is_tensor else field).toarray()
    stiffness = space.stiffness_matrix(vertices, diffusivity=field if is_tensor else None)
    expected = random_values(len(vertices))
    for values in fair_values(vertices, faces, expected, settings):
        expected = np.linalg.solve(mass + stiffness.toarray(), mass @ expected)
        np.testing.assert_allclose(values, expected, atol=1e-10)


# What stays --------------------------------------------------------------------------------------


@pytest.mark.parametrize("boundary", ["fixed", "free"])
@pytest.mark.parametrize("method", METHODS)
def test_constants_stay_exactly(method, boundary):
    vertices, faces = meshes.bumpy_disc(0)
    constants = np.tile([1.0, -7.3, 1e-12, 1e200, 0.0], (len(vertices), 1))
    settings = FairingSettings(method=method, boundary=boundary)
    for values in fair_values(vertices, faces, constants, settings):
        assert np.array_equal(values, constants)


@pytest.mark.parametrize("tolerance", [1e-2, 1e-6])
@pytest.mark.parametrize("method", METHODS)
def test_means_stay_on_every_part_however_loosely_the_system_is_solved(method, tolerance):
    one, faces = meshes.random_closed(1)
    vertices = np.concatenate([one, 0.5 * one + 3])
    faces = np.concatenate([faces, faces + len(one)])
    settings = FairingSettings(
        method=method, tau=0.05, cg_tolerance=tolerance, normalize=False, density="area"
    )
    topology = TriangleTopology(faces, len(vertices))
    field = 0.05 * mesh_density(topology, vertices, "area")
    timestep = field if method == "adaptive_timestep" else None
    mass = LoopSpace(topology).mass_matrix(vertices, timestep=timestep)
    given = 3 + random_values(len(vertices))
    evolution = fair_values(vertices, faces, given, settings)
    assert np.abs(evolution[-1] - given).max() > 0.1
    for part in (slice(0, len(one)), slice(len(one), None)):
        masses = mass[part].sum(axis=1)
        for values in evolution:
            np.testing.assert_allclose(masses @ values[part], masses @ given[part], rtol=1e-12)


def test_loose_and_held_vertices_keep_their_values_and_the_surface_decides_for_the_others():
    vertices, faces = meshes.noisy_ball(2, 0.03)
    more = np.concatenate([vertices, [[50.0, 0.0, 0.0]]])
    given = random_values(len(more))
    values = fair_values(more, faces, given)
    assert np.array_equal(values[:, -1], np.repeat(given[None, -1], 4, axis=0))
    expected = fair_values(vertices, faces, given[:-1])
    np.testing.assert_allclose(values[:, :-1], expected, atol=1e-12)
    weights = np.zeros(len(more))
    assert np.array_equal(fair_values(more, faces, given, weights=weights)[-1], given)


def test_a_fixed_boundary_keeps_its_values_and_a_free_one_does_not():
    vertices, faces = meshes.bumpy_disc(0)
    edge = TriangleTopology(faces, len(vertices)).on_boundary
    given = random_values(len(vertices))
    fixed, free = (
        fair_values(vertices, faces, given, FairingSettings(boundary=boundary))[-1]
        for boundary in ("fixed", "free")
    )
    assert np.array_equal(fixed[edge], given[edge])
    assert np.abs(free[edge] - given[edge]).min() > 0
    assert fixed[~edge].std() < given[~edge].std()


@pytest.mark.parametrize("method", METHODS)
def test_functions_do_not_know_of_each_other(method):
    """A temperature in hundreds and a weight below 1 may be faired together."""
    vertices, faces = meshes.noisy_ball(2, 0.03)
    # The first is solved in fewer iterations: it must not end those of the second.
    given = np.column_stack([vertices[:, 2], random_values(len(vertices), 1)])
    settings = FairingSettings(method=method, cg_tolerance=1e-10)
    together = fair_values(vertices, faces, given * [1e6, 1e-6] + [300, 0], settings)[-1]
    for column, factor, shift in ((0, 1e6, 300), (1, 1e-6, 0)):
        [alone] = fair_values(vertices, faces, given[:, [column]], settings)[-1].T
        np.testing.assert_allclose((together[:, column] - shift) / factor, alone, atol=1e-8)


# What is known exactly ---------------------------------------------------------------------------

HARMONICS = {1: lambda z: z, 2: lambda z: 3 * z**2 - 1, 3: lambda z: 5 * z**3 - 3 * z}
TIME, STEPS = 0.05, 2


@lru_cache
def sphere(level):
    vertices, faces = meshes.icosphere(level)
    control = interpolating_control_points(vertices, faces)
    mass = LoopSpace(TriangleTopology(faces, len(vertices)), 1e-5).mass_matrix(control)
    return vertices, control, faces, mass


def decay(level, degree, radius):
    """Factor that is left of a harmonic after each step, by projection."""
    vertices, control, faces, mass = sphere(level)
    harmonic = HARMONICS[degree](vertices[:, [2]])
    function = interpolating_control_points(np.repeat(harmonic, 3, axis=1), faces)[:, [0]]
    settings = FairingSettings(
        method="uniform",
        tau=TIME * radius**2,
        steps=STEPS,
        normalize=False,
        cg_tolerance=1e-12,
        quadrature_tolerance=1e-5,
    )
    evolution = fair_values(radius * control, faces, function, settings)
    size = (function.T @ (mass @ function)).item()
    return np.array([(function.T @ (mass @ values)).item() / size for values in evolution])


@pytest.mark.parametrize("radius", [1.0, 40.0])
@pytest.mark.parametrize("degree", HARMONICS)
def test_spherical_harmonics_decay_at_their_rate_with_order_3(degree, radius):
    """By 1 / (1 + T l (l + 1) / r²) a step; measured orders 3.0 to 3.5 for steps 1 and 2."""
    exact = (1 + TIME * degree * (degree + 1)) ** -np.arange(1.0, STEPS + 1)
    errors = np.array([np.abs(decay(level, degree, radius) / exact - 1) for level in (2, 3, 4)])
    assert errors[-1].max() < 3e-5
    assert (np.log2(errors[:-1] / errors[1:]) > 2.9).all()


# What is refused ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda v: v[:, 0], r"values must have shape \(162, k\), not \(162,\)"),
        (lambda v: v[1:], r"values must have shape \(162, k\), not \(161, 3\)"),
        (lambda v: np.where(v > 2, np.nan, v), r"vertices have values that are not finite"),
    ],
)
def test_values_that_are_none_are_refused(change, message):
    vertices, faces = meshes.icosphere(2)
    with pytest.raises(InputError, match=message):
        fair_values(vertices, faces, change(random_values(162)))


def test_a_step_that_does_not_converge_is_an_error():
    vertices, faces = meshes.icosphere(2)
    hopeless = FairingSettings(cg_max_iterations=1, cg_tolerance=1e-12)
    with pytest.raises(SolverError, match="step 1 did not converge: residual"):
        fair_values(vertices, faces, random_values(162), hopeless)


def test_nothing_handed_over_is_changed():
    vertices, faces = meshes.icosphere(2)
    given = random_values(162)
    copies = vertices.copy(), faces.copy(), given.copy()
    fair_values(vertices, faces, given)
    for array, copy in zip((vertices, faces, given), copies, strict=True):
        assert np.array_equal(array, copy)
