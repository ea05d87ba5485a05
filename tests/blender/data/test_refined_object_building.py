"""A mesh built from arrays is the one that Blender builds from lists."""

import bpy
import numpy as np
import pytest
from support.meshes import icosphere
from support.objects import add_object, add_rich_object, everything

from adaptive_fairing.blender.data.mesh_arrays import integers, read_attributes
from adaptive_fairing.blender.data.refined_object import fill, write_attributes, write_normals


def edges_and_sides(mesh):
    edges = integers(mesh.attributes[".edge_verts"].data, "value", 2)
    sides = integers(mesh.attributes[".corner_edge"].data, "value", 1).reshape(-1, 3)
    return edges, sides


def test_it_is_valid_and_the_same_mesh():
    vertices, triangles = icosphere(2)
    expected = add_object(vertices, triangles)
    expected.data.shade_smooth()  # as arrays without a word on it are
    built = bpy.data.objects.new("Built", bpy.data.meshes.new("Built"))
    fill(built.data, vertices, triangles, *edges_and_sides(expected.data))
    assert not built.data.validate()
    assert everything(built) == everything(expected)


def test_loose_edges_are_edges_of_it():
    vertices, triangles = icosphere(0)
    made = add_object(vertices, triangles).data
    edges, sides = edges_and_sides(made)
    mesh = bpy.data.meshes.new("Built")
    far = np.concatenate([vertices, [[5.0, 0, 0], [6.0, 0, 0]]])
    loose = [[len(vertices), len(vertices) + 1]]
    fill(mesh, far, triangles, np.concatenate([edges, loose]), sides)
    assert not mesh.validate()
    assert tuple(mesh.edges[-1].vertices) == tuple(loose[0])
    assert mesh.edges[-1].is_loose


def test_attributes_come_with_the_choice_of_maps_and_colours():
    source = add_rich_object().data
    source.uv_layers.new(name="Second").active_render = True
    source.uv_layers.active_index = 1
    target = source.copy()
    arrays = read_attributes(source)
    for name in [array.name for array in arrays if not array.name.startswith(".")]:
        if name in target.attributes:
            target.attributes.remove(target.attributes[name])
    write_attributes(target, source, arrays)
    assert target.uv_layers.active.name == "Second"
    assert target.uv_layers["Second"].active_render
    assert target.color_attributes.active_color.name == "Paint"
    for old, new in zip(sorted(arrays), sorted(read_attributes(target)), strict=True):
        assert old[:3] == new[:3]
        np.testing.assert_array_equal(old.values, new.values)


@pytest.mark.parametrize("follow_motion", [False, True])
@pytest.mark.parametrize("domain", ["POINT", "CORNER"])
def test_normals_are_those_that_were_written(domain, follow_motion):
    mesh = add_object(*icosphere(2)).data
    size = len(mesh.vertices) if domain == "POINT" else len(mesh.loops)
    normals = np.empty(3 * size, dtype=np.float32)
    (mesh.vertex_normals if domain == "POINT" else mesh.corner_normals).foreach_get(
        "vector", normals
    )
    tilted = normals.reshape(-1, 3) + np.array([0.2, 0.0, 0.1])
    tilted /= np.linalg.norm(tilted, axis=1, keepdims=True)
    write_normals(mesh, tilted, follow_motion)
    shown = np.empty(3 * len(mesh.loops), dtype=np.float32)
    mesh.corner_normals.foreach_get("vector", shown)
    corners = integers(mesh.attributes[".corner_vert"].data, "value", 1)
    expected = tilted[corners] if domain == "POINT" else tilted
    # Blender keeps two angles of 16 bits in a frame of the corner.
    np.testing.assert_allclose(shown.reshape(-1, 3), expected, atol=2e-3)


@pytest.mark.usefixtures("addon")
def test_colours_of_which_none_is_active_are_copied_without_a_word(noisy, capfd):
    noisy.data.color_attributes.new("Paint", "FLOAT_COLOR", "POINT")
    noisy.data.attributes.active_color_name = noisy.data.attributes.default_color_name = ""
    assert noisy.data.color_attributes.active_color_index == -1
    bpy.ops.object.adaptive_fairing()
    bpy.ops.object.adaptive_fairing_surface(surface="REFINED_1")
    colors = noisy.data.color_attributes
    assert "Paint" in colors
    assert (colors.active_color_index, colors.render_color_index) == (-1, -1)
    said = capfd.readouterr()
    assert "color_index" not in said.out + said.err
