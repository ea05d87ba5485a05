"""The research peers do what their papers' equations say, and show what the papers show."""

from __future__ import annotations

import numpy as np
import pytest
from support.meshes import icosphere

from research.denoising import noise, normal_filters
from research.denoising.l0_minimisation import edge_weights, l0_minimisation
from research.denoising.measures import Reference
from research.denoising.peers import RESEARCH
from tools.geometry.triangles import edges_of, inner_edges, scaled_normals, unit

SIDE = 14
"""Squares along an edge of the cube."""

RUNS = {
    "bilateral": lambda mesh: normal_filters.bilateral_filter(*mesh, (20,), sigma=0.35),
    "guided": lambda mesh: normal_filters.guided_filter(*mesh, (20,), sigma=0.35),
    "L0": lambda mesh: l0_minimisation(*mesh, (0.2,)),
}
"""At their published parameters."""


@pytest.fixture(scope="module")
def cube() -> tuple[np.ndarray, np.ndarray]:
    """Make the cube [-1, 1]³ of square grids, two triangles each."""
    line = np.linspace(-1, 1, SIDE + 1)
    grid = np.stack(np.meshgrid(line, line, [1.0], indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(grid)).reshape(SIDE + 1, SIDE + 1)
    a, b, c, d = (
        number[rows, columns]
        for rows in (slice(-1), slice(1, None))
        for columns in (slice(-1), slice(1, None))
    )
    square = np.concatenate(
        [np.stack(three, axis=-1).reshape(-1, 3) for three in ((a, c, d), (a, d, b))]
    )
    sides, faces = [], []
    for k in range(3):
        for sign in (1, -1):
            # A half turn about an axis within the square keeps its faces outwards.
            side = np.roll(grid * [1, sign, sign], k, axis=1)
            sides.append(side)
            faces.append(square + len(grid) * len(faces))
    points, index = np.unique(np.concatenate(sides), axis=0, return_inverse=True)
    return points, index.reshape(-1)[np.concatenate(faces)].astype(np.int32)


@pytest.fixture(scope="module")
def noisy(cube) -> tuple[np.ndarray, np.ndarray]:
    return noise.add_noise(*cube, "uniform", 0.2, seed=4), cube[1]


@pytest.mark.parametrize("name", RUNS)
def test_a_noisy_cube_gets_flat_faces_and_straight_creases(cube, noisy, name):
    vertices, faces = cube
    (result,) = RUNS[name](noisy)
    reference = Reference(*cube)
    before, after = reference.score(noisy[0]), reference.score(result)
    assert after["angle"] < before["angle"] / 7
    assert after["mean"] < before["mean"] / 2.5
    assert after["flips"] == 0
    # Within a side neighbouring faces are flat, and at the creases they stay at right angles.
    beside = inner_edges(faces)[1]
    sharp = np.einsum("kd,kd->k", *unit(scaled_normals(vertices, faces))[beside.T]) < 0.5
    normals = unit(scaled_normals(result, faces))[beside.T]
    angle = np.degrees(np.arccos(np.clip(np.einsum("kd,kd->k", *normals), -1, 1)))
    assert np.median(angle[~sharp]) < 1.5
    assert np.median(np.abs(angle[sharp] - 90)) < 3


@pytest.mark.parametrize("name", RUNS)
def test_a_clean_cube_stays_nearly_as_it_is(cube, name):
    """Guided filtering rounds corners a little: no patch there is flat. No other one does."""
    (result,) = RUNS[name](cube)
    distances = Reference(*cube).distances(result)
    of_result, of_cube = distances.max(axis=1)
    assert of_result < (0.1 if name == "guided" else 0.002)
    # The tip of a corner is √3 times as far from a corner cut off as the cut is from the cube.
    assert of_cube < (0.2 if name == "guided" else 0.004)
    assert np.median(distances) < 0.01


def around(faces: np.ndarray, face: int) -> list[int]:
    """List the faces that share a vertex with one, itself among them."""
    return [k for k, other in enumerate(faces) if set(other) & set(faces[face])]


@pytest.fixture(scope="module")
def small() -> tuple[np.ndarray, np.ndarray]:
    vertices, faces = icosphere(1)
    return noise.add_noise(vertices, faces, "isotropic", 0.1, seed=1), faces


def test_a_bilateral_step_is_the_papers_sum(small):
    vertices, faces = small
    sigma = 0.4
    centre = vertices[faces].mean(axis=1)
    scaled = scaled_normals(vertices, faces)
    normal, area = unit(scaled), np.linalg.norm(scaled, axis=1) / 2
    adjacent = [
        (i, k)
        for i in range(len(faces))
        for k in range(i)
        if len(set(faces[i]) & set(faces[k])) == 2
    ]
    spread = np.mean([np.linalg.norm(centre[i] - centre[k]) for i, k in adjacent])
    filtered = np.zeros_like(normal)
    for i in range(len(faces)):
        for k in around(faces, i):
            if k != i:
                near = np.exp(-np.sum((centre[i] - centre[k]) ** 2) / (2 * spread**2))
                alike = np.exp(-np.sum((normal[i] - normal[k]) ** 2) / (2 * sigma**2))
                filtered[i] += area[k] * near * alike * normal[k]
    expected = normal_filters.fit_vertices(vertices, faces, unit(filtered))
    (found,) = normal_filters.bilateral_filter(vertices, faces, (1,), sigma)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


def test_the_guidance_is_the_mean_normal_of_the_most_consistent_patch(small):
    vertices, faces = small
    scaled = scaled_normals(vertices, faces)
    normal, area = unit(scaled), np.linalg.norm(scaled, axis=1) / 2
    guides, measures = [], []
    for face in range(len(faces)):
        patch = around(faces, face)
        spread = max(np.linalg.norm(normal[i] - normal[k]) for i in patch for k in patch)
        jumps = [
            np.linalg.norm(normal[i] - normal[k])
            for i in patch
            for k in patch
            if i < k and len(set(faces[i]) & set(faces[k])) == 2
        ]
        measures.append(spread * max(jumps) / (normal_filters.LEAST + sum(jumps)))
        guides.append(area[patch] @ normal[patch])
    best = [min(around(faces, face), key=measures.__getitem__) for face in range(len(faces))]
    found = normal_filters._Patches(faces).guide(normal, area)
    np.testing.assert_allclose(found, unit(np.array(guides))[best], atol=1e-12)


def test_vertices_move_as_sun_et_al_say(small):
    vertices, faces = small
    normal = unit(np.random.default_rng(2).normal(size=(len(faces), 3)))
    expected = vertices
    for _ in range(normal_filters.VERTEX_STEPS):
        centre = expected[faces].mean(axis=1)
        moved = expected.copy()
        for vertex in range(len(vertices)):
            own = np.flatnonzero((faces == vertex).any(axis=1))
            heights = np.einsum("kd,kd->k", normal[own], centre[own] - expected[vertex])
            moved[vertex] += heights @ normal[own] / len(own)
        expected = moved
    found = normal_filters.fit_vertices(vertices, faces, normal)
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_the_edge_operator_vanishes_on_flat_pairs_alone():
    generator = np.random.default_rng(3)
    flat = np.zeros((50, 4, 3))
    flat[:, 1:, :2] = [[0.5, -0.8], [1.0, 0.0], [0.4, 0.9]]
    flat[..., :2] += 0.2 * generator.uniform(-1, 1, (50, 4, 2))
    turn = np.linalg.qr(generator.normal(size=(3, 3)))[0]
    weights = edge_weights(flat @ turn)
    np.testing.assert_allclose(weights.sum(axis=1), 0, atol=1e-12)
    np.testing.assert_allclose(np.einsum("kc,kcd->kd", weights, flat @ turn), 0, atol=1e-12)
    bent = flat + np.array([[0, 0, 0], [0, 0, 0.1], [0, 0, 0], [0, 0, 0.1]])
    assert np.linalg.norm(np.einsum("kc,kcd->kd", edge_weights(bent), bent), axis=1).min() > 0.05


def test_inner_edges_have_the_corners_of_both_their_triangles():
    faces = icosphere(1)[1][:-3]
    corners, beside = inner_edges(faces)
    for (a, b, c, d), (first, second) in zip(corners, beside, strict=True):
        assert set(faces[first]) == {a, b, c}
        assert set(faces[second]) == {a, c, d}
    n_inner = 3 * len(faces) - len(edges_of(faces))
    assert len(corners) == n_inner


@pytest.mark.parametrize("peer", RESEARCH, ids=lambda peer: peer.name)
def test_a_peer_as_published_has_one_point_and_the_same_result(peer):
    alone = peer.as_published
    assert len(alone.sweep) == len(alone.variants) == 1
    (variant,), (value,) = alone.variants, alone.sweep
    assert alone.parameter(variant, value) == peer.published
