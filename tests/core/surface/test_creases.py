"""Creases: what is sharp stays sharp, and neither side knows of the other."""

import numpy as np
import pytest
from support import meshes

from adaptive_fairing.core import LimitSurface, TriangleTopology
from adaptive_fairing.core.surface.masks import dart_masks
from adaptive_fairing.core.surface.refined_topology import CORNER, CREASE, DART, SMOOTH


def cube():
    """Return a cube of two triangles a face, and its 12 edges."""
    corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))], dtype=np.int32)
    edges = [(a, b) for a in range(8) for b in range(a) if (a ^ b) in (1, 2, 4)]
    return corners, faces, edges


def equator(n_segments):
    """Return a sphere, its equator as a closed crease, and the triangles of the northern half."""
    vertices, faces = meshes.latlong_sphere(n_segments, 5)
    ring = 2 * n_segments + np.arange(n_segments)
    north = (vertices[faces][..., 2] > -1e-9).all(axis=1)
    return vertices, faces, np.stack([ring, np.roll(ring, -1)], axis=1), north


def surface_of(vertices, faces, creases, **rest):
    return LimitSurface(TriangleTopology(faces, len(vertices)), vertices, creases, **rest)


def finer_surface(surface, levels):
    """Return the surface of the refined control mesh, its connectivity found anew."""
    mesh = surface.levels.mesh(levels)
    inner = mesh.is_sharp & (mesh.right >= 0)
    control = surface.levels.control_points(surface.positions, levels)[-1]
    corners = np.flatnonzero(mesh.kind == CORNER)
    return surface_of(control, mesh.triangles, mesh.edges[inner], corners=corners)


def test_cube_of_sharp_edges_stays_a_cube():
    vertices, faces, edges = cube()
    refined = surface_of(vertices, faces, edges).refined(3)
    assert np.array_equal(refined.vertices[:8], vertices)
    assert abs(refined.vertices.min()) < 1e-15 and abs(refined.vertices.max() - 1) < 1e-15
    normals = surface_of(vertices, faces, edges).corner_normals(3)
    a, b, c = np.moveaxis(refined.vertices[refined.triangles], 1, 0)
    flat = np.cross(b - a, c - a)
    areas = np.linalg.norm(flat, axis=1) / 2
    assert areas.sum() == pytest.approx(6, abs=1e-12)
    # Every triangle lies in a face, with the face's normal at all corners.
    of_faces = flat[:, None] / (2 * areas[:, None, None])
    np.testing.assert_allclose(normals, np.repeat(of_faces, 3, axis=1), atol=1e-12)
    # Along the edges the points run straight, 8 pieces each.
    on_edge = (np.abs(refined.vertices - refined.vertices.round()) < 1e-15).sum(axis=1) >= 2
    assert np.count_nonzero(on_edge) == 8 + 12 * 7


@pytest.mark.parametrize("levels", [0, 1, 2])
def test_the_two_sides_are_the_surfaces_of_the_halves(levels):
    """A closed crease is the boundary of both sides: same points, same one-sided normals."""
    vertices, faces, crease, north = equator(7)
    whole = surface_of(vertices, faces, crease)
    refined, corner_normals = whole.refined(levels), whole.corner_normals(levels)
    children = np.repeat(north, 4**levels)
    for half, own in ((north, children), (~north, ~children)):
        part_vertices, part_faces = meshes.keep_faces(vertices, faces, half)
        part = surface_of(part_vertices, part_faces, [])
        alone = part.refined(levels)
        ours, theirs = refined.vertices[refined.triangles[own]], alone.vertices[alone.triangles]
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-14)
        np.testing.assert_allclose(
            alone.normals[alone.triangles], corner_normals[own], rtol=0, atol=1e-12
        )


def test_motion_of_one_side_does_not_reach_the_other():
    vertices, faces, crease, north = equator(7)
    surface = surface_of(vertices, faces, crease)
    moved = vertices + (vertices[:, 2:] < -1e-9) * (0.3, -0.2, 0.5)
    children = np.repeat(north, 16)
    before, after = surface.refined(2), surface.moved(moved).refined(2)
    of_north = np.unique(before.triangles[children])
    assert np.array_equal(before.vertices[of_north], after.vertices[of_north])
    assert not np.array_equal(before.vertices, after.vertices)


