"""Any mesh at all: generated connectivity and shapes, and what must hold for every one of them.

A few dozen examples by default, thousands with ``-m thorough``.
"""

from dataclasses import dataclass, replace

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from support.bad_meshes import bow_tie, everything_wrong, klein_bottle, moebius_strip, three_sheets
from support.meshes import (
    bipyramid,
    boundary_vertices,
    bumpy_disc,
    flat_grid,
    icosahedron,
    merged,
    open_cylinder,
    random_closed,
    seven_vertex_torus,
    single_triangle,
    tetrahedron,
    torus,
)

from adaptive_fairing.core import FairingError, FairingSettings, fair
from adaptive_fairing.core.problem.diagnosis import find_problems

WHOLE_MESHES = (
    lambda seed: bow_tie(),
    lambda seed: bipyramid(3 + seed % 20),
    lambda seed: bumpy_disc(seed % 5),
    lambda seed: everything_wrong(),
    lambda seed: flat_grid(1 + seed % 3, 1 + seed % 4),
    lambda seed: icosahedron(),
    lambda seed: klein_bottle(3 + seed % 4),
    lambda seed: moebius_strip(3 + seed % 6),
    lambda seed: open_cylinder(3 + seed % 5, 1 + seed % 3),
    lambda seed: random_closed(seed % 5),
    lambda seed: seven_vertex_torus(),
    lambda seed: single_triangle(),
    lambda seed: tetrahedron(),
    lambda seed: three_sheets(1 + seed % 3),
    lambda seed: torus(3 + seed % 4, 3 + seed % 3),
)


@dataclass
class Case:
    """A mesh and how to fair it."""

    vertices: np.ndarray
    faces: np.ndarray
    weights: np.ndarray | None
    settings: FairingSettings


def random_triangles(generator):
    """Return triangles over random vertices: every kind of non-manifold."""
    n_vertices = int(generator.integers(3, 12))
    faces = generator.integers(0, n_vertices, (int(generator.integers(1, 30)), 3))
    return generator.normal(size=(n_vertices, 3)), faces.astype(np.int32)


def damaged(mesh, generator):
    """Return a mesh after one random damage of its connectivity."""
    vertices, faces = mesh[0], mesh[1].copy()
    some = generator.random(len(faces)) < generator.choice([0.05, 0.3, 0.7])
    kind = generator.integers(6)
    if kind == 0:
        faces = faces[~some] if not some.all() else faces
    elif kind == 1:
        faces[some] = faces[some][:, ::-1]
    elif kind == 2:
        faces = np.vstack([faces, faces[some]])
    elif kind == 3:  # join vertices
        one, other = generator.integers(0, len(vertices), 2)
        faces[faces == one] = other
    elif kind == 4:  # wrong corners
        faces[some, generator.integers(3)] = generator.integers(0, len(vertices))
    else:  # another piece through the same vertices
        extra = generator.integers(0, len(vertices), (3, 3))
        faces = np.vstack([faces, extra])
    return vertices, faces.astype(np.int32)


def deformed(vertices, generator):
    """Return positions after one random change of shape."""
    kind = generator.integers(9)
    n = len(vertices)
    if kind == 0:
        return 0 * vertices
    if kind == 1:  # many vertices in the same places
        return np.round(vertices * 2) / 2
    if kind == 2:  # flat, linear or needle-like
        return vertices * generator.choice([0.0, 1e-12, 1e-6, 1.0], 3)
    if kind == 3:  # a clump
        vertices = vertices.copy()
        vertices[generator.random(n) < 0.3] = vertices[0]
        return vertices
    if kind == 4:  # a spike
        vertices = vertices.copy()
        vertices[generator.integers(n)] *= 10.0 ** generator.integers(-9, 10)
        return vertices
    if kind == 5:
        return vertices + 10.0 ** generator.integers(-3, 7) * generator.normal(size=3)
    if kind == 6:
        return generator.normal(size=vertices.shape)
    if kind == 7:  # sizes spread over many orders
        return vertices * 10.0 ** generator.integers(-8, 3, (n, 1))
    return vertices


@st.composite
def cases(draw):
    """Any connectivity, damaged; any shape, deformed; any settings."""
    generator = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    if draw(st.booleans()):
        mesh = random_triangles(generator)
    else:
        mesh = draw(st.sampled_from(WHOLE_MESHES))(int(generator.integers(1000)))
    for _ in range(draw(st.integers(0, 2))):
        mesh = damaged(mesh, generator)
    if draw(st.booleans()):
        mesh = merged(mesh, random_triangles(generator))
    vertices, faces = mesh
    for _ in range(draw(st.integers(0, 2))):
        vertices = deformed(vertices, generator)
    weights = generator.choice([0.0, 0.5, 1.0], len(vertices)) if draw(st.booleans()) else None
    chosen = FairingSettings(
        method=draw(st.sampled_from(["adaptive_timestep", "adaptive_tensor", "uniform"])),
        tau=draw(st.sampled_from([None, *(10.0**exponent for exponent in range(-12, 7))])),
        radius=draw(st.sampled_from([0.01, 0.5, 20.0])),
        normalize=draw(st.sampled_from(["box", "sphere"])),
        keep_volume=draw(st.booleans()),
        max_deviation=draw(st.sampled_from([None, 1e-12, 0.01])),
        steps=draw(st.integers(1, 2)),
        density=draw(st.sampled_from(["edge_length", "area"])),
        density_passes=draw(st.integers(0, 4)),
        boundary=draw(st.sampled_from(["fixed", "free"])),
        quadrature_tolerance=1e-2,
    )
    return Case(vertices * 10.0 ** draw(st.sampled_from([-8, 0, 0, 0, 8])), faces, weights, chosen)


