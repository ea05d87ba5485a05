"""Vertices at the same place become one; what corners have stays apart."""

import numpy as np
from support.meshes import icosphere
from support.objects import add_object, everything

from adaptive_fairing.blender.data.mesh_arrays import read_mesh_coordinates, weld


def test_triangles_of_their_own_become_a_closed_surface_and_keep_their_uvs():
    vertices, triangles = icosphere(1)
    mesh = add_object(vertices[triangles.ravel()], np.arange(triangles.size).reshape(-1, 3)).data
    uv = np.random.default_rng(2).random(2 * len(mesh.loops), dtype=np.float32)
    mesh.uv_layers.new(name="UV").uv.foreach_set("vector", uv)
    weld(mesh)
    assert len(mesh.vertices) == len(vertices)
    assert len(mesh.edges) == len(vertices) + len(triangles) - 2  # Euler: a sphere
    assert not mesh.validate()
    found = {tuple(row) for row in read_mesh_coordinates(mesh).tolist()}
    assert found == {tuple(row) for row in vertices.astype(np.float32).tolist()}
    kept = np.empty_like(uv)
    mesh.uv_layers["UV"].uv.foreach_get("vector", kept)
    np.testing.assert_array_equal(kept, uv)


def test_near_is_not_the_same_place():
    vertices, triangles = icosphere(0)
    vertices = np.concatenate([vertices, vertices[:1] + 1e-6])
    obj = add_object(vertices, triangles)
    before = everything(obj)
    weld(obj.data)
    assert everything(obj) == before


def test_a_polygon_without_three_places_goes():
    vertices = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 0, 0)]
    mesh = add_object(vertices, [(0, 1, 2), (0, 1, 3)]).data
    weld(mesh)
    assert [sorted(polygon.vertices) for polygon in mesh.polygons] == [[0, 1, 2]]
