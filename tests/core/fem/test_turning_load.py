"""The load of turned tangents, against the stiffness matrix."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import LoopSpace, TriangleTopology

SURFACES = {
    "graded": meshes.graded_sphere(3),
    "open": meshes.flat_grid(9, 7),
    "many classes": meshes.random_closed(2),
}


@pytest.mark.parametrize("name", SURFACES)
def test_turns_that_are_the_same_everywhere_act_on_the_whole_flow(name):
    """With one R for all triangles the load is (1 - R) L X."""
    vertices, faces = SURFACES[name]
    space = LoopSpace(TriangleTopology(faces, len(vertices)))
    flow = space.stiffness_matrix(vertices) @ vertices
    random = np.random.default_rng(0).normal(size=(3, 3))
    for turn in (np.zeros((3, 3)), np.eye(3), np.linalg.qr(random)[0], random):
        load = space.turning_load(vertices, np.tile(turn, (len(faces), 1, 1)))
        expected = flow @ (np.eye(3) - turn).T
        np.testing.assert_allclose(load, expected, atol=1e-11 * np.abs(flow).max())


def test_the_load_is_the_sum_over_the_triangles():
    vertices, faces = SURFACES["many classes"]
    space = LoopSpace(TriangleTopology(faces, len(vertices)))
    turns = np.random.default_rng(1).normal(size=(len(faces), 3, 3))
    is_first = np.arange(len(faces)) % 3 == 0
    parts = [np.where(chosen[:, None, None], turns, np.eye(3)) for chosen in (is_first, ~is_first)]
    whole = space.turning_load(vertices, turns)
    summed = sum(space.turning_load(vertices, part) for part in parts)
    np.testing.assert_allclose(summed, whole, atol=1e-12 * np.abs(whole).max())
    assert np.abs(parts[0] - turns).max() > 0