def check(case):
    """Fair one case; assert all that has to hold."""
    vertices, faces, weights = case.vertices.copy(), case.faces.copy(), case.weights
    try:
        result = fair(vertices, faces, case.settings, weights=weights)
    except FairingError as error:
        # The only refusal that the generators can provoke.
        assert "three different vertices" in str(error)
        return
    np.testing.assert_array_equal(vertices, case.vertices)
    np.testing.assert_array_equal(faces, case.faces)
    for step in result.steps:
        assert np.isfinite(step.positions).all()
        assert np.isfinite(step.density).all()
        assert (step.density >= 0).all()
        assert np.isfinite([step.area, step.curvature_energy, step.solve.residual]).all()
        assert min(step.area, step.curvature_energy) >= 0
        assert all("\n" not in note for note in step.notes)
    assert (result.stop_reason == "not_converged") != result.steps[-1].solve.converged

    held = np.zeros(len(vertices), dtype=bool)
    held[find_problems(vertices, faces).held] = True
    held |= np.bincount(faces.ravel(), minlength=len(vertices)) == 0
    if weights is not None:
        held |= weights == 0
    if case.settings.boundary == "fixed" and not result.notes:
        held[boundary_vertices(faces)] = True
    for step in result.steps:
        np.testing.assert_array_equal(step.positions[held], vertices[held])

    again = fair(vertices, faces, case.settings, weights=weights)
    np.testing.assert_array_equal(again.positions, result.positions)
    # Factors of two have no rounding, so the frame is the same, bit by bit.
    limit, larger_settings = case.settings.max_deviation, case.settings
    if limit is not None:
        for step in result.steps:
            assert np.linalg.norm(step.positions - vertices, axis=1).max(initial=0) <= limit
        larger_settings = replace(case.settings, max_deviation=2.0**10 * limit)
    larger = fair(2.0**10 * vertices, faces, larger_settings, weights=weights)
    np.testing.assert_array_equal(larger.positions, 2.0**10 * result.positions)


@st.composite
def healthy_cases(draw):
    """Noisy meshes of any valence without faults, where results must agree to rounding."""
    seed = draw(st.integers(0, 2**16))
    mesh = draw(st.sampled_from([random_closed, bumpy_disc]))(seed % 50)
    generator = np.random.default_rng(seed)
    chosen = FairingSettings(
        method=draw(st.sampled_from(["adaptive_timestep", "adaptive_tensor", "uniform"])),
        tau=10.0 ** draw(st.integers(-6, 0)),
        steps=2,
        density=draw(st.sampled_from(["edge_length", "area"])),
        boundary=draw(st.sampled_from(["fixed", "free"])),
        cg_tolerance=1e-12,
        quadrature_tolerance=1e-2,
    )
    return mesh, chosen, generator


def check_symmetries(mesh, chosen, generator):
    """Order and orientation, place and pose of a mesh must not matter."""
    vertices, faces = mesh
    expected = fair(vertices, faces, chosen).positions

    order = generator.permutation(len(vertices))
    corners = generator.integers(0, 3, (len(faces), 1))
    shuffled = np.take_along_axis(faces, (corners + np.arange(3)) % 3, axis=1)
    shuffled = np.argsort(order)[generator.permutation(shuffled)]
    if generator.random() < 0.5:
        shuffled = shuffled[:, ::-1]
    result = fair(vertices[order], shuffled, chosen).positions
    np.testing.assert_allclose(result, expected[order], atol=1e-9)

    # The frame is fitted to the box along the axes: only moves that keep it keep the time scale.
    axes = generator.permutation(3)
    signs = generator.choice([-1.0, 1.0], 3)
    offset = generator.normal(size=3)
    result = fair(3.7 * signs * vertices[:, axes] + offset, faces, chosen).positions
    np.testing.assert_allclose(result, 3.7 * signs * expected[:, axes] + offset, atol=1e-8)


def profile(n_examples):
    return settings(
        max_examples=n_examples,
        deadline=None,
        derandomize=True,
        suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
    )


@profile(40)
@given(cases())
def test_any_mesh(case):
    check(case)


@profile(10)
@given(healthy_cases())
def test_symmetries(case):
    check_symmetries(*case)


@pytest.mark.thorough
@profile(2500)
@given(cases())
def test_any_mesh_thoroughly(case):
    check(case)


@pytest.mark.thorough
@profile(300)
@given(healthy_cases())
def test_symmetries_thoroughly(case):
    check_symmetries(*case)
