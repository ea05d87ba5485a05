"""The limit surface against whole-mesh subdivision by brute force, with boundaries."""

import numpy as np
import pytest
from scipy.spatial import cKDTree
from support import meshes
from support.reference import limit_matrix, subdivision_matrix

from adaptive_fairing.core import InputError, LimitSurface, TriangleTopology

CASES = {
    "tetrahedron": meshes.tetrahedron(),
    "seven vertices": meshes.seven_vertex_torus(),
    "valences 3 to 10": meshes.random_closed(1),
    "pole of valence 44": meshes.bipyramid(44),
    "one triangle": meshes.single_triangle(),
    "open, irregular": meshes.bumpy_disc(0),
    "open, other": meshes.bumpy_disc(3),
    "two components": meshes.merged(meshes.octahedron(), meshes.open_cylinder(5, 2)),
}


def surface_of(mesh):
    return LimitSurface(TriangleTopology(mesh[1], len(mesh[0])), mesh[0])


def brute_force(mesh, levels):
    """Return control points and faces after whole-mesh subdivisions."""
    vertices, faces = mesh
    for _ in range(levels):
        matrix, faces = subdivision_matrix(faces, len(vertices))
        vertices = matrix @ vertices
    return vertices, faces


def turned(triangles):
    """Triangles with their least vertex first, in a fixed order."""
    first = triangles.argmin(axis=1)[:, None]
    triangles = np.take_along_axis(triangles, (first + np.arange(3)) % 3, axis=1)
    return triangles[np.lexsort(triangles.T)]


@pytest.mark.parametrize("name", CASES)
def test_points_are_the_limit_of_subdivision(name):
    mesh = CASES[name]
    expected = limit_matrix(mesh[1].astype(np.int64), len(mesh[0])) @ mesh[0]
    assert np.abs(surface_of(mesh).points - expected).max() < 1e-12


@pytest.mark.parametrize("levels", [1, 2, 3])
@pytest.mark.parametrize("name", CASES)
def test_refined_is_subdivision_and_the_limit(name, levels):
    """The same vertices and the same triangles as the whole mesh subdivided by brute force."""
    mesh = CASES[name]
    control, faces = brute_force(mesh, levels)
    expected = limit_matrix(faces, len(control)) @ control
    refined = surface_of(mesh).refined(levels)
    distance, ours = cKDTree(refined.vertices).query(expected)
    assert distance.max() < 1e-12
    assert np.array_equal(np.sort(ours), np.arange(len(refined.vertices)))
    assert np.array_equal(turned(ours[faces]), turned(refined.triangles.astype(np.int64)))
    # The old vertices come first and stay on their points of the surface.
    assert np.abs(refined.vertices[: len(mesh[0])] - surface_of(mesh).points).max() < 1e-12


@pytest.mark.parametrize("name", CASES)
def test_children_of_a_triangle_lie_in_it(name):
    """Triangles 4 f … 4 f + 3 have the corners and the edge points of f."""
    mesh = CASES[name]
    coarse = surface_of(mesh).levels.mesh(0)
    n = len(mesh[0])
    fine = coarse.finer.triangles.reshape(-1, 4, 3)
    expected = np.concatenate([coarse.triangles, n + coarse.sides], axis=1)
    found = [np.unique(children) for children in fine]
    assert all(np.array_equal(a, np.sort(b)) for a, b in zip(found, expected, strict=True))


@pytest.mark.parametrize("levels", [1, 2])
@pytest.mark.parametrize("name", CASES)
def test_finer_connectivity_is_that_of_the_triangles(name, levels):
    """Edges, twins and ordered rings by arithmetic agree with those found by searching."""
    mesh = CASES[name]
    fine = surface_of(mesh).levels.mesh(levels)
    topology = TriangleTopology(fine.triangles, fine.n_vertices)
    ends = np.stack([topology.origins, fine.triangles[:, [1, 2, 0]].reshape(-1)], axis=1)
    assert np.array_equal(ends[fine.left], fine.edges)
    inner = fine.right >= 0
    assert np.array_equal(ends[fine.right[inner]], fine.edges[inner, ::-1])
    assert np.array_equal(topology.twin[fine.left], fine.right)
    assert np.array_equal(fine.sides.reshape(-1)[fine.left], np.arange(len(fine.edges)))
    assert np.array_equal(fine.on_boundary, topology.on_boundary)
    owner = np.repeat(np.arange(fine.n_vertices), fine.ring_size)
    to_edge = np.sort(fine.edges[fine.ring_edges], axis=1)
    assert np.array_equal(to_edge, np.sort(np.stack([owner, fine.ring], axis=1), axis=1))
    for v in range(fine.n_vertices):
        ours = fine.ring[fine.ring_start[v] : fine.ring_start[v + 1]]
        theirs = topology.ring[topology.ring_start[v] : topology.ring_start[v + 1]]
        shift = 0 if topology.on_boundary[v] else int(np.flatnonzero(theirs == ours[0])[0])
        assert np.array_equal(ours, np.roll(theirs, -shift))


