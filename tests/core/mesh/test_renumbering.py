"""The order in which the solver keeps vertices and triangles."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core.mesh.renumbering import sweep_order


@pytest.mark.parametrize("axis", range(3))
def test_vertices_come_in_a_sweep_along_the_longest_axis(axis):
    vertices, faces = meshes.random_closed(1)
    vertices[:, axis] *= 3
    order = sweep_order(vertices, faces)
    np.testing.assert_array_equal(np.sort(order.vertices), np.arange(len(vertices)))
    assert (np.diff(vertices[order.vertices, axis]) >= 0).all()


def test_vertices_at_one_height_keep_their_order():
    vertices, faces = meshes.flat_grid(6, 3)
    order = sweep_order(vertices, faces)
    heights = vertices[order.vertices, 0]
    same = np.diff(heights) == 0
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
    """On a long tube the numbers of neighbours differ by about a ring, whatever the order was."""
    n_around, n_along = 12, 100
    vertices, faces = meshes.open_cylinder(n_around, n_along, height=50.0)
    shuffled = np.random.default_rng(0).permutation(len(vertices))
    old_number = np.argsort(shuffled)
    order = sweep_order(vertices[shuffled], old_number[faces])
    assert np.ptp(order.triangles, axis=1).max() <= 2 * n_around
