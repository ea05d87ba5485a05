"""While a field is shown: active and rendered colours, shading, material; after it, nothing."""

import bpy
import numpy as np
import pytest
from support.meshes import icosphere, noisy_ball
from support.objects import add_object, add_rich_object, colors_by_vertex

from adaptive_fairing.blender.data.attributes import FIELD_ATTRIBUTES, color_name
from adaptive_fairing.blender.operators import viewport

pytestmark = pytest.mark.usefixtures("addon")

ENDS = {
    "hidden": lambda: bpy.ops.object.adaptive_fairing_view_end(),
    "applied": lambda: bpy.ops.object.adaptive_fairing_apply(),
    "discarded": lambda: bpy.ops.object.adaptive_fairing_discard(),
}
each_end = pytest.mark.parametrize("end", ENDS.values(), ids=ENDS)


@pytest.fixture
def obj():
    """A denoised object with materials, two colour layers of its own and an object's material."""
    vertices, faces = noisy_ball(2, 0.05)
    obj = add_object(vertices, faces)
    mesh = obj.data
    for name in ("Scan", "Paint"):
        mesh.color_attributes.new(name, "BYTE_COLOR", "CORNER")
    mesh.attributes.active_color_name, mesh.attributes.default_color_name = "Paint", "Scan"
    for name in ("Red", "Blue"):
        mesh.materials.append(bpy.data.materials.new(name))
    obj.material_slots[1].link = "OBJECT"
    obj.material_slots[1].material = bpy.data.materials.new("Own")
    mesh.polygons.foreach_set("material_index", np.arange(len(mesh.polygons)) % 2)
    obj.select_set(True)
    bpy.ops.object.adaptive_fairing(clean="denoise")
    return obj


def state(obj):
    """Everything that a view must leave as it was."""
    mesh = obj.data
    return {
        "active": mesh.attributes.active_color_name,
        "rendered": mesh.attributes.default_color_name,
        "attribute": mesh.attributes.active_index,
        "names": sorted(name for name in mesh.attributes.keys() if "offset" not in name),
        "custom": sorted(mesh.keys()),
        "slots": [(slot.link, slot.material) for slot in obj.material_slots],
        "of the mesh": list(mesh.materials),
        "materials": sorted(each.name for each in bpy.data.materials),
        "shading": shadings(),
    }


def shadings():
    return [
        (space.shading.type, space.shading.color_type, space.shading.light) for space in views()
    ]


def views():
    return [
        space
        for screen in bpy.data.screens
        for area in screen.areas
        for space in area.spaces
        if space.type == "VIEW_3D"
    ]


def show(field="DENSITY"):
    assert bpy.ops.object.adaptive_fairing_view(field=field) == {"FINISHED"}


class TestActiveColors:
    @pytest.mark.parametrize("field", FIELD_ATTRIBUTES)
    def test_a_field_is_the_active_and_the_rendered_colour_while_it_is_shown(self, obj, field):
        show("DISPLACEMENT")
        show(field)
        attributes, name = obj.data.attributes, color_name(FIELD_ATTRIBUTES[field])
        assert attributes.active_color_name == attributes.default_color_name == name
        assert obj.data.color_attributes.active_color.name == name

    @pytest.mark.parametrize("field", FIELD_ATTRIBUTES)
    def test_everything_is_as_before_when_it_is_hidden(self, obj, field):
        before = state(obj)
        show("CURVATURE")
        show(field)
        bpy.ops.object.adaptive_fairing_material()
        bpy.ops.object.adaptive_fairing_view_end()
        assert state(obj) == before

    def test_other_colours_chosen_in_the_meantime_stay(self, obj):
        show()
        obj.data.attributes.active_color_name = "Scan"
        bpy.ops.object.adaptive_fairing_view_end()
        attributes = obj.data.attributes
        assert (attributes.active_color_name, attributes.default_color_name) == ("Scan", "Scan")

    def test_a_mesh_of_two_objects_gets_its_own_colours_back(self, obj):
        other = bpy.data.objects.new("Other", obj.data)
        bpy.context.scene.collection.objects.link(other)
        other.select_set(True)
        show()
        bpy.ops.object.adaptive_fairing_view_end()
        attributes = obj.data.attributes
        assert (attributes.active_color_name, attributes.default_color_name) == ("Paint", "Scan")

    @pytest.mark.parametrize("surface", ["LIMIT", "REFINED_1"])
    def test_another_surface_shows_them_and_gives_them_back(self, obj, surface):
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

    def test_diffusion_leaves_its_density_active_on_a_mesh_without_colours(self):
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

    def test_diffusion_leaves_the_colours_of_a_mesh_active(self):
        obj = add_rich_object()
        obj.select_set(True)
        paint = colors_by_vertex(obj.data, "Paint")
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=1, tau=0.001)
        assert obj.data.attributes.active_color_name == "Paint"
        show()
        bpy.ops.object.adaptive_fairing_view_end()
        assert obj.data.attributes.active_color_name == "Paint"
        np.testing.assert_array_equal(colors_by_vertex(obj.data, "Paint"), paint)


