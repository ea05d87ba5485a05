"""Edges that follow the bends of a shape, and noise that does not know the edges."""

from functools import cache

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import TriangleTopology, denoise
from adaptive_fairing.core.denoising import mesh_parts
from adaptive_fairing.core.denoising.noise.laid_edges import laid_excess
from adaptive_fairing.core.denoising.noise.noisy_surface import NoisySurface
from adaptive_fairing.core.denoising.parameters import PARAMETERS
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface

SHAPES = {
    "graded": meshes.graded_sphere(4),
    "torus": meshes.torus(48, 24),
    "grid": meshes.flat_grid(40, 40),
}

CELLS, ROUGH = 20, 0.2


def measured(points, faces, clean, level):
    topology = TriangleTopology(faces, len(points))
    surface = NoisySurface(points, TriangleSurface(topology, clean))
    return laid_excess(surface, np.full(len(points), level), ~topology.on_boundary)


def excess(points, faces, clean, level):
    return measured(points, faces, clean, level)[0]


def chance(n):
    return PARAMETERS.clear_deviations / np.sqrt(n)


def sum_of_angles(points, faces):
    """Between all neighbouring triangles."""
    first, second, third = points[faces].swapaxes(0, 1)
    normals = np.cross(second - first, third - first)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    twin = TriangleTopology(faces, len(points)).twin
    sides = np.flatnonzero(twin > np.arange(len(twin)))
    cosines = np.einsum("ed,ed->e", normals[sides // 3], normals[twin[sides] // 3])
    return np.arccos(np.clip(cosines, -1, 1)).sum()


@cache
def laid_out(seed):
    """A square with random heights, its diagonals turned one by one until it bends least."""
    random, side = np.random.default_rng(seed), CELLS + 1
    x, y = (each.ravel() for each in np.meshgrid(np.arange(side), np.arange(side)))
    points = np.column_stack([x, y, ROUGH * random.normal(size=side**2)])
    a = np.flatnonzero((x < CELLS) & (y < CELLS))
    b, c, d = a + 1, a + side + 1, a + side
    both = np.stack([[[a, b, c], [a, c, d]], [[a, b, d], [b, c, d]]])
    turned, cells = np.zeros(len(a), int), np.arange(len(a))
    least = np.inf
    for cell in (*random.permutation(cells), *random.permutation(cells)):
        turned[cell] ^= 1
        bent = sum_of_angles(points, both[turned, :, :, cells].reshape(-1, 3))
        if bent < least:
            least = bent
        else:
            turned[cell] ^= 1
    return points, both[turned, :, :, cells].reshape(-1, 3)


def with_other_heights(points, size, seed):
    heights = size * np.random.default_rng(seed).normal(size=len(points))
    return np.column_stack([points[:, :2], heights])


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("level", [0.05, 0.2])
def test_noise_does_not_know_the_edges(shape, level):
    clean, faces = SHAPES[shape]
    frame = TriangleSurface(TriangleTopology(faces, len(clean)), clean)
    randoms = map(np.random.default_rng, range(8))
    noises = (frame.raised(level * each.normal(size=len(clean))) for each in randoms)
    found = np.array([measured(clean + each, faces, clean, level) for each in noises])
    assert np.abs(found).max() < chance(len(clean))
    assert np.abs(found.mean(axis=0)).max() < chance(len(clean)) / 2


@pytest.mark.parametrize(("length", "sign"), [(0.5, 1), (2, -1)])
def test_longer_edges_bend_less_where_ridges_are_cut_short(length, sign):
    _, faces = meshes.flat_grid(CELLS, CELLS)
    column, row = np.divmod(np.arange((CELLS + 1) ** 2), CELLS + 1)
    # Edges within a ridge are the shortest of all, or the longest.
    flat = np.column_stack([column, length * (row + column / 2), 0 * row])
    heights = ROUGH * np.random.default_rng(0).normal(size=CELLS + 1)
    ridges = flat + heights[column, None] * [0, 0, 1]
    assert sign * measured(ridges, faces, flat, ROUGH)[1] > chance(len(flat))


def test_equal_edges_tell_nothing():
    points, faces = meshes.octahedron()
    points = points / np.linalg.norm(points[0])
    assert np.all(np.isfinite(measured(points, faces, points, 0.1)))


@pytest.mark.parametrize("seed", range(2))
def test_edges_that_were_laid_out_for_heights_do_not_fit_others(seed):
    points, faces = laid_out(seed)
    flat = points * [1, 1, 0]
    assert excess(points, faces, flat, ROUGH) > chance(len(points))
    others = [with_other_heights(points, ROUGH, each) for each in range(9, 17)]
    found = [excess(each, faces, flat, ROUGH) for each in others]
    assert np.max(found) < chance(len(points))


def test_the_more_noise_comes_later_the_less_the_edges_fit():
    points, faces = laid_out(0)
    flat = points * [1, 1, 0]
    noise = with_other_heights(points, 1, 9) * [0, 0, 1]
    sizes = np.array([0, 0.1, 0.2, 0.8])
    found = [excess(points + each * noise, faces, flat, np.hypot(ROUGH, each)) for each in sizes]
    assert np.all(np.diff(found) < 0)


def test_it_does_not_matter_where_the_surface_lies():
    points, faces = laid_out(0)
    axes = [1, 2, 0]
    found, turned = (
        excess(points[:, order] * 7, faces, (points * [1, 1, 0])[:, order] * 7, ROUGH)
        for order in ([0, 1, 2], axes)
    )
    # Only where a comparison is a draw may rounding decide.
    assert found == pytest.approx(turned, abs=4 / len(faces))


def test_edges_of_a_boundary_triangle_are_not_judged():
    """They lack triangles around that would tell."""
    points = np.array([[0, 0, 0.0], [1, 0, 0.3], [1, 1, 0], [0, 1, 0.1]])
    assert measured(points, np.array([[0, 1, 2], [0, 2, 3]]), points, 0.1) == (0, 0)


@pytest.mark.parametrize("seed", range(2))
def test_what_was_laid_out_comes_back_bit_by_bit_and_noise_on_it_does_not(seed):
    points, faces = laid_out(seed)
    result = denoise(points, faces)
    assert np.array_equal(result.positions, points)
    assert "of its edges follow bends" in result.notes[-1]
    noisy = with_other_heights(points, ROUGH, 9)
    assert denoise(noisy, faces).positions[:, 2].std() < 0.7 * noisy[:, 2].std()


@pytest.mark.parametrize("seed", range(2))
def test_edges_are_asked_where_vertices_stand_out_too(monkeypatch, seed):
    """Corners stand out. If they are no spikes, all is judged like other roughness."""
    monkeypatch.setattr(mesh_parts, "is_impulsive", lambda *_: True)
    points, faces = laid_out(seed)
    result = denoise(points, faces)
    assert np.array_equal(result.positions, points)
    assert "of its edges follow bends" in result.notes[-1]
