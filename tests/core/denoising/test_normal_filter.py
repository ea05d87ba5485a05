"""Triangle normals smoothed within the sides of creases, and surfaces fitted to them."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import TriangleTopology
from adaptive_fairing.core.denoising.filters import FilterBank, NormalFamily
from adaptive_fairing.core.denoising.normal_filter import (
    Smoothing,
    TurningLoads,
    smoothed_normals,
    triangles_around,
    weights_of_normals,
)
from adaptive_fairing.core.denoising.parameters import PARAMETERS
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface
from adaptive_fairing.core.mesh.normals import triangle_normals, unit_vectors

ANGLE = np.radians(60)


def roof(n=24, noise=0.0, seed=0):
    """Two planes that meet at a right angle along a row of a grid, and the faces of each."""
    flat, faces = meshes.flat_grid(n, n)
    across = flat[:, 1] - np.median(flat[:, 1])
    vertices = flat - [0, 0, 1] * np.abs(across)[:, None]
    vertices[:, 2] += noise * np.random.default_rng(seed).normal(size=len(vertices))
    sides = across[faces]
    return vertices, faces, sides.max(axis=1) <= 0, sides.min(axis=1) >= 0


def normals_of(vertices, faces):
    return unit_vectors(triangle_normals(vertices, faces))


def test_triangles_around_are_those_within_two_edges():
    vertices, faces = meshes.flat_grid(5, 5)
    topology = TriangleTopology(faces, len(vertices))
    edges = [{tuple(sorted((f[k], f[k - 1]))) for k in range(3)} for f in faces.tolist()]
    touch = [
        {j for j, other in enumerate(edges) if other & own} - {i} for i, own in enumerate(edges)
    ]
    for index, around in enumerate(triangles_around(topology).T):
        beyond = set().union(*(touch[j] for j in touch[index]))
        assert set(around.tolist()) - {len(faces)} == (touch[index] | beyond) - {index}


def shortest_turn(before, after):
    """Rodrigues' formula."""
    axis, cosine = np.cross(before, after), before @ after
    x, y, z = axis
    across = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return cosine * np.eye(3) + across + np.outer(axis, axis) / (1 + cosine)


def filtered(noisy, surface, family):
    return FilterBank(noisy, lambda report: None).filtered(noisy, surface, [family])


def test_the_load_is_that_of_the_shortest_turns_of_the_tangents():
    """Σ over triangles of ∫ (∇x - R ∇x) · ∇φ, with dense gradients."""
    vertices, faces = meshes.random_closed(1)
    normals = normals_of(vertices, faces)
    turned = unit_vectors(normals + np.random.default_rng(0).normal(0, 0.4, normals.shape))
    expected = np.zeros_like(vertices)
    for triangle, before, after in zip(faces, normals, turned, strict=True):
        a, b, c = vertices[triangle]
        normal = np.cross(b - a, c - a)
        gradients = np.cross(normal, [c - b, a - c, b - a]) / (normal @ normal)
        # ∇x has a row for every coordinate, ∇φ_k is a row of `gradients`.
        slopes = np.array([a, b, c]).T @ gradients
        bent = slopes - shortest_turn(before, after) @ slopes
        expected[triangle] += np.linalg.norm(normal) / 2 * gradients @ bent.T
    surface = TriangleSurface(TriangleTopology(faces, len(vertices)), vertices)
    load = TurningLoads(surface).of(turned)
    np.testing.assert_allclose(load, expected, atol=1e-12)


def test_a_triangle_without_area_is_not_turned():
    nothing = np.zeros((1, 3))
    around = np.full((9, 1), 1)
    (smooth,) = smoothed_normals(nothing, around, Smoothing(ANGLE, (1,)))
    assert not smooth.any()


def test_normals_that_are_alike_stay():
    vertices, faces = meshes.flat_grid(6, 6)
    normals = normals_of(vertices, faces)
    around = triangles_around(TriangleTopology(faces, len(vertices)))
    (smooth,) = smoothed_normals(normals, around, Smoothing(ANGLE, (5,)))
    np.testing.assert_allclose(smooth, normals, atol=1e-6)  # in single precision


def test_normals_are_given_after_each_number_of_passes():
    vertices, faces, *_ = roof(noise=0.1)
    normals = normals_of(vertices, faces)
    around = triangles_around(TriangleTopology(faces, len(vertices)))
    both = list(smoothed_normals(normals, around, Smoothing(ANGLE, (2, 5))))
    for smooth, passes in zip(both, (2, 5), strict=True):
        (alone,) = smoothed_normals(normals, around, Smoothing(ANGLE, (passes,)))
        assert np.array_equal(smooth, alone)