class TestShading:
    def test_solid_views_show_the_lit_colours_and_others_stay(self, obj):
        before = shadings()
        show()
        for was, now in zip(before, shadings(), strict=True):
            assert now == (("SOLID", "VERTEX", "STUDIO") if was[0] == "SOLID" else was)

    @each_end
    def test_it_comes_back(self, obj, end):
        first, second = views()[:2]
        first.shading.light = "FLAT"
        before = shadings()
        assert first.shading.show_specular_highlight and second.shading.show_specular_highlight
        assert {"TEXTURE", "MATERIAL"} <= {color for _, color, _ in before}
        show("REMOVED")
        show("DENSITY")
        assert not first.shading.show_specular_highlight
        end()
        bpy.context.view_layer.update()
        assert shadings() == before
        assert first.shading.show_specular_highlight and second.shading.show_specular_highlight

    def test_it_comes_back_when_the_object_is_deleted(self, obj):
        before = shadings()
        show()
        bpy.data.objects.remove(obj)
        bpy.context.view_layer.update()
        assert shadings() == before

    def test_what_was_changed_in_the_meantime_stays(self, obj):
        show()
        shading = views()[0].shading
        shading.type, shading.light = "WIREFRAME", "FLAT"
        bpy.ops.object.adaptive_fairing_view_end()
        assert (shading.type, shading.color_type, shading.light) == (
            "WIREFRAME",
            "MATERIAL",
            "FLAT",
        )

    def test_it_stays_while_another_object_shows_a_field(self, obj):
        other = add_object(*icosphere(1))
        other.select_set(True)
        show()
        obj.select_set(False)
        bpy.data.objects.remove(other)
        bpy.context.view_layer.update()
        assert ("SOLID", "VERTEX", "STUDIO") in shadings()

    def test_a_file_saved_with_colours_shows_them_and_is_plain_after_them(self, obj, tmp_path):
        show()
        path = str(tmp_path / "shown.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path)
        bpy.ops.wm.read_homefile(use_factory_startup=True)
        assert "VERTEX" not in {color for _, color, _ in shadings()}
        bpy.ops.wm.open_mainfile(filepath=path)
        assert ("SOLID", "VERTEX", "STUDIO") in shadings()
        bpy.ops.object.adaptive_fairing_view_end()
        assert "VERTEX" not in {color for _, color, _ in shadings()}

    def test_a_file_loaded_into_the_same_windows_finds_them_as_they_were(self, obj, tmp_path):
        path = str(tmp_path / "plain.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path)
        before = shadings()
        show()
        bpy.ops.wm.open_mainfile(filepath=path, load_ui=False)
        assert shadings() == before

    def test_without_the_addon_it_is_as_before(self, obj, addon):
        before = shadings()
        show()
        viewport.unregister()
        assert shadings() == before


class TestMaterial:
    def test_the_objects_slots_have_it_and_the_meshs_materials_stay(self, obj):
        of_mesh = list(obj.data.materials)
        show("CURVATURE")
        assert bpy.ops.object.adaptive_fairing_material() == {"FINISHED"}
        first, second = (slot.material for slot in obj.material_slots)
        assert first == second
        assert list(obj.data.materials) == of_mesh
        links = [
            (link.from_node.attribute_name, link.to_node.type, link.to_socket.name)
            for link in first.node_tree.links
            if link.from_node.type == "ATTRIBUTE"
        ]
        assert links == [("fairing_mean_curvature_color", "BSDF_PRINCIPLED", "Base Color")]

    def test_without_a_field_it_shows_the_density(self, obj):
        bpy.ops.object.adaptive_fairing_material()
        assert obj.adaptive_fairing.view == "DENSITY"
        assert obj.material_slots[0].material["fairing_field"] == "DENSITY"

    def test_a_mesh_without_slots_has_none_afterwards(self):
        obj = add_object(*icosphere(1))
        obj.select_set(True)
        before = state(obj)
        bpy.ops.object.adaptive_fairing_material()
        assert [slot.material["fairing_field"] for slot in obj.material_slots] == ["DENSITY"]
        bpy.ops.object.adaptive_fairing_view_end()
        assert state(obj) == before

    def test_it_follows_the_field_and_goes_with_materials_back(self, obj):
        before = state(obj)
        bpy.ops.object.adaptive_fairing_material()
        show("REMOVED")
        assert [slot.material["fairing_field"] for slot in obj.material_slots] == ["REMOVED"] * 2
        bpy.ops.object.adaptive_fairing_material_end()
        assert obj.adaptive_fairing.view == "REMOVED"
        assert state(obj)["slots"] == before["slots"]
        show("DENSITY")
        assert state(obj)["slots"] == before["slots"]
        assert state(obj)["materials"] == before["materials"]

    @each_end
    def test_its_end_gives_the_materials_back(self, obj, end):
        before = state(obj)
        bpy.ops.object.adaptive_fairing_material()
        end()
        after = state(obj)
        for name in ("slots", "of the mesh", "materials", "custom"):
            assert after[name] == before[name]
        assert not obj.adaptive_fairing.wants_material

    def test_a_run_keeps_it(self, obj):
        bpy.ops.object.adaptive_fairing_material()
        bpy.ops.object.adaptive_fairing(clean="denoise")
        assert [slot.material["fairing_field"] for slot in obj.material_slots] == ["DENSITY"] * 2

    def test_a_material_assigned_in_the_meantime_stays(self, obj):
        bpy.ops.object.adaptive_fairing_material()
        green = bpy.data.materials.new("Green")
        obj.material_slots[0].material = green
        bpy.ops.object.adaptive_fairing_view_end()
        assert [slot.material.name for slot in obj.material_slots] == ["Green", "Own"]

    def test_a_render_has_the_colours(self):
        """Seen from above a disc of two halves: dense triangles left, coarse ones right."""
        left = np.linspace(-1, 0, 9)
        xs = np.concatenate([left, np.linspace(0, 1, 3)[1:]])
        ys = np.linspace(-1, 1, 9)
        vertices = [(x, y, 0.0) for x in xs for y in ys]
        faces = []
        for i in range(len(xs) - 1):
            for j in range(len(ys) - 1):
                a, b = 9 * i + j, 9 * (i + 1) + j
                faces += [(a, b, b + 1), (a, b + 1, a + 1)]
        obj = add_object(vertices, faces)
        obj.select_set(True)
        bpy.ops.object.adaptive_fairing_material()
        left_color, right_color = rendered_colors(at=[(-0.7, 0.0), (0.7, 0.0)])
        # Dense is dark violet, coarse is bright yellow: there green is far above blue.
        assert left_color[2] > left_color[1]
        assert right_color[1] > 2 * right_color[2]
        bpy.ops.object.adaptive_fairing_view_end()
        left_color, right_color = rendered_colors(at=[(-0.7, 0.0), (0.7, 0.0)])
        assert np.ptp(left_color) == pytest.approx(0.0, abs=0.02)


def rendered_colors(at, size=32):
    """Render the scene from above by Cycles, and give linear colours at points of [-1, 1]²."""
    scene = bpy.context.scene
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", 2.0
    camera.location.z = 5.0
    scene.collection.objects.link(camera)
    scene.camera = camera
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    scene.collection.objects.link(sun)
    scene.render.engine, scene.cycles.samples = "CYCLES", 4
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = f"{bpy.app.tempdir}picture.exr"
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    pixels = np.array(image.pixels).reshape(size, size, image.channels)
    bpy.data.images.remove(image)
    bpy.data.objects.remove(camera)
    bpy.data.objects.remove(sun)
    return [pixels[int((y + 1) / 2 * size), int((x + 1) / 2 * size), :3] for x, y in at]
