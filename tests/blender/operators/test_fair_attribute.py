"""Fair Attribute: what it chooses, what it says, and that it does as the job does."""

import bpy
import numpy as np
import pytest
from support.layouts import FakeContext, FakeLayout, draw
from support.meshes import icosphere, noisy_ball
from support.objects import add_object, colors_by_vertex, numbers, select

from adaptive_fairing.blender.data.mesh_arrays import read_mesh_coordinates
from adaptive_fairing.blender.data.vertex_groups import add_weights, group_weights
from adaptive_fairing.blender.jobs.fair_attribute import fair_attribute
from adaptive_fairing.blender.ui import attribute_panel
from adaptive_fairing.core import FairingSettings

pytestmark = pytest.mark.usefixtures("addon")


def add_carrier(name="Thing", location=0.0):
    """A ball with two float colours, a number, and two groups; the second of each is active."""
    obj = add_object(*noisy_ball(2, 0.02), name=name)
    obj.location.x = location
    mesh, n = obj.data, len(obj.data.vertices)
    rng = np.random.default_rng(5)
    for each in ("Back", "Front"):
        color = mesh.attributes.new(each, "FLOAT_COLOR", "POINT")
        color.data.foreach_set("color", rng.random(4 * n, dtype=np.float32))
    mesh.attributes.active_color_name = "Front"
    mesh.attributes.new("heat", "FLOAT", "POINT").data.foreach_set(
        "value", rng.random(n, dtype=np.float32)
    )
    for each in ("low", "high"):
        add_weights(obj.vertex_groups.new(name=each), range(n), rng.random(n, dtype=np.float32))
    obj.vertex_groups.active = obj.vertex_groups["high"]
    obj.select_set(True)
    mesh.update()
    return obj


def carried(obj):
    found = {name: colors_by_vertex(obj.data, name) for name in ("Back", "Front")}
    found["heat"] = numbers(obj.data, "heat")
    return found | {group.name: group_weights(obj, group) for group in obj.vertex_groups}


def differences(obj, before):
    return {
        name for name, values in carried(obj).items() if not np.array_equal(values, before[name])
    }


@pytest.mark.parametrize(
    ("options", "name"),
    [
        ({}, "Front"),
        ({"source": "GROUP"}, "high"),
        ({"source": "NAMED", "attribute": "heat"}, "heat"),
        ({"source": "NAMED", "attribute": "low"}, "low"),
    ],
)
def test_it_fairs_one_thing_as_the_job_does(options, name):
    obj, other = add_carrier(), add_carrier()
    before, shape = carried(obj), read_mesh_coordinates(obj.data)
    assert bpy.ops.object.adaptive_fairing_attribute(radius=1.5, steps=3, **options) == {"FINISHED"}
    assert differences(obj, before) == {name}
    assert np.array_equal(read_mesh_coordinates(obj.data), shape)
    for each in bpy.context.selected_objects:
        assert differences(each, carried(obj)) == set()
    fresh = add_carrier()
    fair_attribute(fresh, name, FairingSettings(radius=1.5, steps=3))
    assert differences(other, carried(fresh)) == set()


def test_settings_of_the_paper_count():
    obj, other = add_carrier(), add_carrier()
    other.select_set(False)
    options = {"scheme": "UNIFORM", "density": "AREA", "tau": 0.002, "steps": 1}
    bpy.ops.object.adaptive_fairing_attribute(**options)
    settings = FairingSettings(method="uniform", density="area", tau=0.002, steps=1)
    fair_attribute(other, "Front", settings)
    assert differences(obj, carried(other)) == set()


def test_without_colours_or_groups_or_a_name_that_is_said():
    add_object(*icosphere(1)).select_set(True)
    for source, message in (
        ("COLOR", "the mesh has no colors"),
        ("GROUP", "the object has no vertex group"),
        ("NAMED", "name an attribute or a vertex group"),
    ):
        with pytest.raises(RuntimeError, match=message):
            bpy.ops.object.adaptive_fairing_attribute(source=source)


def test_one_mesh_without_it_does_not_keep_the_others_from_it():
    obj = add_carrier()
    before = carried(obj)
    add_object(*icosphere(1)).select_set(True)
    assert bpy.ops.object.adaptive_fairing_attribute() == {"FINISHED"}
    assert differences(obj, before) == {"Front"}


def test_while_a_field_is_shown_the_meshs_own_colours_are_faired():
    obj = add_carrier()
    before = carried(obj)
    bpy.ops.object.adaptive_fairing_view(field="DENSITY")
    density = colors_by_vertex(obj.data, "fairing_density_color")
    bpy.ops.object.adaptive_fairing_attribute()
    assert np.array_equal(colors_by_vertex(obj.data, "fairing_density_color"), density)
    assert differences(obj, before) == {"Front"}
    assert obj.data.attributes.active_color_name == "fairing_density_color"


