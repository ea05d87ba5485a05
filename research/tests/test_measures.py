"""Measures of the benchmark of denoising: exact on results of known errors."""

from __future__ import annotations

import numpy as np
import pytest
from support.meshes import flat_grid, icosphere

from research.denoising import noise
from research.denoising.measures import N_CLASSES, Reference
from tools.geometry.triangles import (
    edges_of,
    local_edge_lengths,
    normals,
)


def test_a_clean_result_has_no_errors(ball):
    vertices, faces = ball
    found = Reference(vertices, faces).score(vertices)
    assert found["volume"] is not None
    assert (found.pop("boundary"), found.pop("area")) == (None, None)  # it is closed
    assert found.pop("classes") == pytest.approx([0.0] * N_CLASSES, abs=1e-12)
    assert found == pytest.approx(dict.fromkeys(found, 0.0), abs=1e-5)  # arccos near 1 is coarse


def test_a_swollen_sphere_is_measured_exactly():
    vertices, faces = icosphere(3)
    reference = Reference(vertices, faces)
    found = reference.score(1.01 * vertices)
    # Nearest to a point straight above a corner of a convex body is the corner.
    outwards = 0.01 / reference.local_edges
    # Nearest to that corner, on the swollen body, is a triangle around it: the planes are parallel.
    heights = np.einsum("fd,fd->f", vertices[faces[:, 0]], normals(vertices, faces))
    beside = np.full(len(vertices), np.inf)
    np.minimum.at(beside, faces, heights[:, None])
    expected = [outwards, beside * outwards]
    np.testing.assert_allclose(reference.distances(1.01 * vertices), expected, rtol=1e-9)
    assert found["mean"] == pytest.approx(np.sqrt(np.mean(np.square(expected))), rel=1e-9)
    assert found["moved"] == pytest.approx(np.sqrt(np.mean(outwards**2)), rel=1e-9)
    assert found["volume"] == pytest.approx(1.01**3 - 1, rel=1e-9)
    assert found["angle"] == pytest.approx(0, abs=1e-5)
    assert found["flips"] == 0


def test_sliding_within_the_surface_is_no_error_but_a_move():
    vertices, faces = flat_grid(12, 12)
    inside = np.ones(len(vertices), dtype=bool)
    inside[np.unique(edges_of(faces)[_boundary(faces)])] = False
    slid = vertices.copy()
    slid[inside, 0] += 0.2 * local_edge_lengths(vertices, faces)[inside]
    found = Reference(vertices, faces).score(slid)
    assert found["mean"] == pytest.approx(0, abs=1e-12)
    assert found["volume"] is None  # it is open
    assert found["moved"] == pytest.approx(0.2 * np.sqrt(inside.mean()), rel=1e-9)
    assert found["flips"] == 0


def test_a_boundary_drawn_inwards_is_an_error_of_what_is_missing():
    n = 24
    turn = 2 * np.pi * np.arange(n) / n
    boundary = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    vertices = np.concatenate([np.zeros((1, 3)), boundary])
    faces = np.stack([0 * turn, 1 + np.arange(n), 1 + np.roll(np.arange(n), -1)], axis=1)
    reference = Reference(vertices, faces.astype(np.int32))
    found = reference.score(0.9 * vertices)
    # Nearest to a corner of the small polygon is a side of the large one; the other way a corner.
    square = np.mean(np.square([0.1 * np.cos(np.pi / n), 0.1]))
    assert found["boundary"] == pytest.approx(np.sqrt(square) / reference.local_edges[1], rel=1e-9)
    assert found["area"] == pytest.approx(0.81 - 1, rel=1e-9)
    # All vertices of the small disc lie on the large one, but the corners of that stick out of it.
    missing = 0.1 / reference.local_edges[1:]
    expected = np.concatenate([np.zeros(n + 2), missing])
    assert found["mean"] == pytest.approx(np.sqrt(np.mean(np.square(expected))), rel=1e-9)
    np.testing.assert_allclose(
        np.sort(reference.distances(0.9 * vertices).ravel()), expected, atol=1e-12
    )


def test_a_boundary_pushed_outwards_is_as_large_an_error():
    vertices, faces = flat_grid(12, 12)
    small, large = Reference(vertices, faces), Reference(1.1 * vertices, faces)
    outwards, inwards = small.distances(1.1 * vertices), large.distances(vertices)
    np.testing.assert_allclose(1.1 * inwards[::-1], outwards, atol=1e-12)


def _boundary(faces: np.ndarray) -> np.ndarray:
    pairs_of_ends = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    counts = np.unique(pairs_of_ends, axis=0, return_counts=True)[1]
    return counts == 1


def test_noise_along_the_normals_is_the_distance_measured(ball):
    vertices, faces = ball
    noisy = noise.add_noise(vertices, faces, "normal", 0.1, seed=3)
    found = Reference(vertices, faces).score(noisy)
    assert found["mean"] == pytest.approx(0.1, rel=0.05)
    assert found["classes"] == pytest.approx([0.1] * N_CLASSES, rel=0.1)
    assert found["worst"] == max(found["classes"])


def test_turned_faces_are_counted():
    vertices, faces = flat_grid(6, 6)
    found = Reference(vertices, faces).score(vertices * [-1, 1, 1])
    assert found["flips"] == len(faces)
    assert found["angle"] == pytest.approx(180)


def test_density_classes_are_equal_shares_from_dense_to_coarse(ball):
    reference = Reference(*ball)
    counts = np.bincount(reference.density_class)
    assert len(counts) == N_CLASSES
    assert np.ptp(counts) <= 0.01 * len(ball[0])
    for k in range(N_CLASSES - 1):
        longest = reference.local_edges[reference.density_class == k].max()
        assert longest <= reference.local_edges[reference.density_class == k + 1].min()
