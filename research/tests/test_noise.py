"""Noise and scans of the benchmark of denoising: as strong and as correlated as they say."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.special import erf
from support.meshes import icosphere

from research.denoising import noise, scans
from tools.geometry.triangles import (
    edges_of,
    local_edge_lengths,
    scaled_normals,
    vertex_normals,
)

AMPLITUDE = 0.1


def heights(ball, kind: str, amplitude: float = AMPLITUDE) -> np.ndarray:
    """Return the noise along the normals, over the local edge length."""
    vertices, faces = ball
    moves = noise.add_noise(vertices, faces, kind, amplitude, seed=3) - vertices
    normal = vertex_normals(vertices, faces)
    return np.einsum("nd,nd->n", moves, normal) / local_edge_lengths(vertices, faces)


@pytest.mark.parametrize(
    ("kind", "tolerance"),  # about three standard deviations: outliers and correlation widen them
    [("normal", 0.08), ("isotropic", 0.08), ("heavy-tailed", 0.16), ("correlated-2", 0.16)],
)
def test_noise_is_as_strong_as_it_says_everywhere(ball, kind, tolerance):
    vertices, faces = ball
    found = heights(ball, kind)
    edges = local_edge_lengths(vertices, faces)
    for part in (edges < np.median(edges), edges >= np.median(edges)):
        assert np.sqrt(np.mean(np.square(found[part]))) == pytest.approx(AMPLITUDE, rel=tolerance)


def test_uniform_noise_is_as_strong_in_lengths_everywhere(ball):
    edges = local_edge_lengths(*ball)
    lengths = heights(ball, "uniform") * edges
    for part in (edges < np.median(edges), edges >= np.median(edges)):
        expected = AMPLITUDE * edges.mean()
        assert np.sqrt(np.mean(np.square(lengths[part]))) == pytest.approx(expected, rel=0.08)


def test_growing_noise_is_as_strong_as_it_says_and_grows_along_an_axis(ball):
    found = np.square(heights(ball, "growing"))[np.argsort(ball[0][:, 0])] / AMPLITUDE**2
    ends = np.array_split(found, 4)
    assert found.mean() == pytest.approx(1, rel=0.16)
    # A quarter has the mean of 3 q² over its places q.
    assert ends[0].mean() == pytest.approx(1 / 16, rel=0.32)
    assert ends[3].mean() == pytest.approx(37 / 16, rel=0.32)


def test_only_isotropic_noise_moves_sideways(ball):
    vertices, faces = ball
    edges = local_edge_lengths(vertices, faces)
    for kind in noise.KINDS:
        moves = noise.add_noise(vertices, faces, kind, AMPLITUDE, seed=3) - vertices
        normal = vertex_normals(vertices, faces)
        sideways = np.linalg.norm(np.cross(moves, normal), axis=1) / edges
        expected = AMPLITUDE * 2**0.5 if kind == "isotropic" else 0.0
        assert np.sqrt(np.mean(np.square(sideways))) == pytest.approx(expected, rel=0.08, abs=1e-12)


def test_correlated_noise_is_shared_over_the_length_it_says(ball):
    """The correlation at distance r is exp(-(r / length)²), r in edges."""
    vertices, faces = icosphere(5)
    points, edge = vertices[::7], local_edge_lengths(vertices, faces).mean()
    first, second = np.triu_indices(len(points), 1)
    distance = np.linalg.norm(points[first] - points[second], axis=1) / edge
    for length in noise.CORRELATION_LENGTHS:
        found = heights((vertices, faces), f"correlated-{length}")[::7]
        shell = np.abs(distance / length - 1) < 0.2
        expected = np.mean(np.exp(-np.square(distance[shell] / length)))
        # There are about n / length² independent places. Two passes are not quite a Gaussian yet.
        error = 3 * length / len(vertices) ** 0.5 + 0.2 / length**2
        products = found[first[shell]] * found[second[shell]] / AMPLITUDE**2
        assert np.mean(products) == pytest.approx(expected, abs=error)


def test_other_noise_is_not_shared_by_neighbours(ball):
    first, second = edges_of(ball[1]).T
    for kind in noise.KINDS:
        if not kind.startswith("correlated"):
            found = heights(ball, kind)
            assert abs(np.corrcoef(found[first], found[second])[0, 1]) < 0.05


def test_impulsive_noise_leaves_most_vertices_where_they_are(ball):
    found = heights(ball, "impulsive")
    hit = np.abs(found) > 1e-12
    assert hit.mean() == pytest.approx(noise.SPIKES, abs=0.03)
    assert np.sqrt(np.mean(np.square(found))) == pytest.approx(AMPLITUDE, rel=0.1)


def test_heavy_tailed_noise_has_the_quantiles_of_the_contaminated_normal(ball):
    found = np.abs(heights(ball, "heavy-tailed")) / AMPLITUDE
    scale = (1 + noise.OUTLIERS * (noise.OUTLIER_SCALE**2 - 1)) ** -0.5
    for share in (0.5, 0.9, 0.98):
        level = np.quantile(found, share) / scale
        below = (1 - noise.OUTLIERS) * erf(level / 2**0.5)
        below += noise.OUTLIERS * erf(level / noise.OUTLIER_SCALE / 2**0.5)
        spread = (share * (1 - share) / len(found)) ** 0.5
        assert below == pytest.approx(share, abs=4 * spread)


@pytest.fixture(scope="module")
def scanned() -> tuple[np.ndarray, np.ndarray]:
    """Make a fine sphere of radius 1, for scanners to look at."""
    return icosphere(5)


@pytest.mark.parametrize("scan", [scans.depth_camera, scans.range_scanner])
def test_a_scan_shows_the_surface_and_errs_along_the_line_of_sight(scanned, scan):
    clean, noisy, faces = scan(*scanned, 0.5, np.random.default_rng(1))
    pixel = scans.PIXEL * local_edge_lengths(*scanned).mean()
    sagitta = np.square(1.1 * local_edge_lengths(*scanned).max()) / 2
    radius = np.linalg.norm(clean, axis=1)
    assert 1 - sagitta < radius.min() and radius.max() < 1 + 1e-6
    toward = scans.VIEW / np.linalg.norm(scans.VIEW)
    assert (scaled_normals(clean, faces) @ toward).min() > 0  # all are seen from the front
    moved = noisy - clean
    np.testing.assert_allclose(np.cross(moved, toward), 0, atol=1e-12)
    if scan is scans.range_scanner:
        facing = clean @ toward > 0.9
        error = np.sqrt(np.mean(np.square(moved[facing] @ toward * (clean[facing] @ toward))))
        assert error == pytest.approx(0.5 * pixel, rel=0.1)


def test_errors_of_a_depth_camera_are_as_alike_as_measured(scanned):
    clean, noisy, _ = scans.depth_camera(*scanned, 0.3, np.random.default_rng(1))
    toward = scans.VIEW / np.linalg.norm(scans.VIEW)
    error = (noisy - clean) @ toward
    pixel = scans.PIXEL * local_edge_lengths(*scanned).mean()
    flat = clean - np.outer(clean @ toward, toward)
    tree = cKDTree(flat)
    for rings, expected in ((1, 0.84), (2, 0.5), (3, 0.21)):  # exp(-rings² / (4 FILTER²))
        pairs_of_pixels = tree.query_pairs(pixel * (rings + 0.1), output_type="ndarray")
        gaps = np.linalg.norm(flat[pairs_of_pixels[:, 0]] - flat[pairs_of_pixels[:, 1]], axis=1)
        first, second = pairs_of_pixels[gaps > pixel * (rings - 0.1)].T
        found = np.corrcoef(error[first], error[second])[0, 1]
        assert found == pytest.approx(expected, abs=0.06)


def test_noise_is_the_same_on_every_run(ball):
    once, again = (noise.add_noise(*ball, "normal", AMPLITUDE, seed=5) for _ in range(2))
    np.testing.assert_array_equal(once, again)
    other = noise.add_noise(*ball, "normal", AMPLITUDE, seed=6)
    assert np.abs(other - once).max() > 0
