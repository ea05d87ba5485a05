"""Any points of the limit surface, against refined meshes, which know nothing of patches."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import (
    InputError,
    LimitSurface,
    LoopSpace,
    TriangleTopology,
    mesh_density,
)

CASES = {
    "tetrahedron": meshes.tetrahedron(),
    "seven vertices": meshes.seven_vertex_torus(),
    "valences 3 to 10": meshes.random_closed(1),
    "pole of valence 44": meshes.bipyramid(44),
    "one triangle": meshes.single_triangle(),
    "open, irregular": meshes.bumpy_disc(0),
    "two components": meshes.merged(meshes.octahedron(), meshes.open_cylinder(5, 2)),
}
LEVELS = 3


def surface_of(mesh):
    return LimitSurface(TriangleTopology(mesh[1], len(mesh[0])), mesh[0])


def places_of_refined(surface, levels):
    """Triangle, (k,), and barycentric coordinates, (k, 3), of all corners of a refined mesh.

    A vertex that is new in a level has the middle of its edge's ends.
    """
    corners = np.tile(np.eye(3), (len(surface.levels.mesh(0).triangles), 1, 1))
    for level in range(levels):
        coarse, fine = surface.levels.mesh(level), surface.levels.mesh(level + 1)
        n = coarse.n_vertices
        ends = np.stack([np.arange(n), np.arange(n)], axis=1)
        ends = np.concatenate([ends, coarse.edges])[fine.triangles]
        parent = np.arange(len(fine.triangles)) // 4
        is_end = ends[..., None] == coarse.triangles[parent][:, None, None, :]
        assert (is_end.sum(axis=-1) == 1).all()
        corners = np.einsum("tcek,tkb->tcb", is_end / 2, corners[parent])
    return np.arange(corners[..., 0].size) // (3 * 4**levels), corners.reshape(-1, 3)


@pytest.mark.parametrize("name", CASES)
def test_points_and_normals_are_those_of_the_refined_mesh(name):
    surface = surface_of(CASES[name])
    refined = surface.refined(LEVELS)
    found = surface.evaluate(*places_of_refined(surface, LEVELS))
    corners = refined.triangles.reshape(-1)
    np.testing.assert_allclose(found.points, refined.vertices[corners], atol=1e-12)
    np.testing.assert_allclose(found.normals, refined.normals[corners], atol=1e-9)


@pytest.mark.parametrize("name", CASES)
def test_the_points_of_an_edge_do_not_depend_on_the_side(name):
    vertices, faces = CASES[name]
    topology = TriangleTopology(faces, len(vertices))
    half_edges = np.flatnonzero(topology.twin >= 0)
    if not len(half_edges):
        return
    surface, part = LimitSurface(topology, vertices), 0.3
    sides = []
    for halves, along in ((half_edges, part), (topology.twin[half_edges], 1 - part)):
        places = np.zeros((len(halves), 3))
        rows = np.arange(len(halves))
        places[rows, halves % 3] = 1 - along
        places[rows, (halves + 1) % 3] = along
        sides.append(surface.evaluate(halves // 3, places))
    np.testing.assert_allclose(sides[0].points, sides[1].points, atol=1e-12)
    np.testing.assert_allclose(sides[0].normals, sides[1].normals, atol=1e-9)


@pytest.mark.parametrize("name", CASES)
def test_towards_a_corner_points_and_normals_go_to_those_of_the_vertex(name):
    vertices, faces = CASES[name]
    surface = surface_of((vertices, faces))
    numbers, distance = np.arange(len(faces)), 1e-7
    near = surface.evaluate(
        numbers, np.tile([1 - 2 * distance, distance, distance], (len(faces), 1))
    )
    at = surface.evaluate(numbers, np.tile([1.0, 0, 0], (len(faces), 1)))
    assert np.array_equal(at.points, surface.points[faces[:, 0]])
    assert np.array_equal(at.normals, surface.normals[faces[:, 0]])
    np.testing.assert_allclose(near.points, at.points, atol=1e-4)


def test_no_points_are_no_error():
    points, normals = surface_of(meshes.octahedron()).evaluate([], np.zeros((0, 3)))
    assert points.shape == normals.shape == (0, 3)


@pytest.mark.parametrize(
    ("triangles", "barycentric", "message"),
    [
        ([8], [[1, 0, 0]], r"1 points are in triangles outside 0 … 7: points 0"),
        ([-1], [[1, 0, 0]], r"1 points are in triangles outside"),
        ([0.0], [[1, 0, 0]], r"triangles must be integers of shape \(k,\), not float64"),
        ([[0]], [[1, 0, 0]], r"triangles must be integers of shape \(k,\)"),
        ([0, 1], [[1, 0, 0]], r"barycentric must have shape \(2, 3\), not \(1, 3\)"),
        ([0, 1], [[1, 0, 0], [0.5, 0.6, 0]], "1 points lie outside their triangle: points 1;"),
        ([0], [[1.5, -0.5, 0]], "1 points lie outside their triangle"),
        ([0], [[np.nan, 0.5, 0.5]], "1 points lie outside their triangle"),
        ([0], [["a", "b", "c"]], "barycentric must be an array of numbers"),
    ],
)
def test_places_that_are_none_are_refused(triangles, barycentric, message):
    with pytest.raises(InputError, match=message):
        surface_of(meshes.octahedron()).evaluate(triangles, barycentric)


@pytest.mark.parametrize("sharp", [{"creases": [(0, 1)]}, {"corners": [0]}])
def test_creases_and_corners_are_refused(sharp):
    vertices, faces = meshes.octahedron()
    surface = LimitSurface(TriangleTopology(faces, len(vertices)), vertices, **sharp)
    with pytest.raises(InputError, match="creases or corners: refine it"):
        surface.evaluate([0], [[1, 0, 0]])


@pytest.mark.parametrize("make", [LimitSurface, lambda *args: LoopSpace(args[0]), mesh_density])
def test_faces_or_positions_for_the_topology_are_refused(make):
    vertices, faces = meshes.octahedron()
    topology = TriangleTopology(faces, len(vertices))
    for first, second in ((faces, vertices), (vertices, topology)):
        with pytest.raises(InputError, match=r"the topology comes first, TriangleTopology\(faces"):
            make(first, second)


@pytest.mark.parametrize("levels", [-1, 1.0, "2", None, True])
def test_levels_are_whole_numbers_from_0_on(levels):
    surface = surface_of(meshes.octahedron())
    for method in (surface.refined, surface.corner_normals):
        with pytest.raises(InputError, match="levels must be a whole number from 0 on, not"):
            method(levels)
