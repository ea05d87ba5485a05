"""The density as attributes of the mesh."""

import numpy as np
import pytest
from support.meshes import icosphere
from support.objects import add_object, add_rich_object, colors_by_vertex, numbers

from adaptive_fairing.blender.data.color_map import color_range, colors_srgb, srgb_to_linear
from adaptive_fairing.blender.data.coloring import write_field


@pytest.fixture
def mesh():
    return add_object(*icosphere(1)).data


@pytest.fixture
def values(mesh):
    return np.linspace(0.1, 0.9, len(mesh.vertices)).astype(np.float32)


def test_numbers_are_stored_as_they_are(mesh, values):
    write_field(mesh, "DENSITY", values)
    attribute = mesh.attributes["fairing_density"]
    assert (attribute.data_type, attribute.domain) == ("FLOAT", "POINT")
    np.testing.assert_array_equal(numbers(mesh, "fairing_density"), values)


def test_colors_are_those_of_the_map(mesh, values):
    values[:2], values[-2:] = 0, 2  # ends of the map
    low, high = write_field(mesh, "DENSITY", values)
    assert (low, high) == color_range(values) == (0, 2)
    attribute = mesh.color_attributes["fairing_density_color"]
    assert (attribute.data_type, attribute.domain) == ("FLOAT_COLOR", "POINT")
    stored = np.empty(4 * len(values), dtype=np.float32)
    attribute.data.foreach_get("color", stored)
    linear = srgb_to_linear(colors_srgb(values, low, high))
    np.testing.assert_array_equal(stored.reshape(-1, 4)[:, :3], linear.astype(np.float32))
    np.testing.assert_array_equal(stored.reshape(-1, 4)[:, 3], 1)
    # What a screen shows, by Blender's own conversion, which is good to 1e-4.
    shown = colors_by_vertex(mesh, "fairing_density_color")[:, :3]
    np.testing.assert_allclose(shown, colors_srgb(values, low, high), atol=1e-4)


def test_the_first_colours_of_a_mesh_are_active_and_rendered(mesh, values):
    write_field(mesh, "DENSITY", values)
    attributes = mesh.attributes
    assert attributes.active_color_name == attributes.default_color_name == "fairing_density_color"


def test_on_a_mesh_with_colours_the_active_one_and_that_of_renders_stay(mesh, values):
    attributes = mesh.attributes
    for name in ("scan", "other"):
        attributes.new(name, "FLOAT_COLOR", "POINT")
    attributes.active_color_name, attributes.default_color_name = "other", "scan"
    write_field(mesh, "DENSITY", values)
    assert (attributes.active_color_name, attributes.default_color_name) == ("other", "scan")


def test_a_second_run_writes_over_the_first(mesh, values):
    write_field(mesh, "DENSITY", values)
    names = [attribute.name for attribute in mesh.attributes]
    write_field(mesh, "DENSITY", 2 * values)
    assert [attribute.name for attribute in mesh.attributes] == names
    np.testing.assert_array_equal(numbers(mesh, "fairing_density"), 2 * values)


@pytest.mark.parametrize(("kind", "domain"), [("INT", "POINT"), ("FLOAT", "CORNER")])
def test_an_attribute_of_another_kind_gives_way(mesh, values, kind, domain):
    mesh.attributes.new("fairing_density", kind, domain)
    write_field(mesh, "DENSITY", values)
    np.testing.assert_array_equal(numbers(mesh, "fairing_density"), values)


def test_other_attributes_stay(values):
    mesh = add_rich_object().data
    heat, paint = numbers(mesh, "heat"), colors_by_vertex(mesh, "Paint")
    write_field(mesh, "DENSITY", np.ones(len(mesh.vertices)))
    np.testing.assert_array_equal(numbers(mesh, "heat"), heat)
    np.testing.assert_array_equal(colors_by_vertex(mesh, "Paint"), paint)


def test_one_number_per_vertex_is_demanded(mesh, values):
    with pytest.raises(ValueError, match="values of shape"):
        write_field(mesh, "DENSITY", values[:-1])
    assert "fairing_density" not in mesh.attributes


def test_a_few_extreme_densities_do_not_leave_the_rest_in_one_colour():
    mesh = add_object(*icosphere(3)).data
    density = np.linspace(1.0, 2.0, len(mesh.vertices))
    density[-1] = 1000.0
    write_field(mesh, "DENSITY", density)
    shown = colors_by_vertex(mesh, "fairing_density_color")[:, :3]
    low, high = np.percentile(density, (1, 99))
    assert high < 2
    np.testing.assert_allclose(shown, colors_srgb(density, low, high), atol=2e-4)
