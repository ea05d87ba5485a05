"""Pseudo-random numbers that follow from the mesh alone."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import TriangleTopology
from adaptive_fairing.core.denoising.noise.own_numbers import (
    LINE_NOISE,
    PROBE,
    WHITE_NOISE,
    OwnNumbers,
)
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface

VERTICES, FACES = meshes.graded_sphere(4)
# Symmetric, so that its connectivity tells few vertices apart.
POINTS = VERTICES * (1 + 0.01 * np.random.default_rng(0).normal(size=(len(VERTICES), 1)))

# Its connectivity tells all of them apart.
IRREGULAR = meshes.random_hull(0, 2500)


def frame_of(points, faces):
    return TriangleSurface(TriangleTopology(faces, len(points)), points)


def steps(points, faces):
    """Vectors (4, n, 3) that the probes stand for."""
    frame = frame_of(points, faces)
    return np.stack([frame.raised(each) for each in OwnNumbers(points, frame).probes(4)])


@pytest.mark.parametrize(("points", "faces"), [(POINTS, FACES), IRREGULAR])
def test_they_are_spread_evenly_and_not_alike_at_neighbours(points, faces):
    frame = frame_of(points, faces)
    own = OwnNumbers(points, frame)
    for use in (PROBE, WHITE_NOISE, LINE_NOISE):
        phases = own.phases(use)
        assert np.all((phases >= 0) & (phases < 1))
        counts, _ = np.histogram(phases, 10, (0, 1))
        expected = len(points) / 10
        assert np.sum((counts - expected) ** 2) / expected < 30  # chi² of 9, one in 3000
        around = frame.mean @ phases
        assert abs(np.corrcoef(phases, around)[0, 1]) < 4 / np.sqrt(len(points))
    numbers = [own.noise(use) for use in (WHITE_NOISE, LINE_NOISE)]
    assert np.std(numbers[0]) == pytest.approx(1, abs=0.05)
    assert abs(np.corrcoef(numbers)[0, 1]) < 4 / np.sqrt(len(points))


def test_neighbours_differ_on_an_exactly_regular_mesh_too():
    vertices, faces = meshes.flat_grid(30, 30)
    phases = OwnNumbers(vertices, frame_of(vertices, faces)).phases(PROBE)
    assert len(np.unique(np.round(phases, 6))) > len(vertices) / 8


def test_probes_are_of_one_size_and_not_alike():
    for count in (1, 2, 3, 4, 9):
        probes = OwnNumbers(POINTS, frame_of(POINTS, FACES)).probes(count)
        assert len(probes) == min(count, 4)
        np.testing.assert_allclose(np.mean(np.square(probes), axis=1), 1, rtol=1e-12)
        alike = np.atleast_2d(np.corrcoef(probes)) - np.eye(len(probes))
        assert np.abs(alike).max() < 4 / np.sqrt(len(POINTS))


@pytest.mark.parametrize("what", ["turned", "mirrored", "other side", "renumbered", "scaled"])
@pytest.mark.parametrize(("points", "faces"), [(POINTS, FACES), IRREGULAR])
def test_steps_go_with_the_mesh(points, faces, what):
    before = steps(points, faces)
    generator = np.random.default_rng(3)
    if what in ("turned", "scaled"):
        turn = np.linalg.qr(generator.normal(size=(3, 3)))[0]
        turn *= 1e-3 if what == "scaled" else np.linalg.det(turn)
        after, before = steps(points @ turn + [3, 0, 5], faces), before @ turn
    elif what == "mirrored":
        flip = [-1, 1, 1]
        after, before = steps(points * flip, faces), before * flip
    elif what == "other side":
        after = steps(points, faces[:, ::-1])
    else:
        order = generator.permutation(len(points))
        after, before = steps(points[order], np.argsort(order)[faces]), before[:, order]
    assert np.linalg.norm(after - before) < 1e-5 * np.linalg.norm(before)


def test_where_connectivity_tells_vertices_apart_jitter_moves_no_probe():
    """Numbers follow from the connectivity there, and only the surface's normals turn."""
    vertices, faces = IRREGULAR
    frame = frame_of(vertices, faces)
    jitter = 1e-4 * frame.spacing[:, None] * np.random.default_rng(4).normal(size=vertices.shape)
    before, after = (OwnNumbers(each, frame).probes(4) for each in (vertices, vertices + jitter))
    np.testing.assert_array_equal(before, after)
    for probe in before:
        alike = np.corrcoef(probe, frame.mean @ probe)[0, 1]
        assert abs(alike) < 4 / np.sqrt(len(vertices))


def test_where_connectivity_is_regular_rounding_moves_a_probe_by_little():
    """Signs would leap at every vertex whose phase passes an end, by twice their size."""
    before = steps(POINTS, FACES)
    after = steps(POINTS.astype(np.float32).astype(float), FACES)
    assert 0 < np.linalg.norm(after - before) < 0.01 * np.linalg.norm(before)


def test_a_large_mesh_is_compared_with_one_noise_and_a_small_one_with_three():
    """The chance of one noise falls with the root of the number of vertices."""
    large = meshes.flat_grid(150, 140)
    for (points, faces), count in (((POINTS, FACES), 3), (large, 1)):
        own = OwnNumbers(points, frame_of(points, faces))
        found = own.several()
        assert len(found) == count
        np.testing.assert_array_equal(found[0], own.noise(WHITE_NOISE))
