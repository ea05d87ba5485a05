"""Invariance of the result to turns, reflections, numbering and rounding of the mesh."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import DenoiseSettings, denoise

# Relative to what is removed; rounding alone makes a difference.
ALIKE = 1e-3


def noisy(mesh, amplitude=0.2, seed=0):
    vertices, faces = mesh
    edges = vertices[faces[:, 0]] - vertices[faces[:, 1]]
    noise = np.random.default_rng(seed).normal(size=vertices.shape)
    return vertices + amplitude * np.linalg.norm(edges, axis=1).mean() * noise, faces


MESHES = {
    "closed": noisy(meshes.icosphere(3)),
    "open": noisy(meshes.flat_grid(26, 22)),
}


def removed(vertices, faces):
    return vertices - denoise(vertices, faces, DenoiseSettings(boundary="free")).positions


def difference(found, expected):
    return np.linalg.norm(found - expected) / np.linalg.norm(expected)


@pytest.fixture(params=MESHES, scope="module")
def case(request):
    vertices, faces = MESHES[request.param]
    expected = removed(vertices, faces)
    assert np.linalg.norm(expected) > 0
    return vertices, faces, expected


def test_turned_and_moved_in_space(case):
    vertices, faces, expected = case
    turn, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    assert difference(removed(vertices @ turn.T + [3, -1, 2], faces) @ turn, expected) < ALIKE


def test_mirrored(case):
    vertices, faces, expected = case
    mirror = np.array([-1, 1, 1])
    assert difference(removed(vertices * mirror, faces[:, ::-1]) * mirror, expected) < ALIKE


def test_turned_inside_out(case):
    vertices, faces, expected = case
    assert difference(removed(vertices, faces[:, ::-1]), expected) < ALIKE


def test_vertices_renumbered(case):
    vertices, faces, expected = case
    order = np.random.default_rng(2).permutation(len(vertices))
    found = np.empty_like(vertices)
    found[order] = removed(vertices[order], np.argsort(order)[faces])
    assert difference(found, expected) < ALIKE


def test_faces_in_another_order_with_other_first_corners(case):
    vertices, faces, expected = case
    rng = np.random.default_rng(3)
    others = np.stack([np.roll(face, rng.integers(3)) for face in rng.permutation(faces)])
    assert difference(removed(vertices, others), expected) < ALIKE


def test_moved_by_rounding(case):
    vertices, faces, expected = case
    move = 1e-12 * np.ptp(vertices) * np.random.default_rng(4).normal(size=vertices.shape)
    assert difference(removed(vertices + move, faces), expected) < ALIKE


def test_the_shape_at_twice_the_strength_is_the_result_of_a_run_at_that_strength(case):
    vertices, faces, _ = case
    once = denoise(vertices, faces, DenoiseSettings(strength=1.0))
    twice = denoise(vertices, faces, DenoiseSettings(strength=2.0))
    assert difference(once.at(2.0) - vertices, twice.positions - vertices) < 1e-12
