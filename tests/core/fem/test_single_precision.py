"""Large meshes are faired in single precision: as exact as the quadrature, and only where it is."""

from dataclasses import replace

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import FairingSettings, LoopSpace, TriangleTopology, fair
from adaptive_fairing.core.diffusion import steps
from adaptive_fairing.core.fem import surface_evaluation
from adaptive_fairing.core.linalg.conjugate_gradients import conjugate_gradients
from adaptive_fairing.core.runtime.precision import SINGLE

METHODS = ["uniform", "adaptive_timestep", "adaptive_tensor"]


def random_system(in_single, positions=lambda vertices: vertices, **fields):
    """The system of a mesh with valences 3 to 10, rare and frequent classes."""
    vertices, faces = meshes.random_closed(4, meshes.icosphere(2))
    space = LoopSpace(TriangleTopology(faces, len(vertices)))
    random = np.random.default_rng(0)
    fields = {name: scale * random.uniform(1, 2, len(vertices)) for name, scale in fields.items()}
    return space.step_system(positions(vertices), **fields, in_single=in_single)


def largest(difference, entries):
    return np.abs(difference).max() / np.abs(entries).max()


def entries(system):
    return system.matrix.full().toarray()


def in_a_far_corner(vertices):
    return 0.05 * vertices + 2.9


@pytest.mark.parametrize("positions", [np.array, in_a_far_corner])
@pytest.mark.parametrize("field", ["timestep", "diffusivity"])
def test_the_system_is_that_of_double_precision_but_for_rounding(field, positions):
    single, double = (
        random_system(in_single, positions, **{field: 0.002}) for in_single in (True, False)
    )
    assert single.matrix.is_single
    assert not double.matrix.is_single
    assert 0 < largest(entries(single) - entries(double), entries(double)) < 2e-6
    assert largest(single.load - double.load, double.load) < 5e-6
    assert largest(single.lumped_mass - double.lumped_mass, double.lumped_mass) < 2e-6
    for name in ("curvature_energy", "area", "volume"):
        value, expected = getattr(single.measures, name), getattr(double.measures, name)
        assert value == pytest.approx(expected, rel=1e-5), name


def squeezed(vertices):
    return vertices * (1, 1, 1e-4)


def with_a_tiny_part(vertices):
    vertices = vertices.copy()
    vertices[np.linalg.norm(vertices - vertices[0], axis=1) < 0.6] *= 1e-5
    return vertices


def microscopic(vertices):
    return 1e-8 * vertices


def test_blocks_that_single_precision_does_not_resolve_are_integrated_in_double():
    """What they add is that of double precision, rounded where it is stored."""
    single, double = (random_system(each, squeezed, timestep=0.002) for each in (True, False))
    assert single.matrix.is_single
    assert single.in_double
    rounding = 4 * np.finfo(np.float32).eps
    assert largest(entries(single) - entries(double), entries(double)) < rounding
    assert largest(single.load - double.load, double.load) < rounding
    assert single.measures == double.measures


def test_small_triangles_far_from_the_origin_keep_their_digits():
    """Rounded coordinates would be off by a hundredth of these triangles."""
    large, faces = meshes.icosphere(2)
    vertices = np.concatenate([large, 1e-4 * large + (2.9, 0, 0)])
    is_tiny = np.arange(len(vertices)) >= len(large)
    space = LoopSpace(TriangleTopology(np.concatenate([faces, faces + len(large)]), len(vertices)))
    times = np.where(is_tiny, 1e-10, 1e-2)
    single, double = (
        space.step_system(vertices, timestep=times, in_single=each) for each in (True, False)
    )
    assert single.matrix.is_single
    assert not single.in_double
    assert largest((single.load - double.load)[is_tiny], double.load[is_tiny]) < 5e-6


@pytest.mark.parametrize(
    ("positions", "timestep"),
    [(np.zeros_like, 0.002), (with_a_tiny_part, 1.0), (microscopic, 1e-20), (np.array, 1e4)],
    ids=["a point", "small masses", "tiny times", "long times"],
)
def test_systems_that_single_precision_does_not_hold_are_computed_in_double(positions, timestep):
    system = random_system(True, positions, timestep=timestep)
    expected = random_system(False, positions, timestep=timestep)
    assert not system.matrix.is_single
    np.testing.assert_array_equal(entries(system), entries(expected))
    np.testing.assert_array_equal(system.load, expected.load)


def test_measures_of_blocks_that_are_not_resolved_are_those_of_double_precision():
    vertices, faces = meshes.random_closed(4, meshes.icosphere(2))
    space = LoopSpace(TriangleTopology(faces, len(vertices)))
    positions = squeezed(vertices)
    assert space.measures(positions, in_single=True) == space.measures(positions)


