"""Weights on a part of a mesh: what is solved on is that part, what comes out is the whole."""

import numpy as np
import pytest
from support import meshes
from support.bad_meshes import everything_wrong

from adaptive_fairing.core import FairingSettings, LoopSpace, PreparedMesh, fair, fair_values
from adaptive_fairing.core.diffusion import local_density, steps
from adaptive_fairing.core.problem import prepared_surface, region
from adaptive_fairing.core.problem.problem import Margin

METHODS = ("uniform", "adaptive_timestep", "adaptive_tensor")

# Parts of the motion.  Below the stated 1e-6: the two solves differ by rounding, and where that
# lets one of them take an iteration more, by the tolerance of the solver.
EQUAL = 1e-7


def wavy_grid():
    vertices, faces = meshes.flat_grid(30, 30)
    noise = np.random.default_rng(0).normal(0, 0.1, len(vertices))
    return np.column_stack([vertices[:, :2], np.sin(vertices[:, 0] / 3) + noise]), faces


def uneven_ball():
    vertices, faces = meshes.random_hull(3, 900)
    return vertices * (1 + 0.05 * np.random.default_rng(0).normal(size=(len(vertices), 1))), faces


MESHES = {
    "closed": meshes.noisy_ball(4, 0.02),
    "open": wavy_grid(),
    "irregular": uneven_ball(),
    "wrong": meshes.merged(meshes.noisy_ball(3, 0.03), everything_wrong()),
}


def weights_around(vertices, place, fraction):
    """Weights from 1 down to 0 on a fraction of the vertices, around one of them."""
    distance = np.linalg.norm(vertices - vertices[place], axis=1)
    radius = np.quantile(distance, fraction)
    return np.clip(2 * (1 - distance / radius), 0, 1)


@pytest.fixture
def whole(monkeypatch):
    """Let runs solve on all of the mesh."""

    def of(function):
        with monkeypatch.context() as context:
            context.setattr(region, "LARGEST_PART", 0)
            return function()

    return of


@pytest.mark.parametrize("boundary", ["fixed", "free"])
@pytest.mark.parametrize("name", MESHES)
@pytest.mark.parametrize("method", METHODS)
def test_positions_are_those_of_the_solve_on_the_whole(method, name, boundary, whole):
    vertices, faces = MESHES[name]
    settings = FairingSettings(method=method, boundary=boundary, cg_tolerance=1e-12)
    # On the open mesh the part reaches the boundary.
    weights = weights_around(vertices, 5 if name == "open" else 0, 0.05)

    def run():
        return fair(vertices, faces, settings, weights=weights)

    part, expected = run(), whole(run)
    assert part.notes == expected.notes
    for own, other in zip(part.steps, expected.steps, strict=True):
        motion = np.abs(other.positions - vertices).max()
        assert np.abs(own.positions - other.positions).max() < EQUAL * motion
        assert own.tau == pytest.approx(other.tau, rel=1e-12)
        used = weights > 0
        np.testing.assert_allclose(own.density[used], other.density[used], rtol=1e-9)
    held = weights == 0
    np.testing.assert_array_equal(part.positions[held], vertices[held])


@pytest.mark.parametrize("density", ["edge_length", "area"])
@pytest.mark.parametrize("passes", [0, 3, 7])
def test_every_pass_over_the_density_has_its_ring(passes, density, whole):
    vertices, faces = MESHES["irregular"]
    settings = FairingSettings(density=density, density_passes=passes, cg_tolerance=1e-12)
    weights = weights_around(vertices, 0, 0.02)

    def run():
        return fair(vertices, faces, settings, weights=weights).positions

    part, expected = run(), whole(run)
    assert np.abs(part - expected).max() < EQUAL * np.abs(expected - vertices).max()


@pytest.mark.parametrize("too_few", [1, region.SUPPORT_RINGS - 1])
@pytest.mark.parametrize("method", METHODS)
def test_fewer_rings_would_not_do(method, too_few, whole, monkeypatch):
    vertices, faces = MESHES["irregular"]
    settings = FairingSettings(method=method, density_passes=0, cg_tolerance=1e-12)
    weights = weights_around(vertices, 0, 0.02)

    def error():
        positions = fair(vertices, faces, settings, weights=weights).positions
        return np.abs(positions - expected).max() / np.abs(expected - vertices).max()

    expected = whole(lambda: fair(vertices, faces, settings, weights=weights).positions)
    assert error() < EQUAL
    monkeypatch.setattr(steps, "margin_of_run", lambda _: Margin(too_few))
    assert error() > 1e-6


@pytest.mark.parametrize("method", METHODS)
def test_values_are_those_of_the_solve_on_the_whole(method, whole):
    vertices, faces = MESHES["irregular"]
    settings = FairingSettings(method=method, cg_tolerance=1e-12)
    values = np.random.default_rng(0).normal(size=(len(vertices), 2))
    weights = weights_around(vertices, 0, 0.05)

    def run():
        return fair_values(vertices, faces, values, settings, weights=weights)

    part, expected = run(), whole(run)
    np.testing.assert_allclose(part, expected, rtol=0, atol=EQUAL)
    assert np.abs(expected[-1] - values)[weights > 0].max() > 0.1


def test_the_work_is_that_of_the_part(monkeypatch):
    """A hexagon of 4 rings on a regular grid, and as many around it as the density takes in."""
    n_triangles = []

    class Counted(LoopSpace):
        def step_system(self, *given, **options):
            n_triangles.append(self.topology.n_triangles)
            return super().step_system(*given, **options)

    monkeypatch.setattr(prepared_surface, "LoopSpace", Counted)
    vertices, faces = MESHES["open"]
    middle = np.argmin(np.linalg.norm((vertices - vertices.mean(axis=0))[:, :2], axis=1))
    moves = np.arange(len(vertices)) == middle
    for _ in range(4):
        moves[faces[moves[faces].any(axis=1)]] = True
    settings = FairingSettings(steps=2)
    n_rings = 4 + local_density.margin_of_run(settings).n_rings
    fair(vertices, faces, settings, weights=moves)
    assert n_triangles == [6 * n_rings**2] * 2


def test_a_second_run_on_the_same_vertices_prepares_nothing(made_spaces):
    vertices, faces = MESHES["closed"]
    prepared = PreparedMesh(vertices, faces)
    weights = weights_around(vertices, 0, 0.02)
    first = fair(vertices, faces, weights=weights, prepared=prepared)
    again = fair(vertices, faces, weights=weights, prepared=prepared)
    assert len(made_spaces) == 1
    np.testing.assert_array_equal(first.positions, again.positions)
    elsewhere = weights_around(vertices, 1, 0.02)
    other = fair(vertices, faces, weights=elsewhere, prepared=prepared)
    alone = fair(vertices, faces, weights=elsewhere)
    np.testing.assert_array_equal(other.positions, alone.positions)
    assert len(made_spaces) == 3


def test_a_volume_that_is_kept_is_that_of_the_whole():
    vertices, faces = MESHES["closed"]
    weights = weights_around(vertices, 0, 0.05)
    volumes = []
    for positions in (
        vertices,
        fair(vertices, faces, FairingSettings(keep_volume=True), weights=weights).positions,
    ):
        a, b, c = positions[faces].swapaxes(0, 1)
        volumes.append(np.einsum("ij,ij->", np.cross(a, b), c) / 6)
    assert volumes[1] == pytest.approx(volumes[0], rel=1e-12)
