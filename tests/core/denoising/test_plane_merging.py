"""Regions that are flat but for noise: how little they may turn, and noise that is no crease."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import TriangleTopology
from adaptive_fairing.core.denoising.plane_merging import flat_regions
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface

GRID, FACES = meshes.flat_grid(40, 40)
MIDDLE = GRID[:, 0] - GRID[:, 0].mean()
EDGE = np.linalg.norm(GRID[1] - GRID[0])
IS_LEFT = (MIDDLE[FACES] <= 1e-9).all(axis=1)


def regions(heights, noise, *, seed=0, told=None, own_part=1.0, face=None, factor=1.0):
    """Regions of a sheet with clean heights and noise, in edges, of a level that is told."""
    added = np.random.default_rng(seed).normal(0, noise, len(GRID))
    up = np.array([0, 0, EDGE])
    clean = GRID + np.outer(heights, up)
    topology = TriangleTopology(FACES, len(GRID))
    size = np.full(len(GRID), EDGE * (noise if told is None else told))
    # As filters leave it: a tenth of the noise.
    surface = TriangleSurface(topology, clean + np.outer(0.1 * added, up))
    normals = surface.triangle_normals() / EDGE**2
    noisy = clean + np.outer(added, up)
    return flat_regions(topology, normals, noisy, size, own_part, factor, face)


@pytest.mark.parametrize("noise", [0.05, 0.2, 0.5])
def test_a_noisy_sheet_is_one_region(noise):
    """Of forty sheets none is parted: a second plane pays for 1e-5 of them."""
    for seed in range(40):
        assert regions(np.zeros(len(GRID)), noise, seed=seed).max() == 0


@pytest.mark.parametrize("degrees", [5, 10, 60])
def test_a_crease_parts_two_regions_however_little_it_turns(degrees):
    heights = np.abs(MIDDLE) / EDGE * np.tan(np.radians(degrees / 2))
    found = regions(heights, 0.2)
    left, right = (np.bincount(found[some]).argmax() for some in (IS_LEFT, ~IS_LEFT))
    assert left != right
    assert np.mean(found == np.where(IS_LEFT, left, right)) > 0.9


def test_a_turn_that_noise_explains_is_no_crease():
    """A fifth of a degree over twenty edges: 0.03 of an edge."""
    heights = np.abs(MIDDLE) / EDGE * np.tan(np.radians(0.1))
    assert regions(heights, 0.2).max() == 0


def test_more_noise_than_was_told_is_no_reason_for_more_planes():
    parts = [
        np.bincount(regions(np.zeros(len(GRID)), 0.3, seed=seed, told=0.2)).max() / len(FACES)
        for seed in range(10)
    ]
    assert np.median(parts) > 0.7


def test_vertices_that_say_less_part_less():
    heights = np.abs(MIDDLE) / EDGE * np.tan(np.radians(1.5))
    assert regions(heights, 0.2).max() > 0
    assert regions(heights, 0.2, own_part=0.002).max() == 0


def test_no_large_region_is_bent_by_a_right_angle():
    """However little the vertices say: each side of the bend is large."""
    way = MIDDLE / EDGE
    heights = np.abs(way)
    assert regions(heights, 0.2, own_part=1e-6).max() > 0


def test_faces_merge_where_one_plane_explains_both_and_nothing_else_does():
    """Halves of a sheet and of a bend, with a strip between that is on no face."""
    face = np.where(IS_LEFT, 0, 1)
    strip = np.abs(MIDDLE[FACES]).max(axis=1) < 1.5 * EDGE
    face[strip & ~IS_LEFT] = -1
    flat = regions(np.zeros(len(GRID)), 0.2, face=np.where(IS_LEFT, 0, 1))
    assert flat.max() == 0
    apart = regions(np.zeros(len(GRID)), 0.2, face=face)
    assert len(np.unique(apart)) == 2 + np.sum(face < 0)
    bend = np.abs(MIDDLE) / EDGE * np.tan(np.radians(15))
    assert regions(bend, 0.2, face=np.where(IS_LEFT, 0, 1)).max() == 1


def test_another_factor_merges_in_another_order():
    """A dome, of which the vertices say so little that only its turns keep regions apart."""
    heights = -3 * ((MIDDLE / EDGE / 10) ** 2 + (GRID[:, 1] / EDGE / 10) ** 2)
    one, other, same = (
        regions(heights, 0.1, told=1e6, own_part=1e-9, factor=each) for each in (0.85, 1.15, 0.85)
    )
    assert one.max() > 0
    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)