@pytest.mark.parametrize("tolerance", [1e-2, 1e-9])
def test_solves_go_on_in_double_precision_where_it_takes_that(tolerance):
    system = random_system(True, timestep=0.002)
    n = len(system.load)
    increment, report = conjugate_gradients(
        system.matrix,
        system.load,
        np.zeros((n, 3)),
        is_held=np.zeros(n, dtype=bool),
        tolerance=tolerance,
        max_iterations=500,
    )
    assert report.converged
    matrix = entries(system)
    inverse = 1 / np.diag(matrix)[:, None]
    residual = system.load - matrix @ increment
    relative = np.sqrt(np.sum(inverse * residual**2) / np.sum(inverse * system.load**2))
    assert relative <= tolerance * 1.01
    assert report.residual == pytest.approx(relative, rel=0.02)


@pytest.fixture(scope="module")
def ball():
    vertices, faces = meshes.noisy_ball(5, 0.005)
    assert len(faces) >= SINGLE.least_triangles
    return vertices, faces


@pytest.fixture
def tried(monkeypatch):
    """Whether single precision was to be tried, system by system."""
    wishes = []
    step_system = LoopSpace.step_system

    def recorded(*arguments, in_single, **fields):
        wishes.append(in_single and SINGLE.serves_times(fields["timestep"]))
        return step_system(*arguments, in_single=in_single, **fields)

    monkeypatch.setattr(LoopSpace, "step_system", recorded)
    return wishes


def in_double(monkeypatch, mesh, settings):
    with monkeypatch.context() as patch:
        patch.setattr(steps, "SINGLE", replace(SINGLE, least_triangles=np.inf))
        return fair(*mesh, settings)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("tau", [1e-3, 0.016])
def test_steps_of_a_large_mesh_are_those_of_double_precision(ball, method, tau, monkeypatch):
    settings = FairingSettings(method=method, tau=tau / 10 if method == "uniform" else tau)
    result, expected = fair(*ball, settings), in_double(monkeypatch, ball, settings)
    moved = np.abs(expected.positions - ball[0]).max()
    assert 0 < np.abs(result.positions - expected.positions).max() < 1e-5 * moved
    for step, exact in zip(result.steps, expected.steps, strict=True):
        assert step.solve.iterations == pytest.approx(exact.solve.iterations, abs=1)
        assert step.curvature_energy == pytest.approx(exact.curvature_energy, rel=1e-6)
        assert step.area == pytest.approx(exact.area, rel=1e-7)
        assert step.volume == pytest.approx(exact.volume, rel=1e-7)


@pytest.mark.parametrize(
    "settings",
    [
        FairingSettings(quadrature_tolerance=1e-5, steps=1),
        FairingSettings(normalize=False, steps=1),
        FairingSettings(tau=1e20, steps=1),
    ],
    ids=["tight tolerance", "own units", "huge time"],
)
def test_large_meshes_in_double_precision_on_request_or_where_it_takes_that(
    ball, settings, monkeypatch, tried
):
    expected = in_double(monkeypatch, ball, settings)
    np.testing.assert_array_equal(fair(*ball, settings).positions, expected.positions)
    assert tried == [False, False]


def test_single_precision_is_not_tried_again_where_it_did_not_serve(ball, tried):
    """Of a long timestep the masses are small beside L."""
    fair(*ball, FairingSettings(tau=500, steps=3))
    assert tried == [True, False, False]


def test_blocks_are_not_tried_again_where_it_was_not_enough(ball, monkeypatch):
    tries = []
    seen = surface_evaluation._seen_from_corners
    monkeypatch.setattr(
        surface_evaluation,
        "_seen_from_corners",
        lambda block, *control: tries.append(block) or seen(block, *control),
    )
    vertices, faces = ball
    space = LoopSpace(TriangleTopology(faces, len(vertices)))
    times = np.full(len(vertices), 1e-4)
    first = space.step_system(squeezed(vertices), timestep=times, in_single=True)
    all_blocks = set(tries)
    assert set() < first.in_double <= all_blocks
    tries.clear()
    second = space.step_system(
        squeezed(vertices), timestep=times, in_single=True, in_double=first.in_double
    )
    assert set(tries) == all_blocks - first.in_double
    assert second.in_double == first.in_double
    np.testing.assert_array_equal(second.load, first.load)


def test_steps_of_a_squeezed_mesh_are_those_of_double_precision(ball, monkeypatch):
    mesh = squeezed(ball[0]), ball[1]
    settings = FairingSettings(tau=1e-4, steps=2)
    result, expected = fair(*mesh, settings), in_double(monkeypatch, mesh, settings)
    moved = np.abs(expected.positions - mesh[0]).max()
    assert 0 < np.abs(result.positions - expected.positions).max() < 1e-5 * moved


def test_the_last_bit_is_the_same_from_run_to_run(ball):
    first, second = (fair(*ball, FairingSettings(steps=2)).positions for _ in range(2))
    np.testing.assert_array_equal(first, second)
