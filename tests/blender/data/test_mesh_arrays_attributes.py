"""Attributes of every type and domain, read as arrays and written back."""

import bpy
import numpy as np
import pytest
from support.meshes import icosphere
from support.objects import add_object

from adaptive_fairing.blender.data.mesh_arrays import (
    GEOMETRY,
    STORAGE,
    AttributeArray,
    read_attributes,
    read_or_zeros,
    remove_attributes,
    write_attribute,
)

KNOWN = bpy.types.Attribute.bl_rna.properties["data_type"].enum_items.keys()
KINDS = [kind for kind in STORAGE if kind in KNOWN]  # Blender 4.2 has fewer


@pytest.fixture
def mesh():
    return add_object(*icosphere(1)).data


def size_of(mesh, domain):
    sizes = {"POINT": mesh.vertices, "EDGE": mesh.edges, "FACE": mesh.polygons}
    return len(sizes.get(domain, mesh.loops))


def random_values(kind, size):
    _, width, dtype = STORAGE[kind]
    shape = (size,) if width == 1 else (size, width)
    values = np.random.default_rng(3).integers(0, 100, shape)
    # Colours in bytes hold 255 steps of sRGB: only black and white are exact.
    return (values > 50 if kind in ("BOOLEAN", "BYTE_COLOR") else values).astype(dtype)


@pytest.mark.parametrize("domain", ["POINT", "EDGE", "FACE", "CORNER"])
@pytest.mark.parametrize("kind", KINDS)
def test_what_was_written_is_read_again(mesh, kind, domain):
    if kind == "QUATERNION":
        values = np.tile(np.float32([1, 0, 0, 0]), (size_of(mesh, domain), 1))
    else:
        values = random_values(kind, size_of(mesh, domain))
    write_attribute(mesh, AttributeArray("mine", kind, domain, values))
    (found,) = (array for array in read_attributes(mesh) if array.name == "mine")
    assert found[:3] == ("mine", kind, domain)
    assert found.values.dtype == values.dtype
    np.testing.assert_array_equal(found.values, values)


def test_texts_are_kept(mesh):
    texts = np.array([f"vertex {i}".encode() for i in range(len(mesh.vertices))], dtype=object)
    write_attribute(mesh, AttributeArray("name", "STRING", "POINT", texts))
    (found,) = (array for array in read_attributes(mesh) if array.name == "name")
    assert found.values.tolist() == texts.tolist()


def test_the_geometry_and_unwanted_names_are_left_out(mesh):
    mesh.attributes.new("mine", "FLOAT", "POINT")
    mesh.attributes.new("yours", "FLOAT", "POINT")
    names = {array.name for array in read_attributes(mesh, without=("yours",))}
    assert "mine" in names
    assert not names & {"yours", *GEOMETRY}


@pytest.mark.parametrize(("kind", "domain"), [("INT", "POINT"), ("FLOAT", "FACE")])
def test_one_of_another_kind_gives_way(mesh, kind, domain):
    mesh.attributes.new("mine", kind, domain)
    values = np.arange(len(mesh.vertices), dtype=np.float32)
    write_attribute(mesh, AttributeArray("mine", "FLOAT", "POINT", values))
    assert mesh.attributes["mine"].domain == "POINT"
    np.testing.assert_array_equal(read_or_zeros(mesh, "mine", len(values)), values)


def test_absent_ones_are_no_error_and_read_as_nothing(mesh):
    n = len(mesh.vertices)
    before = mesh.attributes.keys()
    remove_attributes(mesh, ["absent"])
    assert mesh.attributes.keys() == before
    assert not read_or_zeros(mesh, "absent", n, bool).any()
    assert not read_or_zeros(mesh, "absent", n).any()
    flag = mesh.attributes.new("flag", "BOOLEAN", "POINT")
    flag.data[3].value = True
    assert np.flatnonzero(read_or_zeros(mesh, "flag", n, bool)).tolist() == [3]
    remove_attributes(mesh, ["flag"])
    assert "flag" not in mesh.attributes


def test_colours_that_are_gone_are_not_the_active_ones(mesh):
    attributes = mesh.attributes
    for name in ("first", "second"):
        attributes.new(name, "FLOAT_COLOR", "POINT")
    attributes.active_color_name = attributes.default_color_name = "second"
    for gone, left in (("second", "first"), ("first", "")):
        remove_attributes(mesh, [gone])
        assert (attributes.active_color_name, attributes.default_color_name) == (left, left)
