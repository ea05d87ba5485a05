"""The part of a surface around the vertices that may move."""

import numpy as np
import pytest
from scipy.sparse import csgraph
from support import meshes

from adaptive_fairing.core import PreparedMesh, TriangleTopology
from adaptive_fairing.core.problem.region import rings_around

MESHES = {
    "grid": meshes.flat_grid(24, 20),
    "ball": meshes.noisy_ball(3, 0.03),
    "hull": meshes.random_hull(0, 600),
}


def hops(topology, start):
    """Edges between every vertex and the nearest of some, found by another search."""
    graph = topology.adjacency(float)
    return csgraph.dijkstra(graph, indices=start, unweighted=True, min_only=True)


@pytest.mark.parametrize("n_rings", [1, 2, 5])
@pytest.mark.parametrize("name", MESHES)
def test_rings_are_counted_in_edges(name, n_rings):
    vertices, faces = MESHES[name]
    topology = TriangleTopology(faces, len(vertices))
    start = np.array([3, len(vertices) // 2])
    is_start = np.zeros(len(vertices), dtype=bool)
    is_start[start] = True
    expected = hops(topology, start) < n_rings
    np.testing.assert_array_equal(rings_around(topology, is_start, n_rings), expected)
    assert is_start.sum() == 2


def test_rings_are_added_until_there_are_vertices_enough():
    vertices, faces = MESHES["grid"]
    topology = TriangleTopology(faces, len(vertices))
    is_start = np.arange(len(vertices)) == len(vertices) // 2
    distance = hops(topology, np.flatnonzero(is_start))
    reached = np.array([np.count_nonzero(distance < ring) for ring in range(60)])
    for least in (30, 31, 200):
        n_rings = max(2, int(np.argmax(reached >= least)))
        found = rings_around(topology, is_start, 2, least)
        np.testing.assert_array_equal(found, distance < n_rings)
    assert rings_around(topology, is_start, 2, len(vertices) + 1).all()


def test_a_whole_piece_has_no_border_and_others_are_not_reached():
    parts = [meshes.noisy_ball(2, 0.03), meshes.noisy_ball(3, 0.03)]
    vertices, faces = meshes.merged(*parts)
    topology = TriangleTopology(faces, len(vertices))
    first = np.arange(len(vertices)) < len(parts[0][0])
    np.testing.assert_array_equal(rings_around(topology, first, 3), first)
    prepared = PreparedMesh(vertices, faces)
    region = prepared.region(vertices, first[prepared.surface.vertex_of], 3)
    assert region.surface.topology.is_closed
    assert region.surface.topology.n_triangles == len(parts[0][1])


def test_a_border_that_touches_itself_is_cut_and_held():
    """Triangles around two vertices that have a neighbour in common, and nothing else."""
    vertices, faces = meshes.flat_grid(24, 20)
    prepared = PreparedMesh(vertices, faces)
    topology, vertex_of = prepared.surface.topology, prepared.surface.vertex_of
    middle = len(vertices) // 2
    place = vertices[vertex_of]
    ends = [np.argmin(np.abs(place - vertices[middle] - [x, 0, 0]).sum(axis=1)) for x in (-1, 1)]
    moves = np.isin(np.arange(len(vertices)), ends)
    region = prepared.region(place, moves, 1)
    surface = region.surface
    assert surface.topology.n_triangles == 12
    np.testing.assert_array_equal(surface.vertex_of, vertex_of[region.inner_of])
    copies = np.flatnonzero(surface.vertex_of == middle)
    assert len(copies) == 2
    assert surface.is_cut[copies].all()
    assert topology.n_triangles == len(faces)


def test_all_or_nothing_is_no_region():
    vertices, faces = MESHES["ball"]
    prepared = PreparedMesh(vertices, faces)
    for moves in (np.zeros(len(vertices), dtype=bool), vertices[:, 0] > -0.5):
        assert prepared.region(vertices, moves, 3) is None
