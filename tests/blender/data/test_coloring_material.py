"""A material renders the colours of a field; the user's materials come back."""

import bpy
import numpy as np
import pytest
from support.fields import ENDS, add_denoised, show, state
from support.meshes import icosphere
from support.objects import add_object

pytestmark = pytest.mark.usefixtures("addon")


@pytest.fixture
def obj():
    return add_denoised()


each_end = pytest.mark.parametrize("end", ENDS.values(), ids=ENDS)


def test_the_objects_slots_have_it_and_the_meshs_materials_stay(obj):
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


def test_without_a_field_it_shows_the_density(obj):
    bpy.ops.object.adaptive_fairing_material()
    assert obj.adaptive_fairing.view == "DENSITY"
    assert obj.material_slots[0].material["fairing_field"] == "DENSITY"


def test_a_mesh_without_slots_has_none_afterwards():
    obj = add_object(*icosphere(1))
    obj.select_set(True)
    before = state(obj)
    bpy.ops.object.adaptive_fairing_material()
    assert [slot.material["fairing_field"] for slot in obj.material_slots] == ["DENSITY"]
    bpy.ops.object.adaptive_fairing_view_end()
    assert state(obj) == before


def test_it_follows_the_field_and_goes_with_materials_back(obj):
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
def test_its_end_gives_the_materials_back(obj, end):
    before = state(obj)
    bpy.ops.object.adaptive_fairing_material()
    end()
    after = state(obj)
    for name in ("slots", "of the mesh", "materials", "custom"):
        assert after[name] == before[name]
    assert not obj.adaptive_fairing.wants_material


def test_a_run_keeps_it(obj):
    bpy.ops.object.adaptive_fairing_material()
    bpy.ops.object.adaptive_fairing(clean="denoise")
    assert [slot.material["fairing_field"] for slot in obj.material_slots] == ["DENSITY"] * 2


def test_a_material_assigned_in_the_meantime_stays(obj):
    bpy.ops.object.adaptive_fairing_material()
    green = bpy.data.materials.new("Green")
    obj.material_slots[0].material = green
    bpy.ops.object.adaptive_fairing_view_end()
    assert [slot.material.name for slot in obj.material_slots] == ["Green", "Own"]


def test_a_render_has_the_colours():
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