def test_kinds_of_vertices():
    vertices, faces = meshes.torus(6, 6)
    topology = TriangleTopology(faces, 36)
    # A path of three edges from vertex 0, and one that meets it in the middle.
    creases = [(0, 1), (1, 2), (2, 3), (1, 7)]
    mesh = LimitSurface(topology, vertices, creases, corners=[20]).levels.mesh(0)
    kinds = {DART: [0, 3, 7], CREASE: [2], CORNER: [1, 20]}
    expected = np.full(36, SMOOTH)
    for kind, members in kinds.items():
        expected[members] = kind
    assert np.array_equal(mesh.kind, expected)


@pytest.mark.parametrize("valence", [3, 4, 5, 6, 7, 12])
def test_dart_masks_are_eigenvectors(valence):
    """A crease that ends at a pole: control points of all levels have the same limit there."""
    vertices, faces = meshes.latlong_sphere(valence, 4)
    north = len(vertices) - 2
    rng = np.random.default_rng(valence)
    vertices = vertices + 0.1 * rng.standard_normal(vertices.shape)
    surface = surface_of(vertices, faces, [(north, 0), (0, valence)])
    assert surface.levels.mesh(0).kind[north] == DART
    for levels in (1, 2):
        fresh = finer_surface(surface, levels)
        np.testing.assert_allclose(fresh.points[north], surface.points[north], atol=1e-12)
        np.testing.assert_allclose(fresh.normals[north], surface.normals[north], atol=1e-9)
    limit, along, across = dart_masks(valence)
    assert limit.min() > 0 and limit.sum() == pytest.approx(1, abs=1e-14)
    assert abs(along.sum()) < 1e-12 and abs(across.sum()) < 1e-12
    # Repeated subdivision goes there, with no use of the mask.
    deep = surface.levels.control_points(vertices, 5)[-1]
    assert np.linalg.norm(deep[north] - surface.points[north]) < 0.01


@pytest.mark.parametrize("levels", [1, 2])
def test_points_and_normals_do_not_depend_on_the_level(levels):
    """Crossing creases, darts and a corner inside, on a mesh of valences 3 to 10."""
    vertices, faces = meshes.random_closed(3)
    rng = np.random.default_rng(0)
    edges = meshes.edges_of(faces)
    creases = edges[rng.random(len(edges)) < 0.25]
    surface = surface_of(vertices, faces, creases, corners=[5])
    kinds = surface.levels.mesh(0).kind
    assert set(kinds.tolist()) == {0, 1, 2, 3}
    refined, fresh = surface.refined(levels), finer_surface(surface, levels)
    np.testing.assert_allclose(refined.vertices, fresh.points, rtol=0, atol=1e-12)
    np.testing.assert_allclose(refined.normals, fresh.normals, rtol=0, atol=1e-9)
    of_corners = surface.corner_normals(levels)
    np.testing.assert_allclose(of_corners, fresh.corner_normals(0), rtol=0, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(of_corners, axis=2), 1, atol=1e-12)
    # Corner 0 of child 0 of child 0 … is the coarse corner 0; children 1 and 2 begin at theirs.
    of_children = of_corners.reshape(-1, 4**levels, 3, 3)
    for k, child in enumerate(np.arange(3) * 4 ** (levels - 1)):
        np.testing.assert_allclose(
            of_children[:, child, 0], surface.corner_normals(0)[:, k], rtol=0, atol=1e-9
        )
    is_corner = np.flatnonzero(kinds == CORNER)
    assert np.array_equal(refined.vertices[is_corner], vertices[is_corner])


def test_open_crease_of_a_boundary_edge_changes_nothing():
    vertices, faces = meshes.bumpy_disc(1)
    plain = surface_of(vertices, faces, [])
    loop = meshes.boundary_loop(faces)
    marked = surface_of(vertices, faces, np.stack([loop, np.roll(loop, -1)], axis=1))
    for a, b in zip(plain.refined(2), marked.refined(2), strict=True):
        assert np.array_equal(a, b)


def test_corner_on_a_straight_line_has_the_normal_of_its_triangles():
    vertices, faces = meshes.flat_grid(3, 3)
    on_boundary = TriangleTopology(faces, len(vertices)).boundary_vertices
    pinned = surface_of(vertices, faces, [], corners=on_boundary)
    refined = pinned.refined(1)
    np.testing.assert_allclose(refined.normals, np.tile((0, 0, 1), (len(refined.normals), 1)))
    assert np.array_equal(refined.vertices[on_boundary], vertices[on_boundary])
