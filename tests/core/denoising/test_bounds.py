"""Bounds of the motion: the noise that was found at each vertex."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import DenoiseSettings, TriangleTopology, denoise
from adaptive_fairing.core.denoising import mixing
from adaptive_fairing.core.denoising.bounds import Bounds
from adaptive_fairing.core.denoising.parameters import PARAMETERS
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface


def noisy_sphere(amplitude=0.2):
    vertices, faces = meshes.icosphere(4)
    frame = TriangleSurface(TriangleTopology(faces, len(vertices)), vertices)
    noise = amplitude * np.random.default_rng(0).normal(size=len(vertices))
    return vertices + frame.raised(noise), faces, frame


def test_a_vertex_without_noise_does_not_move_and_others_move_no_further_than_their_bound():
    points, _, frame = noisy_sphere()
    reach = np.where(points[:, 0] > 0, 0.2, 0.0)
    before = TriangleSurface(frame.topology, points)
    far = points + 10 * np.random.default_rng(1).normal(size=points.shape)
    all_judged = np.ones(len(points), dtype=bool)
    kept = Bounds(before, frame, all_judged, points, reach).kept(far, 1.0)
    moved = np.linalg.norm(kept - points, axis=1)
    assert np.array_equal(kept[reach == 0], points[reach == 0])
    judged = np.count_nonzero(reach)
    most = (PARAMETERS.extra_deviations + np.sqrt(2 * np.log(judged))) * reach * frame.spacing
    assert np.all(moved[reach > 0] <= most[reach > 0])
    assert np.all(moved[reach > 0] > 0.99 * most[reach > 0])


def test_where_nothing_was_judged_a_vertex_goes_as_far_as_its_neighbours():
    points, _, frame = noisy_sphere()
    before = TriangleSurface(frame.topology, points)
    is_judged = np.ones(len(points), dtype=bool)
    is_judged[::50] = False
    reach = np.where(is_judged, 0.2, 0.0)
    far = points + 10 * np.random.default_rng(1).normal(size=points.shape)
    moved = np.linalg.norm(
        Bounds(before, frame, is_judged, points, reach).kept(far, 1.0) - points, axis=1
    )
    edges = moved / frame.spacing
    assert edges[~is_judged] == pytest.approx(np.median(edges[is_judged]))


def test_what_is_within_the_bound_stays_bit_by_bit():
    points, _, frame = noisy_sphere()
    before = TriangleSurface(frame.topology, points)
    near = points + 0.01 * frame.spacing[:, None] * frame.normals
    bounds = Bounds(before, frame, np.ones(len(points), bool), points, np.full(len(points), 0.2))
    assert np.array_equal(bounds.kept(near, 1), near)


def test_the_bound_holds_whatever_the_filters_do(monkeypatch):
    """With filters gone wild the bound acts; it is what keeps the result where it is."""
    points, faces, frame = noisy_sphere()
    wild = np.random.default_rng(2).normal(size=points.shape)
    monkeypatch.setattr(mixing, "unfolded", lambda positions, *_: positions + wild)
    found = denoise(points, faces)
    moved = np.linalg.norm(found.positions - points, axis=1) / frame.spacing
    assert moved.max() < 6 * found.noise_level
    monkeypatch.setattr(mixing.Bounds, "kept", lambda self, positions, strength: positions)
    free = np.linalg.norm(denoise(points, faces).positions - points, axis=1) / frame.spacing
    assert free.max() > 10 * found.noise_level


@pytest.mark.parametrize("limit", [1e-3, 1e-2])
def test_no_vertex_goes_further_than_the_largest_deviation(limit):
    points, faces, _ = noisy_sphere()
    free = denoise(points, faces)
    bounded = denoise(points, faces, DenoiseSettings(max_deviation=limit))
    assert np.linalg.norm(free.positions - points, axis=1).max() > limit
    for shape in bounded.shapes:
        assert np.linalg.norm(shape - points, axis=1).max() <= limit
