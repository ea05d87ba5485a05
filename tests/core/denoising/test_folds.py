"""Folds made by noise, which are smoothed, and folds of the mesh, which stay."""

import numpy as np
from support import meshes

from adaptive_fairing.core import TriangleTopology, denoise
from adaptive_fairing.core.denoising.folds import are_folded, unfolded
from adaptive_fairing.core.denoising.parameters import parameters
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface

FLAT, FACES = meshes.flat_grid(12, 12)
TOPOLOGY = TriangleTopology(FACES, len(FLAT))
LIFTED = TriangleSurface(TOPOLOGY, FLAT + np.array([0, 0, 1.0]))
INSIDE = ~TOPOLOGY.on_boundary
NEAR = np.array([0, 0, 0.2])
WEAK, STRONG = np.full(len(FLAT), 0.1), np.full(len(FLAT), 0.5)
CORNER = np.flatnonzero(INSIDE)[len(FLAT) // 3]


def pushed(vertices=CORNER):
    """Vertices pushed over the opposite edges of triangles, and the triangles turned over."""
    positions = FLAT.copy()
    positions[vertices] += [1.2, 0.3, 0]
    corners = positions[FACES]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2]
    return positions, area < 0


def test_triangles_turned_over_are_folded():
    positions, is_down = pushed()
    assert is_down.any()
    assert np.array_equal(are_folded(TOPOLOGY, positions), is_down)
    assert not are_folded(TOPOLOGY, FLAT).any()


def test_a_right_angle_is_no_fold():
    bent = FLAT.copy()
    over = np.maximum(FLAT[:, 1] - np.median(FLAT[:, 1]), 0)
    bent[:, 1] -= over
    bent[:, 2] -= over
    assert not are_folded(TOPOLOGY, bent).any()


def test_folds_are_smoothed_near_by_alone():
    positions, is_down = pushed()
    near = TriangleSurface(TOPOLOGY, positions + NEAR)
    for before, noise in ((LIFTED, WEAK), (near, STRONG)):
        result = unfolded(positions, before, INSIDE, noise)
        assert not are_folded(TOPOLOGY, result).any()
        changed = np.flatnonzero((result != positions).any(axis=1))
        assert np.isin(changed, FACES[is_down]).all()


def test_folds_of_the_mesh_itself_and_what_has_not_or_may_not_move_stay():
    positions, _ = pushed()
    same, near = (TriangleSurface(TOPOLOGY, positions + way) for way in (0 * NEAR, NEAR))
    nowhere = np.zeros_like(INSIDE)
    for before, may_move, noise in (
        (same, INSIDE, STRONG),
        (near, INSIDE, WEAK),
        (LIFTED, nowhere, STRONG),
    ):
        result = unfolded(positions, before, may_move, noise)
        assert np.array_equal(result, positions)


def test_many_folds_are_of_noise_where_denoising_has_moved_them():
    positions, is_down = pushed(np.flatnonzero(INSIDE)[[39, 44, 61, 83, 88]])
    assert is_down.mean() > parameters().most_own_folds
    near, same = (TriangleSurface(TOPOLOGY, positions + way) for way in (NEAR, 0 * NEAR))
    assert not are_folded(TOPOLOGY, unfolded(positions, near, INSIDE, WEAK)).any()
    assert np.array_equal(unfolded(positions, same, INSIDE, WEAK), positions)


def test_no_fold_is_left_of_spikes():
    vertices, faces = meshes.icosphere(4)
    topology = TriangleTopology(faces, len(vertices))
    generator = np.random.default_rng(4)
    spacing = TriangleSurface(topology, vertices).spacing
    is_spike = generator.random(len(vertices)) < 0.2
    height = np.where(is_spike, generator.normal(0, 1.2, len(vertices)), 0) * spacing
    spiky = vertices * (1 + height[:, None])
    assert are_folded(topology, spiky).any()
    found = denoise(spiky, faces)
    assert "impulsive" in " ".join(found.notes)
    assert not are_folded(topology, found.positions).any()