def test_the_mean_of_normals_is_weighted():
    """With weights w the normal is the mean of w (n · n' - cos)² n' over the triangles around."""
    vertices, faces, *_ = roof(noise=0.1)
    normals = normals_of(vertices, faces)
    around = triangles_around(TriangleTopology(faces, len(vertices)))
    weights = np.random.default_rng(1).uniform(0.5, 2, len(faces))
    (smooth,) = smoothed_normals(normals, around, Smoothing(ANGLE, (1,)), weights)
    expected = np.empty_like(normals)
    for each, own in enumerate(normals):
        several = [each, *(other for other in around[:, each] if other < len(faces))]
        apart = np.maximum(normals[several] @ own - np.cos(ANGLE), 0)
        expected[each] = (weights[several] * apart**2) @ normals[several]
    np.testing.assert_allclose(smooth, unit_vectors(expected), atol=1e-6)
    (alike,) = smoothed_normals(normals, around, Smoothing(ANGLE, (1,)), np.full(len(faces), 3.0))
    (plain,) = smoothed_normals(normals, around, Smoothing(ANGLE, (1,)))
    np.testing.assert_allclose(alike, plain, atol=1e-6)


def test_normals_count_by_the_noise_of_their_corners():
    vertices, faces = meshes.flat_grid(4, 4)
    topology = TriangleTopology(faces, len(vertices))
    assert weights_of_normals(topology, np.zeros(len(vertices))) is None
    noise = np.where(topology.on_boundary, 0, 0.3)  # not judged on the boundary
    assert weights_of_normals(topology, noise) is None
    loud = np.argmax(noise > 0)
    noise[loud] = 0.9
    weights = weights_of_normals(topology, noise)
    least = PARAMETERS.coarse_noise**2
    for triangle, weight in zip(faces, weights, strict=True):
        known = noise[triangle][noise[triangle] > 0]
        variance = np.mean(known**2) if len(known) else 0.3**2
        assert weight == pytest.approx(1 / (variance + least))


def test_noise_goes_and_the_ridge_of_a_roof_stays():
    vertices, faces, left, right = roof(noise=0.1)
    clean, *_ = roof()
    normals, true = normals_of(vertices, faces), normals_of(clean, faces)
    around = triangles_around(TriangleTopology(faces, len(vertices)))
    (smooth,) = smoothed_normals(normals, around, Smoothing(ANGLE, (8,)))
    for side in (left, right):
        before = np.linalg.norm(normals[side] - true[side], axis=1).mean()
        assert np.linalg.norm(smooth[side] - true[side], axis=1).mean() < 0.4 * before
        # No normal has gone over to the other side, at 90 degrees.
        assert np.einsum("fd,fd->f", smooth[side], true[side]).min() > np.cos(np.radians(40))


@pytest.mark.parametrize("seed", range(3))
def test_a_fit_turns_a_noisy_roof_to_the_clean_one(seed):
    vertices, faces, left, right = roof(noise=0.05, seed=seed)
    true = normals_of(roof()[0], faces)
    noisy = TriangleSurface(TriangleTopology(faces, len(vertices)), vertices)
    family = NormalFamily("normals", (Smoothing(ANGLE, (1, 3, 8)),))
    fits = dict(filtered(noisy, noisy, family))
    assert tuple(fits) == family.filters
    surfaces = [vertices, *fits.values()]

    def error(points):
        found = normals_of(points, faces)[left | right]
        return np.linalg.norm(found - true[left | right], axis=1).mean()

    errors = np.array([error(points) for points in surfaces])
    assert (np.diff(errors) < 0).all()
    assert errors[-1] < 0.4 * errors[0]


def test_a_fit_leaves_a_clean_roof_as_it_is():
    vertices, faces, *_ = roof()
    noisy = TriangleSurface(TriangleTopology(faces, len(vertices)), vertices)
    family = NormalFamily("normals", (Smoothing(ANGLE, (8,)),))
    ((_, fit),) = filtered(noisy, noisy, family)
    np.testing.assert_allclose(fit, vertices, atol=1e-9)


def test_normals_of_the_noisy_mesh_are_not_those_of_the_surface():
    vertices, faces, *_ = roof()
    noisy = TriangleSurface(TriangleTopology(faces, len(vertices)), vertices)
    rounded = TriangleSurface(noisy.topology, vertices * [1, 1, 0.5])
    family = NormalFamily("noisy normals", (Smoothing(ANGLE, (8,)),), is_of_noisy=True)
    ((_, fit),) = filtered(noisy, rounded, family)
    np.testing.assert_allclose(fit, vertices, atol=1e-9)