@pytest.mark.parametrize("levels", [1, 2])
@pytest.mark.parametrize("name", CASES)
def test_refined_is_the_surface_of_the_finer_control_mesh(name, levels):
    """The masks are eigenvectors: refined control points have the same limits and normals."""
    surface = surface_of(CASES[name])
    refined = surface.refined(levels)
    control = surface.levels.control_points(surface.positions, levels)[-1]
    fresh = surface_of((control, refined.triangles))
    np.testing.assert_allclose(refined.vertices, fresh.points, rtol=0, atol=1e-12)
    np.testing.assert_allclose(refined.normals, fresh.normals, rtol=0, atol=1e-10)


@pytest.mark.parametrize("name", ["valences 3 to 10", "open, irregular", "open, other"])
def test_normals_are_those_of_ever_smaller_triangles(name):
    """After many steps the triangles around a vertex have the normal of the surface.

    That is a tangent plane only inside and, at the boundary, with at most five triangles.
    """
    mesh = CASES[name]
    topology = TriangleTopology(mesh[1], len(mesh[0]))
    has_plane = ~topology.on_boundary | (topology.ring_size <= 6)
    assert np.count_nonzero(has_plane) > 10
    # Beside a single triangle of the boundary everything flattens twice as fast as it shrinks.
    is_single = topology.ring_size == 2
    for levels, chosen in ((20, has_plane & is_single), (60, has_plane & ~is_single)):
        centres = np.flatnonzero(chosen)
        if not len(centres):  # of a closed surface
            continue
        normals, centre_of = smallest_normals(mesh, centres, levels)
        errors = np.abs(normals - surface_of(mesh).normals[centres][centre_of]).max(axis=1)
        assert np.array_equal(np.unique(centre_of), np.arange(len(centres)))
        assert (errors < 0.01).all(), (centres[centre_of], errors)


def smallest_normals(mesh, centres, levels):
    """Subdivide around each of some vertices; all of them at once, as pieces of one mesh.

    Returns the unit normals of the triangles at the centres, and which centre each belongs to.
    """
    vertices, faces = mesh
    n = len(vertices)
    piece = np.repeat(np.arange(len(centres)), n)
    vertices = np.tile(vertices, (len(centres), 1))
    faces = (faces + n * np.arange(len(centres))[:, None, None]).reshape(-1, 3)
    centres = centres + n * np.arange(len(centres))
    for _ in range(levels):
        is_near = np.zeros(len(vertices), dtype=bool)
        is_near[faces[np.isin(faces, centres).any(axis=1)]] = True
        used, renumbered = np.unique(faces[is_near[faces].any(axis=1)], return_inverse=True)
        vertices, piece = vertices[used] - vertices[centres[piece[used]]], piece[used]
        faces, centres = renumbered.reshape(-1, 3), np.searchsorted(used, centres)
        size = np.zeros(len(centres))
        np.maximum.at(size, piece, np.abs(vertices).max(axis=1))
        matrix, faces = subdivision_matrix(faces, len(vertices))
        vertices = matrix @ (vertices / size[piece, None])
        piece = piece[matrix.indices[matrix.indptr[:-1]]]
    at_centre = faces[np.isin(faces, centres).any(axis=1)]
    a, b, c = np.moveaxis(vertices[at_centre], 1, 0)
    normals = np.cross(b - a, c - a)
    return normals / np.linalg.norm(normals, axis=1, keepdims=True), piece[at_centre[:, 0]]


def test_other_positions_share_the_matrices():
    vertices, faces = CASES["open, irregular"]
    surface = surface_of((vertices, faces))
    stretched = vertices * (1.0, 2.0, 3.0)
    moved = surface.moved(stretched)
    assert moved.refinement_matrix(2) is surface.refinement_matrix(2)
    fresh = surface_of((stretched, faces)).refined(2)
    for ours, theirs in zip(moved.refined(2), fresh, strict=True):
        assert np.array_equal(ours, theirs)


def test_loose_vertices_stay():
    vertices, faces = meshes.octahedron()
    vertices = np.vstack([vertices, [(5.0, 6.0, 7.0)]])
    surface = surface_of((vertices, faces))
    refined = surface.refined(1)
    assert np.array_equal(refined.vertices[6], vertices[6])
    assert np.array_equal(surface.points[6], vertices[6])
    assert np.array_equal(refined.normals[6], (0, 0, 0))
    assert np.isnan(surface.mean_curvature[6]) and np.isfinite(surface.mean_curvature[:6]).all()


def test_errors_name_what_is_wrong():
    vertices, faces = meshes.octahedron()
    topology = TriangleTopology(faces, 6)
    with pytest.raises(InputError, match="5 positions for 6 vertices"):
        LimitSurface(topology, vertices[:5])
    with pytest.raises(InputError, match=r"1 creases are not edges of the mesh: \(4, 5\)"):
        LimitSurface(topology, vertices, creases=[(0, 1), (4, 5)])
    with pytest.raises(InputError, match="creases use vertices outside 0 … 5"):
        LimitSurface(topology, vertices, creases=[(0, 6)])
    with pytest.raises(InputError, match="corners use vertices outside 0 … 5"):
        LimitSurface(topology, vertices, corners=[-1])
