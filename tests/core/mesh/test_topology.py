"""Half-edges, their twins, and ordered one-rings, by their definitions."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import TriangleTopology

MESHES = {
    "valences 3 to 10": meshes.random_closed(2),
    "torus": meshes.torus(3, 4),
    "open": meshes.bumpy_disc(0),
    "single triangle": meshes.single_triangle(),
    "two components": meshes.merged(meshes.octahedron(), meshes.open_cylinder(5, 2)),
}


@pytest.fixture(params=MESHES.values(), ids=MESHES)
def topology(request):
    vertices, faces = request.param
    return TriangleTopology(faces, len(vertices) + 1)  # the last vertex is loose


def half_edges(topology):
    """Origin and target of every half-edge 3 f + k."""
    return [(int(face[k]), int(face[(k + 1) % 3])) for face in topology.triangles for k in range(3)]


def test_the_twin_of_a_half_edge_runs_the_other_way(topology):
    edges = half_edges(topology)
    number = {edge: h for h, edge in enumerate(edges)}
    expected = [number.get((target, origin), -1) for origin, target in edges]
    np.testing.assert_array_equal(topology.twin, expected)


def test_a_vertex_is_on_the_boundary_if_an_edge_of_it_has_one_triangle(topology):
    edges = set(half_edges(topology))
    ends = {v for edge in edges if edge[::-1] not in edges for v in edge}
    assert set(topology.boundary_vertices.tolist()) == ends
    assert topology.is_closed == (not ends)


def test_the_boundary_goes_on_along_the_half_edges_without_a_twin(topology):
    following, preceding = topology.boundary_neighbours
    edges = set(half_edges(topology))
    expected = {edge for edge in edges if edge[::-1] not in edges}
    border = topology.boundary_vertices.tolist()
    assert set(zip(border, following.tolist(), strict=True)) == expected
    assert set(zip(preceding.tolist(), border, strict=True)) == expected


def test_a_ring_has_every_neighbour_once(topology):
    neighbours = [set() for _ in range(topology.n_vertices)]
    for origin, target in half_edges(topology):
        neighbours[origin].add(target)
        neighbours[target].add(origin)
    for v, expected in enumerate(neighbours):
        ring = topology.ring[topology.ring_start[v] : topology.ring_start[v + 1]].tolist()
        assert len(ring) == topology.ring_size[v] == len(expected)
        assert set(ring) == expected
    assert topology.is_loose.tolist() == [not each for each in neighbours]


def test_entries_that_follow_each_other_in_a_ring_span_a_triangle_with_the_vertex(topology):
    """Counter-clockwise; a ring is closed inside, and a chain from border to border otherwise."""
    triangles = {tuple(np.roll(face, -k)) for face in topology.triangles.tolist() for k in range(3)}
    for v in range(topology.n_vertices):
        ring = topology.ring[topology.ring_start[v] : topology.ring_start[v + 1]].tolist()
        following = ring[1:] if topology.on_boundary[v] else ring[1:] + ring[:1]
        for first, second in zip(ring, following, strict=False):
            assert (v, first, second) in triangles


def test_the_ring_position_of_a_half_edge_is_the_place_of_its_target(topology):
    for h, (origin, target) in enumerate(half_edges(topology)):
        place = topology.ring_start[origin] + topology.ring_position[h]
        assert topology.ring[place] == target
        assert 0 <= topology.ring_position[h] < topology.ring_size[origin]
