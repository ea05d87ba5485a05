"""Simulated devices: their errors lie where they should, as strong and as wide as they say."""

from __future__ import annotations

import numpy as np
import pytest
from support.meshes import flat_grid, icosphere

from research.denoising import devices, scans
from tools.geometry.triangles import edges_of, local_edge_lengths, vertex_normals


@pytest.fixture(scope="module")
def ball() -> tuple[np.ndarray, np.ndarray]:
    """Make a fine sphere of radius 1."""
    return icosphere(5)


def test_structured_light_errs_along_the_rays_and_leaves_spots_out(ball):
    clean, noisy, faces = devices.structured_light(*ball, 1.0, np.random.default_rng(1))
    pixel = scans.PIXEL * local_edge_lengths(*ball).mean()
    whole = scans.depth_camera(*ball, 1.0, np.random.default_rng(1))[0]
    missing = 1 - len(clean) / len(whole)
    assert 0.5 * devices.MISSING < missing < 2 * devices.MISSING
    toward = scans.VIEW / np.linalg.norm(scans.VIEW)
    move = noisy - clean
    along = move @ toward
    np.testing.assert_allclose(move, along[:, None] * toward, atol=1e-12)
    # Matching, rounding by up to half a step, drawn to pixels; smoothing takes some of it away.
    most = np.sqrt(devices.MATCHING**2 + 1 / 12 + devices.LOCKING**2 / 2)
    assert 0.5 * most < np.std(along) / pixel < most
    assert len(faces) > 1.8 * len(clean)


def test_without_error_of_the_matching_the_depth_comes_in_smoothed_steps(monkeypatch):
    """A plane that faces the camera has one disparity, and comes back flat."""
    vertices, faces = flat_grid(30, 30)
    x, y, _ = scans.DepthImage(vertices, faces, 1.0, 1.0).frame
    facing = vertices[:, :1] * x + vertices[:, 1:2] * y
    monkeypatch.setattr(devices, "MATCHING", 0.0)
    clean, noisy, _ = devices.structured_light(facing, faces, 1.0, np.random.default_rng(1))
    assert np.ptp(noisy - clean, axis=0) == pytest.approx(0, abs=1e-9)


def test_bumps_are_as_high_as_they_say_and_longer_one_way(ball):
    vertices, faces = ball
    noisy = devices.photogrammetry(vertices, faces, 0.2, np.random.default_rng(2))[1]
    normal, edge = vertex_normals(vertices, faces), local_edge_lengths(vertices, faces).mean()
    move = noisy - vertices
    height = np.einsum("nd,nd->n", move, normal)
    np.testing.assert_allclose(move, height[:, None] * normal, atol=1e-12)
    assert np.sqrt(np.mean(height**2)) == pytest.approx(0.2 * edge)
    # The squared slope along a direction d is d C d; C has an axis along the bumps.
    first, second = edges_of(faces).T
    ways = (vertices[first] - vertices[second]) / edge
    products = np.einsum("ki,kj->kij", ways, ways).reshape(-1, 9)
    squares = (height[first] - height[second]) ** 2
    slopes = np.linalg.eigvalsh(np.linalg.lstsq(products, squares, rcond=None)[0].reshape(3, 3))
    # Where they are higher by chance, the directions there count more.
    assert np.sqrt(slopes[1] / slopes[0]) > 1.6


@pytest.mark.parametrize("amplitude", [0.0, 0.3])
def test_the_views_of_a_volume_agree_on_the_surface(amplitude):
    """The fused distances are those to the sphere, but for what the views err on average."""
    vertices, faces = icosphere(4)
    cell = 0.1
    generator = np.random.default_rng(1)
    fused, origin = devices.fused_distances(vertices, faces, amplitude, cell, generator)
    radius = np.linalg.norm(origin + cell * np.moveaxis(np.indices(fused.shape), 0, -1), axis=-1)
    true = (1 - radius) / cell
    near = np.abs(true) < 1
    error = (fused - true)[near]
    far = np.abs(true) > devices.TRUNCATION + 1
    assert (np.sign(fused[far]) == np.sign(true[far])).all()
    # A pixel sees the middle of its square; about a quarter of the views see a place well.
    assert np.abs(np.median(error)) < 0.1
    assert error.std() < 0.12 + amplitude / np.sqrt(devices.VIEWS / 4)
