"""An object gets a refined mesh with all that it had; the old mesh is not changed."""

import bpy
import numpy as np
import pytest
from scipy.spatial import cKDTree
from support.meshes import icosphere
from support.objects import add_object, add_rich_object, everything, key_positions

from adaptive_fairing.blender.data.mesh_arrays import read_mesh_coordinates, read_values
from adaptive_fairing.blender.data.refined_object import (
    RefineOptions,
    control_surface,
    refine_object,
)
from adaptive_fairing.blender.data.stored_path import write_vectors
from adaptive_fairing.core import FairingError, LimitSurface, TriangleTopology

ROUNDING = 1e-6


def limit(obj_or_vertices, levels):
    vertices, triangles = icosphere(1)
    surface = LimitSurface(TriangleTopology(triangles, len(vertices)), np.asarray(obj_or_vertices))
    return surface.refined(levels).vertices


@pytest.mark.parametrize("levels", [0, 1, 2])
def test_vertices_lie_on_the_limit_surface(obj, levels):
    vertices, triangles = icosphere(1)
    assert refine_object(obj, RefineOptions(levels)) == ()
    assert len(obj.data.polygons) == len(triangles) * 4**levels
    np.testing.assert_allclose(read_mesh_coordinates(obj.data), limit(vertices, levels), atol=1e-6)


def test_off_the_limit_two_steps_are_one_and_one(obj):
    other = add_object(*icosphere(1))
    refine_object(obj, RefineOptions(2, on_limit=False))
    for _ in range(2):
        refine_object(other, RefineOptions(1, on_limit=False))
    # The vertices are the same, in another order.
    found, expected = (read_mesh_coordinates(each.data) for each in (obj, other))
    distance, nearest = cKDTree(expected).query(found)
    assert distance.max() < ROUNDING
    assert sorted(nearest) == list(range(len(expected)))


def test_the_old_mesh_stays_where_somebody_uses_it_and_goes_where_nobody_does(obj):
    mesh = obj.data
    other = bpy.data.objects.new("Other", mesh)
    before = everything(other)
    refine_object(obj, RefineOptions(1))
    assert other.data == mesh != obj.data
    assert everything(other) == before
    name = obj.data.name
    refine_object(obj, RefineOptions(1))
    assert obj.data.name == name
    assert len(bpy.data.meshes) == 2


def test_keys_and_differences_of_places_are_refined_as_the_positions_are(obj):
    rng = np.random.default_rng(2)
    vertices = read_mesh_coordinates(obj.data).astype(float)
    offset = rng.normal(size=vertices.shape)
    write_vectors(obj.data, "offset", offset)
    obj.shape_key_add(name="Basis", from_mix=False)
    smile = vertices + rng.normal(scale=0.1, size=vertices.shape)
    obj.shape_key_add(name="Smile", from_mix=False).points.foreach_set("co", smile.ravel())
    refine_object(obj, RefineOptions(1), shapes=("offset",))
    np.testing.assert_allclose(key_positions(obj, "Smile"), limit(smile, 1), atol=ROUNDING)
    np.testing.assert_allclose(
        read_values(obj.data.attributes["offset"]), limit(offset, 1), atol=5e-6
    )


def test_polygons_hand_their_materials_and_corners_their_maps_to_the_pieces():
    obj = add_rich_object()
    names = {layer.name for layer in obj.data.uv_layers}
    materials = [material.name for material in obj.data.materials]
    areas = {}
    for polygon in obj.data.polygons:
        n_triangles = len(polygon.vertices) - 2
        areas[polygon.material_index] = areas.get(polygon.material_index, 0) + n_triangles
    refine_object(obj, RefineOptions(1))
    assert {layer.name for layer in obj.data.uv_layers} == names
    assert [material.name for material in obj.data.materials] == materials
    found = np.bincount([polygon.material_index for polygon in obj.data.polygons])
    assert found.tolist() == [4 * areas[0], 4 * areas[1]]


def test_sharp_edges_are_creases_of_the_surface(obj):
    assert not control_surface(obj.data).levels.has_creases
    sharp = obj.data.attributes.new("sharp_edge", "BOOLEAN", "EDGE")
    sharp.data[0].value = True
    assert control_surface(obj.data).levels.has_creases


def test_a_mesh_without_faces_is_refused():
    obj = add_object([(0, 0, 0), (1, 0, 0)], [])
    with pytest.raises(FairingError, match="no faces"):
        refine_object(obj, RefineOptions(1))
