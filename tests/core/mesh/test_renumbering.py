"""The order in which the solver keeps vertices and triangles."""

from itertools import pairwise

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core.mesh.renumbering import SECTION, sweep_order


def sections(order):
    return np.split(order.vertices, range(SECTION, len(order.vertices), SECTION))


@pytest.mark.parametrize("axis", range(3))
def test_sections_come_in_a_sweep_along_the_longest_axis(axis):
    vertices, faces = meshes.icosphere(4)
    vertices[:, axis] *= 3
    order = sweep_order(vertices, faces)
    np.testing.assert_array_equal(np.sort(order.vertices), np.arange(len(vertices)))
    heights = [vertices[each, axis] for each in sections(order)]
    assert len(heights) == 3
    for low, high in pairwise(heights):
        assert low.max() <= high.min()


def test_within_a_section_vertices_of_one_valence_stand_together():
    vertices, faces = meshes.flat_grid(60, 40)
    order = sweep_order(vertices, faces)
    n_around = np.bincount(faces.reshape(-1))
    assert len(sections(order)) > 1
    for each in sections(order):
        assert (np.diff(n_around[each]) >= 0).all()
        # Within one valence the sweep goes on.
        longest = np.ptp(vertices, axis=0).argmax()
        same = np.diff(n_around[each]) == 0
        assert (np.diff(vertices[each, longest])[same] >= 0).all()


def test_vertices_at_one_height_keep_their_order():
    vertices, faces = meshes.flat_grid(6, 3)
    order = sweep_order(vertices, faces)
    heights = vertices[order.vertices, 0]
    n_around = np.bincount(faces.reshape(-1))[order.vertices]
    same = (np.diff(heights) == 0) & (np.diff(n_around) == 0)
    assert same.any()
    assert (np.diff(order.vertices)[same] > 0).all()


def test_triangles_are_the_same_sorted_by_their_lowest_vertex():
    vertices, faces = meshes.random_closed(1)
    order = sweep_order(vertices, faces)
    old = order.vertices[order.triangles]
    np.testing.assert_array_equal(np.unique(old, axis=0), np.unique(faces, axis=0))
    assert (np.diff(order.triangles.min(axis=1)) >= 0).all()
    # Triangles with one lowest vertex keep their order.
    place = {tuple(face): k for k, face in enumerate(faces.tolist())}
    places = np.array([place[tuple(face)] for face in old.tolist()])
    same = np.diff(order.triangles.min(axis=1)) == 0
    assert (np.diff(places)[same] > 0).all()


def test_neighbours_lie_close_together():
    """On a long tube they are in one section or two, but for a ring, whatever the order was."""
    n_around, n_along = 12, 500
    vertices, faces = meshes.open_cylinder(n_around, n_along, height=250.0)
    shuffled = np.random.default_rng(0).permutation(len(vertices))
    old_number = np.argsort(shuffled)
    order = sweep_order(vertices[shuffled], old_number[faces])
    assert np.ptp(order.triangles // SECTION, axis=1).max() <= 1


def test_positions_in_single_precision_have_the_same_order():
    vertices, faces = meshes.random_closed(0)
    single = vertices.astype(np.float32)
    order, expected = sweep_order(single, faces), sweep_order(single.astype(np.float64), faces)
    np.testing.assert_array_equal(order.vertices, expected.vertices)
    np.testing.assert_array_equal(order.triangles, expected.triangles)