def test_colours_of_a_field_are_not_the_meshs_own():
    add_object(*icosphere(1)).select_set(True)
    bpy.ops.object.adaptive_fairing_view(field="DENSITY")
    with pytest.raises(RuntimeError, match="the mesh has no colors"):
        bpy.ops.object.adaptive_fairing_attribute()


class TestModes:
    @pytest.mark.parametrize("mode", ["EDIT", "SCULPT", "VERTEX_PAINT", "WEIGHT_PAINT"])
    def test_it_works_in_every_mode_and_comes_back_to_it(self, mode):
        obj = add_carrier()
        before = carried(obj)
        bpy.ops.object.mode_set(mode=mode)
        assert bpy.ops.object.adaptive_fairing_attribute() == {"FINISHED"}
        assert obj.mode == mode
        bpy.ops.object.mode_set(mode="OBJECT")
        assert differences(obj, before) == {"Front"}

    def test_the_selection_in_edit_mode_limits_it(self):
        obj = add_carrier()
        before = carried(obj)["heat"]
        chosen = np.arange(len(before)) < 30
        select(obj, chosen)
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.object.adaptive_fairing_attribute(source="NAMED", attribute="heat")
        bpy.ops.object.mode_set(mode="OBJECT")
        assert np.array_equal(carried(obj)["heat"] != before, chosen)


def test_painted_weights_of_a_result_are_shown_at_once():
    obj = add_object(*noisy_ball(2, 0.02))
    obj.select_set(True)
    bpy.ops.object.adaptive_fairing(clean="denoise")
    whole = read_mesh_coordinates(obj.data)
    bpy.ops.object.adaptive_fairing_paint()
    bpy.ops.object.mode_set(mode="OBJECT")
    group = obj.vertex_groups["Fairing"]
    lower = [vertex.index for vertex in obj.data.vertices if vertex.co.z < 0]
    group.add(lower, 0.0, "REPLACE")
    bpy.ops.object.adaptive_fairing_attribute(source="GROUP", radius=2.0)
    weights = group_weights(obj, group)[:, None]
    original = np.float32(noisy_ball(2, 0.02)[0])
    assert 20 < ((weights > 0.01) & (weights < 0.99)).sum()
    expected = original + weights * (whole - original)
    assert read_mesh_coordinates(obj.data) == pytest.approx(expected, abs=1e-6)


class TestButtons:
    def test_the_panel_offers_what_is_active_with_the_settings_of_the_scene(self):
        obj = add_carrier()
        obj.data.attributes.active = obj.data.attributes["heat"]
        settings = bpy.context.scene.adaptive_fairing
        settings.algorithm, settings.radius, settings.scheme = "FAIR", 3.0, "TENSOR"
        drawn = draw(attribute_panel.VIEW3D_PT_adaptive_fairing_attribute)
        assert [each["text"] for each in drawn.operators] == [
            "Active Color: Front",
            "Active Vertex Group: high",
            "Active Attribute: heat",
        ]
        assert [(each["source"], each["attribute"]) for each in drawn.operators] == [
            ("COLOR", "Front"),
            ("GROUP", "high"),
            ("NAMED", "heat"),
        ]
        for each in drawn.operators:
            assert (each["radius"], each["scheme"]) == (3.0, "TENSOR")

    def test_a_field_that_is_shown_is_not_offered(self):
        obj = add_carrier()
        bpy.context.scene.adaptive_fairing.algorithm = "FAIR"
        bpy.ops.object.adaptive_fairing_view(field="DENSITY")
        obj.data.attributes.active = obj.data.attributes["fairing_density"]
        drawn = draw(attribute_panel.VIEW3D_PT_adaptive_fairing_attribute)
        texts = [each["text"] for each in drawn.operators]
        assert texts == ["Active Color: Front", "Active Vertex Group: high", "Active Attribute"]

    def test_it_is_beside_the_settings_of_the_paper_only(self):
        settings = bpy.context.scene.adaptive_fairing
        assert draw(attribute_panel.VIEW3D_PT_adaptive_fairing_attribute) is None
        settings.algorithm = "FAIR"
        assert draw(attribute_panel.VIEW3D_PT_adaptive_fairing_attribute) is not None

    def test_blenders_menus_have_it(self):
        add_carrier()
        found = {}
        for menu, entry in attribute_panel._ENTRIES:
            assert entry in getattr(bpy.types, menu)._dyn_ui_initialize()
            stand = type("Stand", (), {"layout": FakeLayout()})
            entry(stand, FakeContext())
            (button,) = stand.layout.drawn.operators
            found[menu] = button["source"]
        assert found == {
            "MESH_MT_color_attribute_context_menu": "COLOR",
            "MESH_MT_vertex_group_context_menu": "GROUP",
            "MESH_MT_attribute_context_menu": "NAMED",
            "VIEW3D_MT_paint_vertex": "COLOR",
            "VIEW3D_MT_paint_weight": "GROUP",
        }
