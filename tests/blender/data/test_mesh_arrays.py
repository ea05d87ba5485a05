"""Meshes between Blender and numpy."""

import bpy
import numpy as np
import pytest
from support.meshes import icosahedron
from support.objects import add_object, bumpy_box, polygons_of

from adaptive_fairing.blender.data.mesh_arrays import (
    MeshData,
    read_mesh,
    read_positions,
    welded,
    write_positions,
)
from adaptive_fairing.core import TriangleTopology


def test_triangles_come_back_as_they_went_in():
    vertices, faces = icosahedron()
    data = read_mesh(add_object(vertices, faces).data)
    np.testing.assert_array_equal(data.vertices, vertices.astype(np.float32))
    np.testing.assert_array_equal(data.triangles, faces)
    assert data.vertices.dtype == np.float64
    assert data.triangles.dtype == np.int32


def test_polygons_are_cut_for_the_solve_only():
    vertices, polygons = bumpy_box()
    mesh = add_object(vertices, polygons).data
    data = read_mesh(mesh)
    assert len(data.triangles) == sum(len(polygon) - 2 for polygon in polygons)
    assert TriangleTopology(data.triangles, len(vertices)).is_closed
    assert polygons_of(mesh) == [tuple(polygon) for polygon in polygons]


def test_loose_vertices_are_read_too():
    mesh = add_object([(0, 0, 0), (1, 0, 0), (0, 1, 0), (5, 6, 7)], [(0, 1, 2)]).data
    np.testing.assert_array_equal(read_mesh(mesh).vertices[3], (5, 6, 7))


def test_the_basis_is_read_whatever_the_keys_show():
    vertices, faces = icosahedron()
    obj = add_object(vertices, faces)
    obj.shape_key_add(name="Basis")
    moved = obj.shape_key_add(name="Moved")
    moved.points[0].co = (9, 9, 9)
    moved.value = 1.0
    np.testing.assert_array_equal(read_positions(obj.data), vertices.astype(np.float32))


def test_the_basis_is_read_even_where_the_mesh_itself_differs():
    vertices, faces = icosahedron()
    obj = add_object(vertices, faces)
    obj.shape_key_add(name="Basis")
    obj.data.shape_keys.reference_key.points[3].co = (4, 5, 6)
    np.testing.assert_array_equal(read_positions(obj.data)[3], (4, 5, 6))


def test_an_empty_mesh_is_read_as_one():
    data = read_mesh(bpy.data.meshes.new("Empty"))
    assert data.vertices.shape == (0, 3)
    assert data.triangles.shape == (0, 3)


def test_positions_are_written():
    vertices, faces = icosahedron()
    mesh = add_object(vertices, faces).data
    write_positions(mesh, 2 * vertices)
    np.testing.assert_array_equal(read_positions(mesh), (2 * vertices).astype(np.float32))


@pytest.mark.parametrize("shape", [(11, 3), (12, 2), (36,)])
def test_positions_of_a_wrong_shape_are_refused(shape):
    mesh = add_object(*icosahedron()).data
    with pytest.raises(ValueError, match=r"needs \(12, 3\)"):
        write_positions(mesh, np.zeros(shape))


def test_welding_joins_what_is_at_one_place():
    vertices, faces = icosahedron()
    soup = MeshData(vertices[faces].reshape(-1, 3), np.arange(60, dtype=np.int32).reshape(-1, 3))
    surface, surface_vertex = welded(soup)
    assert surface.vertices.shape == (12, 3)
    assert TriangleTopology(surface.triangles, 12).is_closed
    np.testing.assert_array_equal(surface.vertices[surface_vertex], soup.vertices)


def test_welding_drops_triangles_that_lose_a_corner():
    vertices = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 0, 0)], dtype=float)
    data = MeshData(vertices, np.array([(0, 1, 2), (1, 3, 2)], dtype=np.int32))
    surface, _ = welded(data)
    assert len(surface.triangles) == 1
