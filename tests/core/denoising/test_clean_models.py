"""Clean models of solids, which come back as they are."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import denoise
from adaptive_fairing.core.denoising import mesh_parts


def diagonal(points):
    return np.linalg.norm(np.ptp(points, axis=0))


def with_slivers(n):
    """A prism whose corners stand far out of flat ends."""
    return meshes.sliver_prism(n)


@pytest.mark.parametrize("n", [20, 60, 200])
def test_a_prism_of_slivers_does_not_move(n):
    points, faces = with_slivers(n)
    assert np.array_equal(denoise(points, faces).positions, points)


@pytest.mark.parametrize("n", [60, 200])
@pytest.mark.parametrize("digits", [4, 5, 7])
def test_rounding_its_coordinates_moves_no_vertex_by_more_than_a_thousandth(n, digits):
    points, faces = with_slivers(n)
    turn, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    points = np.round(points @ turn, digits - 1)
    moved = np.linalg.norm(denoise(points, faces).positions - points, axis=1)
    assert moved.max() <= 1e-3 * diagonal(points)


@pytest.mark.parametrize("n", [60, 200])
@pytest.mark.parametrize("seed", range(3))
def test_jitter_of_a_thousandth_moves_no_vertex_by_more_than_a_hundredth(n, seed):
    points, faces = with_slivers(n)
    jitter = np.random.default_rng(seed).normal(size=points.shape) / np.sqrt(3)
    points = points + 1e-3 * diagonal(points) * jitter
    moved = np.linalg.norm(denoise(points, faces).positions - points, axis=1)
    assert moved.max() <= 1e-2 * diagonal(points)


def test_hinges_are_what_tells(monkeypatch):
    """Without them the roughness of the corners is taken for noise."""
    points, faces = with_slivers(200)
    found = []
    judged = mesh_parts.MeshParts.noise

    def noise(self, *arguments, **options):
        found.append(judged(self, *arguments, **options))
        return found[-1]

    monkeypatch.setattr(mesh_parts.MeshParts, "noise", noise)
    denoise(points, faces)
    assert not found[0].level.any()
    assert np.median(found[0].roughness) > 0.1


def test_few_spikes_on_a_clean_model_are_left_as_they_are():
    """The apex of a cone stands out as a spike does."""
    points, faces = meshes.flat_grid(40, 40)
    apex = np.argmin(np.linalg.norm(points - points.mean(axis=0), axis=1))
    points[apex, 2] = 5.0
    assert np.array_equal(denoise(points, faces).positions, points)


@pytest.mark.parametrize("step", [0.1, 0.3])
def test_rounded_heights_are_denoised_as_those_that_are_not(step):
    """Quantised depths repeat each other; that decides nothing."""
    points, faces = meshes.flat_grid(60, 60)
    heights = 0.2 * np.random.default_rng(0).normal(size=len(points))
    left = []
    for quantum in (None, 0.2 * step):
        rounded = heights if quantum is None else quantum * np.round(heights / quantum)
        noisy = points + rounded[:, None] * [0, 0, 1]
        inside = np.all(np.abs(points[:, :2] - points[:, :2].mean(axis=0)) < 20, axis=1)
        left.append(denoise(noisy, faces).positions[inside, 2].std())
    assert left[0] < 0.05
    assert left[1] < 0.05


def rounded_cube(levels, roundness, twist):
    """A cube, rounded towards its ball and twisted, beside a larger ball."""
    points, faces = meshes.cube(levels)
    onto_ball = 1.2 * points / np.linalg.norm(points, axis=1, keepdims=True)
    points = (1 - roundness) * points + roundness * onto_ball
    x, y, z = points.T
    sine, cosine = np.sin(twist * z), np.cos(twist * z)
    points = np.column_stack([x * cosine - y * sine, x * sine + y * cosine, z])
    ball, ball_faces = meshes.icosphere(3)
    return meshes.merged((3 * ball, ball_faces), (points + np.array([10, 0, 0]), faces))


@pytest.mark.parametrize(
    ("levels", "roundness", "twist"), [(2, 0.2, 0.3), (2, 0.4, 0), (3, 0.4, 0.8)]
)
def test_corners_of_a_small_part_are_neither_spikes_nor_noise(levels, roundness, twist):
    """They stand out like spikes, but beside each other, so what is left of them is shape too."""
    points, faces = rounded_cube(levels, roundness, twist)
    result = denoise(points, faces)
    assert np.array_equal(result.positions, points)
    assert "nothing was changed" in result.notes[-1]


@pytest.mark.parametrize(
    ("coarse", "parts"),
    [
        (meshes.latlong_sphere(12, 8), 2),
        (meshes.latlong_sphere(12, 8), 5),
        (meshes.latlong_sphere(16, 10), 4),
        (meshes.latlong_sphere(20, 12), 4),
        (meshes.icosphere(2), 5),
    ],
)
def test_flat_facets_that_were_divided_are_no_noise(coarse, parts):
    """Corners of facets stand out as spikes do, and facets are as even as smooth noise."""
    points, faces = meshes.divided(*coarse, parts)
    turn, _ = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))
    # Of three sizes, turned and rounded: nothing is an exact copy.
    points = ((points * [1, 0.9, 0.8]) @ turn).astype(np.float32).astype(float)
    assert np.array_equal(denoise(points, faces).positions, points)
