"""Denoising without a parameter: removal of the noise, preservation of the shape."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import (
    DenoiseSettings,
    FairingSettings,
    denoise,
    fair,
)
from adaptive_fairing.core.denoising.parameters import PARAMETERS

FREE = DenoiseSettings(boundary="free")
TORUS = meshes.torus(48, 24)


def torus_normals(vertices, major=2.0):
    around = vertices * [1, 1, 0]
    centre = major * around / np.linalg.norm(around, axis=1, keepdims=True)
    away = vertices - centre
    return away / np.linalg.norm(away, axis=1, keepdims=True)


def noisy_torus(amplitude=0.05, seed=0):
    vertices, faces = TORUS
    noise = amplitude * np.random.default_rng(seed).normal(size=(len(vertices), 1))
    return vertices + noise * torus_normals(vertices), faces


def distance_to_torus(points, major=2.0, minor=1.0):
    ring = np.hypot(points[:, 0], points[:, 1]) - major
    return np.sqrt(np.mean((np.hypot(ring, points[:, 2]) - minor) ** 2))


def block(n=12):
    """A cube of n³ cells with sharp edges: distance to it is exact."""
    u, v = np.meshgrid(np.linspace(-1, 1, n + 1), np.linspace(-1, 1, n + 1), indexing="ij")
    side = np.stack([u, v, np.ones_like(u)], axis=-1).reshape(-1, 3)
    turns = [np.roll(np.eye(3), k, axis=0) for k in range(3)]
    sides = [side @ turn * sign for turn in turns for sign in (1, -1)]
    points = np.unique(np.round(np.concatenate(sides), 12), axis=0)
    cells = []
    for corner in sides:
        index = np.array([np.argmin(((points - p) ** 2).sum(axis=1)) for p in corner])
        grid = index.reshape(n + 1, n + 1)
        a, b, c, d = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
        cells += [np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)]
    faces = np.concatenate(cells)
    normals = np.cross(
        points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]]
    )
    inward = (normals * points[faces].mean(axis=1)).sum(axis=1) < 0
    faces[inward] = faces[inward][:, [0, 2, 1]]
    return points, faces


def distance_to_block(points):
    outside = np.maximum(np.abs(points) - 1, 0)
    inside = np.abs(1 - np.abs(points).max(axis=1))
    is_inside = np.abs(points).max(axis=1) < 1
    return np.sqrt(np.mean(np.where(is_inside, inside, np.linalg.norm(outside, axis=1)) ** 2))


@pytest.fixture(scope="module")
def torus_result():
    points, faces = noisy_torus()
    return denoise(points, faces)


def test_a_noisy_torus_comes_nearer_to_the_torus_than_by_any_uniform_diffusion(torus_result):
    points, faces = noisy_torus()
    left = distance_to_torus(torus_result.positions)
    assert left < 0.36 * distance_to_torus(points)
    uniform = [
        distance_to_torus(fair(points, faces, FairingSettings("uniform", tau, 4)).positions)
        for tau in (0.001, 0.002, 0.004, 0.008, 0.016)
    ]
    assert 0 < np.argmin(uniform) < 4
    assert left < 0.8 * min(uniform)


def test_the_noise_is_found_in_edges_and_in_units_of_the_object(torus_result):
    assert torus_result.noise_length == pytest.approx(0.05, rel=0.15)
    assert torus_result.noise_level == np.median(torus_result.noise[torus_result.noise > 0])
    assert torus_result.radius > 0.5
    assert not torus_result.is_sharp
    assert torus_result.crease_part < 0.001


@pytest.mark.parametrize("name", ["torus", "sphere", "block"])
def test_a_clean_mesh_comes_back_bit_by_bit(name):
    vertices, faces = {"torus": TORUS, "sphere": meshes.graded_sphere(3), "block": block()}[name]
    result = denoise(vertices, faces)
    assert np.array_equal(result.positions, vertices)
    assert not result.is_changed
    assert "no noise found" in result.notes[-1]


@pytest.mark.parametrize("place", [0.0, 0.1, 1e5])
def test_an_exactly_flat_mesh_comes_back_bit_by_bit(place):
    """Its roughness is 0, or what rounding leaves: no scale for the estimate to hold on to."""
    vertices, faces = meshes.flat_grid(20, 20)
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0] if place else np.eye(3)
    flat = vertices @ turn + place
    for settings in (None, FREE):
        result = denoise(flat, faces, settings)
        assert np.array_equal(result.positions, flat)
        assert "no noise found" in result.notes[-1]


def test_edges_of_a_block_stay_sharp():
    vertices, faces = block()
    rng = np.random.default_rng(0)
    points = vertices + 0.03 * rng.normal(size=vertices.shape)
    result = denoise(points, faces)
    assert result.is_sharp
    # 144 of the block's 1296 edges are its creases; what noise is left breaks some of them up.
    assert 0.03 < result.crease_part < 144 / 1296
    smooth = denoise(points, faces, DenoiseSettings(features="smooth"))
    assert smooth.sharp_part == 0
    assert distance_to_block(result.positions) < 0.8 * distance_to_block(smooth.positions)
    assert distance_to_block(result.positions) < 0.5 * distance_to_block(points)
    sharp = denoise(points, faces, DenoiseSettings(features="sharp"))
    assert sharp.sharp_part == pytest.approx(1)


def test_parts_of_different_noise_are_judged_each_by_itself():
    points, faces = noisy_torus()
    clean = TORUS[0] + [9, 0, 0]
    both = np.concatenate([points, clean])
    result = denoise(both, np.concatenate([faces, faces + len(points)]))
    assert np.array_equal(result.positions[len(points) :], clean)
    assert distance_to_torus(result.positions[: len(points)]) < 0.35 * distance_to_torus(points)


def test_repeated_runs_are_equal_to_the_last_bit(torus_result):
    points, faces = noisy_torus()
    assert np.array_equal(denoise(points, faces).positions, torus_result.positions)


POSES = ("turned", "mirrored", "other side", "renumbered", "reordered", "moved a little")


@pytest.mark.parametrize("pose", POSES)
def test_the_same_mesh_gives_the_same_result(torus_result, pose):
    """Up to a thousandth of what is removed, whatever its pose, numbering and orientation."""
    points, faces = noisy_torus()
    generator = np.random.default_rng(1)
    order, turn, size, place = np.arange(len(points)), np.eye(3), 1.0, np.zeros(3)
    if pose == "turned":
        turn = np.linalg.qr(generator.normal(size=(3, 3)))[0]
        turn *= np.linalg.det(turn)
        size, place = 1e3, np.array([5e3, 0, 1e3])
    elif pose == "mirrored":
        turn = np.diag([-1.0, 1, 1])
    elif pose == "other side":
        faces = faces[:, ::-1]
    elif pose == "renumbered":
        order = generator.permutation(len(points))
        faces = np.argsort(order)[faces]
    elif pose == "reordered":
        faces = np.roll(generator.permutation(faces), 1, axis=1)
    else:
        points = points + 1e-12 * generator.normal(size=points.shape)
    result = denoise(size * points[order] @ turn + place, faces)
    back = np.empty_like(points)
    back[order] = (result.positions - place) @ turn.T / size
    removed = np.linalg.norm(torus_result.positions - points)
    assert np.linalg.norm(back - torus_result.positions) < 1e-3 * removed
    assert result.noise_level == pytest.approx(torus_result.noise_level, rel=1e-6)


def test_held_vertices_stay_and_shares_scale_the_displacement():
    points, faces = noisy_torus()
    weights = np.ones(len(points))
    weights[:100], weights[100:200] = 0, 0.5
    result = denoise(points, faces, weights=weights)
    full = denoise(points, faces, weights=np.ceil(weights)).positions - points
    part = result.positions - points
    assert np.array_equal(result.positions[:100], points[:100])
    np.testing.assert_allclose(part[100:200], 0.5 * full[100:200], atol=1e-9)
    np.testing.assert_allclose(part[200:], full[200:], atol=1e-9)
    assert (np.linalg.norm(part[100:], axis=1) > 0).all()


def test_noise_is_not_judged_from_held_vertices(torus_result):
    """A half that an earlier run has denoised does not make the other half look clean."""
    points, faces = noisy_torus()
    is_done = points[:, 2] < 0
    after = np.where(is_done[:, None], torus_result.positions, points)
    result = denoise(after, faces, weights=~is_done)
    assert result.noise_level == pytest.approx(torus_result.noise_level, rel=0.1)
    assert distance_to_torus(result.positions[~is_done]) < 0.4 * distance_to_torus(points[~is_done])


def test_a_boundary_is_held_or_faired_with_the_rest():
    vertices, faces = meshes.open_cylinder(64, 32)
    rng = np.random.default_rng(0)
    points = vertices + 0.02 * rng.normal(size=(len(vertices), 1)) * (vertices * [1, 1, 0])
    border = meshes.boundary_vertices(faces)

    def left(positions, which):
        return np.sqrt(np.mean((np.hypot(*positions[which, :2].T) - 1) ** 2))

    fixed, free = denoise(points, faces), denoise(points, faces, FREE)
    assert np.array_equal(fixed.positions[border], points[border])
    assert left(free.positions, border) < 0.6 * left(points, border)
    everything = np.arange(len(points))
    assert left(free.positions, everything) < 0.4 * left(points, everything)


def test_noise_of_one_amplitude_goes_where_triangles_are_large_too():
    """There it is a smaller part of an edge, smaller than the roughness of clean meshes."""
    vertices, faces = meshes.flat_grid(60, 60)
    growing = np.cumsum(np.geomspace(0.3, 3, 61))
    plate = vertices.copy()
    plate[:, :2] = np.stack(np.meshgrid(growing, growing, indexing="ij"), axis=-1).reshape(-1, 2)
    height = 0.07 * np.random.default_rng(0).normal(size=len(plate))
    left = denoise(plate + height[:, None] * [0, 0, 1], faces).positions[:, 2]
    is_large = (plate[:, :2] > growing[45]).all(axis=1) & (plate[:, :2] < growing[58]).all(axis=1)
    assert 0.07 / np.diff(growing)[45:].min() < PARAMETERS.clean_roughness
    assert np.std(left[is_large]) < 0.3 * np.std(height[is_large])


def test_progress_rises_to_one_and_may_end_the_run():
    points, faces = noisy_torus()
    seen = []
    plan = denoise(points, faces, progress=seen.append).plan
    done = [each.fraction_done for each in seen]
    assert done == sorted(done)
    assert done[-1] == 1
    assert len(seen) > 30, "too seldom to end a run"
    phases = list(dict.fromkeys(seen[:-1]))
    filters = [("filter", number, 5) for number in range(1, 6)]
    measured = [each[:3] for each in phases]
    assert measured == [("noise", 0, 0), *filters, ("mix", 0, 0), ("measure", 0, 0)]
    begins = [each.fraction_done for each in phases]
    assert [each.fraction_at_end for each in phases] == [*begins[1:], 1.0]
    again = []
    denoise(points, faces, plan=plan, progress=again.append)
    assert [each[:3] for each in dict.fromkeys(again[:-1])] == measured
    assert again[0].fraction_at_end == 0, "nothing is measured with a plan"

    def cancel(progress):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        denoise(points, faces, progress=cancel)


@pytest.mark.parametrize("chosen", [{"clean": "keep"}, {"clean": "denoise"}, {"width": 2}])
def test_too_few_vertices_are_left_alone(chosen):
    vertices, faces = meshes.icosahedron()
    result = denoise(vertices, faces, DenoiseSettings(**chosen))
    assert np.array_equal(result.positions, vertices)
    assert "only 12 vertices" in result.notes[-1]
