"""Folds at spikes, which are smoothed, and folds of the mesh, which stay."""

import numpy as np
from support import meshes

from adaptive_fairing.core import TriangleTopology, denoise
from adaptive_fairing.core.denoising.bounds import are_folded, unfolded
from adaptive_fairing.core.denoising.triangle_surface import TriangleSurface

FLAT, FACES = meshes.flat_grid(12, 12)
TOPOLOGY = TriangleTopology(FACES, len(FLAT))
BEFORE = TriangleSurface(TOPOLOGY, FLAT)
INSIDE = ~TOPOLOGY.on_boundary
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


def test_folds_at_spikes_are_smoothed_and_nothing_else():
    other = np.flatnonzero(INSIDE)[10]
    positions, is_down = pushed([CORNER, other])
    was_spike = np.arange(len(FLAT)) == CORNER
    result = unfolded(positions, BEFORE, was_spike, INSIDE)
    at_spike = was_spike[FACES].any(axis=1)
    folded = are_folded(TOPOLOGY, result)
    assert (is_down & at_spike).any()
    assert np.array_equal(folded, is_down & ~at_spike)
    changed = np.flatnonzero((result != positions).any(axis=1))
    assert np.isin(changed, FACES[is_down & at_spike]).all()


def test_what_may_not_move_stays():
    positions, _ = pushed()
    nowhere = np.zeros_like(INSIDE)
    result = unfolded(positions, BEFORE, np.ones_like(INSIDE), nowhere)
    assert np.array_equal(result, positions)


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
