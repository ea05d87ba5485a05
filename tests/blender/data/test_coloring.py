"""While a field is shown its colours are the active ones; after it all is as before."""

import bpy
import numpy as np
import pytest
from support.fields import add_denoised, show, state
from support.meshes import icosphere
from support.objects import add_object, add_rich_object, colors_by_vertex

from adaptive_fairing.blender.data.coloring import FIELD_ATTRIBUTES, color_name

pytestmark = pytest.mark.usefixtures("addon")


@pytest.fixture
def obj():
    return add_denoised()


@pytest.mark.parametrize("field", FIELD_ATTRIBUTES)
def test_a_field_is_the_active_and_the_rendered_colour_while_it_is_shown(obj, field):
    show("DISPLACEMENT")
    show(field)
    attributes, name = obj.data.attributes, color_name(FIELD_ATTRIBUTES[field])
    assert attributes.active_color_name == attributes.default_color_name == name
    assert obj.data.color_attributes.active_color.name == name


@pytest.mark.parametrize("field", FIELD_ATTRIBUTES)
def test_everything_is_as_before_when_it_is_hidden(obj, field):
    before = state(obj)
    show("CURVATURE")
    show(field)
    bpy.ops.object.adaptive_fairing_material()
    bpy.ops.object.adaptive_fairing_view_end()
    assert state(obj) == before


def test_other_colours_chosen_in_the_meantime_stay(obj):
    show()
    obj.data.attributes.active_color_name = "Scan"
    bpy.ops.object.adaptive_fairing_view_end()
    attributes = obj.data.attributes
    assert (attributes.active_color_name, attributes.default_color_name) == ("Scan", "Scan")


def test_a_mesh_of_two_objects_gets_its_own_colours_back(obj):
    other = bpy.data.objects.new("Other", obj.data)
    bpy.context.scene.collection.objects.link(other)
    other.select_set(True)
    show()
    bpy.ops.object.adaptive_fairing_view_end()
    attributes = obj.data.attributes
    assert (attributes.active_color_name, attributes.default_color_name) == ("Paint", "Scan")


@pytest.mark.parametrize("surface", ["LIMIT", "REFINED_1"])
def test_another_surface_shows_them_and_gives_them_back(obj, surface):
    before = state(obj)
    show("CURVATURE")
    bpy.ops.object.adaptive_fairing_material()
    bpy.ops.object.adaptive_fairing_surface(surface=surface)
    refined = obj.data
    assert refined.attributes.active_color_name == "fairing_mean_curvature_color"
    assert [slot.material["fairing_field"] for slot in obj.material_slots] == ["CURVATURE"] * 2
    bpy.ops.object.adaptive_fairing_view_end()
    assert refined.attributes.active_color_name == "Paint"
    bpy.ops.object.adaptive_fairing_surface(surface="CONTROL")
    assert state(obj) == before


def test_diffusion_leaves_its_density_active_on_a_mesh_without_colours():
    obj = add_object(*icosphere(2))
    obj.select_set(True)
    bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=1, tau=0.001)
    attributes = obj.data.attributes
    shown = "fairing_density_color"
    assert attributes.active_color_name == attributes.default_color_name == shown
    for field in ("CURVATURE", "DENSITY"):
        show(field)
        bpy.ops.object.adaptive_fairing_view_end()
        assert attributes.active_color_name == attributes.default_color_name == shown
    bpy.ops.object.adaptive_fairing_discard()
    assert attributes.active_color_name == attributes.default_color_name == ""


def test_diffusion_leaves_the_colours_of_a_mesh_active():
    obj = add_rich_object()
    obj.select_set(True)
    paint = colors_by_vertex(obj.data, "Paint")
    bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=1, tau=0.001)
    assert obj.data.attributes.active_color_name == "Paint"
    show()
    bpy.ops.object.adaptive_fairing_view_end()
    assert obj.data.attributes.active_color_name == "Paint"
    np.testing.assert_array_equal(colors_by_vertex(obj.data, "Paint"), paint)
