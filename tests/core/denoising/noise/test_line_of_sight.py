"""Line of sight of a depth camera, recovered from its mesh alone."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import DenoiseSettings, TriangleTopology, denoise
from adaptive_fairing.core.denoising.noise.line_of_sight import (
    lines_of_sight,
    on_rays,
    shows_object,
)
from adaptive_fairing.core.denoising.noise.noisy_surface import NoisySurface
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface

GRID, FACES = meshes.flat_grid(70, 70)
TOPOLOGY = TriangleTopology(FACES, len(GRID))
TURN = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
SIGHT = TURN[2]
PARALLEL = np.tile(SIGHT, (len(GRID), 1))


def depths():
    """A steep and a facing part that meet at a crease, both slightly twisted, seen along z."""
    return np.maximum(1.5 * (GRID[:, 0] - 35), 0) + (0.2 + 1e-4 * GRID[:, 0]) * GRID[:, 1]


def smooth(passes=4, seed=0):
    surface = TriangleSurface(TOPOLOGY, GRID)
    heights = surface.spread(np.random.default_rng(seed).normal(size=len(GRID)), passes)
    return heights / heights.std()


def seen(depth):
    """The image of a depth camera, turned."""
    return np.column_stack([GRID[:, :2], depth]) @ TURN


@pytest.mark.parametrize("noise", [0, 0.3])
def test_it_is_the_direction_along_which_depths_vary(noise):
    found = lines_of_sight(TOPOLOGY, seen(depths() + noise * smooth()))
    np.testing.assert_allclose(np.abs(found @ SIGHT), 1, atol=1e-9)


def cut_either_way(seed=0):
    """Triangles of the grid whose cells are cut along one diagonal or the other."""
    first = np.arange(len(GRID)).reshape(71, 71)[:-1, :-1].ravel()
    corners = np.stack([first, first + 1, first + 72, first + 71], axis=1)
    is_other = np.random.default_rng(seed).random(len(first)) < 0.5
    corners[is_other] = np.roll(corners[is_other], 1, axis=1)
    return np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])


@pytest.mark.parametrize("noise", [0, 0.3])
def test_cells_may_be_cut_along_either_diagonal(noise):
    topology = TriangleTopology(cut_either_way(), len(GRID))
    found = lines_of_sight(topology, seen(depths() + noise * smooth()))
    np.testing.assert_allclose(np.abs(found @ SIGHT), 1, atol=1e-9)


def test_noise_in_rounded_depths_is_found():
    """A third of the hinges are flat then, as in clean models."""
    bent, step = 0.002 * np.square(GRID[:, 0] - 35), 0.2
    noise = np.random.default_rng(4).normal(0, 0.08, len(GRID))
    depth = step * np.round((bent + noise) / step)
    result = denoise(seen(depth), cut_either_way(), DenoiseSettings(boundary="free"))
    left = (result.positions - seen(bent)) @ SIGHT
    assert np.std(left) < 0.3 * np.std(depth - bent)


def without_a_corner():
    """Triangles of the grid but those at one of its corners: their outline is not convex."""
    is_at_corner = (GRID[FACES, :2].mean(axis=1) > 50).all(axis=1)
    return FACES[~is_at_corner]


def terrain(seed):
    """Heights whose waves grow in proportion to their length, three edges in all."""
    n = 71
    frequency = np.hypot(np.fft.fftfreq(n)[:, None], np.fft.fftfreq(n))
    frequency[0, 0] = 1
    white = np.fft.fft2(np.random.default_rng(seed).normal(size=(n, n)))
    heights = np.fft.ifft2(white / frequency**2).real.ravel()
    return 3 * heights / heights.std()


def test_an_object_does_not_fill_its_outline_and_a_near_camera_sees_no_terrain():
    points = seen(depths() + 0.3 * smooth())
    assert not shows_object(TOPOLOGY, points, PARALLEL)
    assert shows_object(TriangleTopology(without_a_corner(), len(GRID)), points, PARALLEL)
    rays = near_rays() / np.linalg.norm(near_rays(), axis=1)[:, None]
    assert shows_object(TOPOLOGY, 50 * rays, rays)


def test_a_wall_that_is_seen_along_itself_shows_nothing():
    along_wall = np.tile([0.0, 1.0, 0.0], (len(GRID), 1))
    assert not shows_object(TOPOLOGY, GRID, along_wall)


@pytest.mark.parametrize("seed", range(3))
def test_waves_that_grow_with_their_length_are_kept_on_terrain_alone(seed):
    """On an object they may be the noise of structured light."""
    whole, part = (
        denoise(seen(terrain(seed)), faces, DenoiseSettings(boundary="free"))
        for faces in (FACES, without_a_corner())
    )
    assert np.array_equal(whole.positions, seen(terrain(seed)))
    assert "uniformly rough" in whole.notes[0]
    assert "it was removed" in part.notes[0]


def test_rays_of_a_near_camera_meet_where_it_is():
    """Rays are up to 27 degrees off the middle, and depths up to 40 % apart."""
    rays = near_rays()
    points = rays * (1 + 0.01 * smooth() + 0.005 * depths())[:, None] + [3, -2, 5]
    found = lines_of_sight(TOPOLOGY, points @ TURN) @ TURN.T
    cosines = np.abs(np.einsum("nd,nd->n", found, rays)) / np.linalg.norm(rays, axis=1)
    assert cosines.min() > np.cos(np.radians(0.5))


def near_rays():
    across = GRID[:, :2] - GRID[:, :2].mean(axis=0)
    across /= 2 * np.linalg.norm(across, axis=1).max()
    return np.column_stack([across, np.ones(len(GRID))])


def test_other_meshes_have_none():
    for points, faces in (meshes.icosphere(4), meshes.torus(40, 20), meshes.noisy_ball()):
        assert lines_of_sight(TriangleTopology(faces, len(points)), points) is None
    # Noise along the normals of a grid is not along one line.
    bowl = np.column_stack([GRID[:, :2], 0.01 * np.square(GRID[:, :2] - 35).sum(axis=1)])
    surface = TriangleSurface(TOPOLOGY, bowl)
    assert lines_of_sight(TOPOLOGY, bowl + surface.raised(0.3 * smooth())) is None


def test_depth_noise_is_even_in_its_unit():
    """In local edge lengths it is less on the steep plane."""
    points = seen(depths() + 0.2 * smooth())
    frame = TriangleSurface(TOPOLOGY, seen(depths()))
    surface = NoisySurface(points, frame)
    in_unit = surface.in_unit(~TOPOLOGY.on_boundary)
    is_steep = GRID[:, 0] > 36
    ratios = []
    for each in (surface, in_unit):
        heights = each.frame.along_normal(points - frame.positions)
        ratios.append(heights[is_steep].std() / heights[~is_steep].std())
    samples = np.array([smooth(seed=seed)[is_steep].std() for seed in range(20)])
    assert ratios[0] < 0.5
    assert ratios[1] == pytest.approx(1, abs=4 * samples.std())
    assert np.median(in_unit.frame.spacing) == pytest.approx(np.median(frame.spacing))


def test_the_level_follows_the_angle_at_which_the_surface_is_seen():
    """σ |n · v| / h, of noise σ along the line of sight v."""
    result = denoise(seen(depths() + 0.3 * smooth()), FACES)
    assert "removed" in result.notes[0]
    clean = TriangleSurface(TOPOLOGY, seen(depths()))
    expected = 0.3 * np.abs(clean.normals @ SIGHT) / clean.spacing
    is_inner = (result.noise > 0) & (np.abs(GRID[:, 0] - 35) > 3)
    ratio = result.noise[is_inner] / expected[is_inner]
    assert np.median(ratio) == pytest.approx(1, abs=0.15)
    assert np.std(np.log(ratio)) < 0.2


def plane(points):
    """Depth of a tilted plane."""
    return 0.5 * points[:, 0] - 0.3 * points[:, 1] + 2


def test_points_go_along_their_rays_onto_the_triangles_around():
    """However far these were moved along the surface, and beyond its boundary."""
    across = GRID[:, :2] + 0.3 * np.random.default_rng(0).uniform(-1, 1, (len(GRID), 2))
    faired = np.column_stack([across, plane(across)]) @ TURN
    surface = TriangleSurface(TOPOLOGY, faired)
    found = on_rays(surface, seen(5 * smooth()), PARALLEL) @ TURN.T
    np.testing.assert_allclose(found, np.column_stack([GRID[:, :2], plane(GRID)]), atol=1e-9)


def test_points_near_a_crease_go_onto_the_triangle_that_their_ray_meets():
    faired = seen(np.abs(GRID[:, 0] - 35))
    off_grid = (faired @ TURN.T + [0.25, 0, 7]) @ TURN
    found = on_rays(TriangleSurface(TOPOLOGY, faired), off_grid, PARALLEL) @ TURN.T
    # In every other row a vertex is on the crease.
    is_exact = ~TOPOLOGY.on_boundary & (GRID[:, 0] % 1 == 0)
    expected = np.abs(GRID[:, 0] + 0.25 - 35)
    np.testing.assert_allclose(found[is_exact, 2], expected[is_exact], atol=1e-9)


@pytest.mark.parametrize("boundary", ["fixed", "free"])
def test_what_a_depth_camera_saw_stays_on_its_rays(boundary):
    noisy = seen(depths() + 0.3 * smooth())
    result = denoise(noisy, FACES, DenoiseSettings(boundary=boundary))
    moved = (result.positions - noisy) @ TURN.T
    assert np.abs(moved[:, :2]).max() < 1e-9 * np.abs(moved[:, 2]).max() * len(GRID)
    off = (result.positions - seen(depths())) @ SIGHT
    is_judged = ~TOPOLOGY.on_boundary | (boundary == "free")
    assert off[is_judged].std() < 0.6 * 0.3
