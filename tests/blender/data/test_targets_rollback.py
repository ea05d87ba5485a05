"""An operator that fails midway leaves mode, selection and mesh as they were."""

import bpy
import pytest
from support.meshes import random_closed
from support.objects import add_object, key_positions

from adaptive_fairing.blender.data.mesh_arrays import read_positions
from adaptive_fairing.blender.jobs import write_back

pytestmark = pytest.mark.usefixtures("addon")


def run(**options):
    return bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=1, **options)


def state(obj):
    """Describe all that a failed run could have changed."""
    mesh = obj.data
    keys = mesh.shape_keys
    return {
        "objects": sorted(each.name for each in bpy.data.objects),
        "meshes": sorted((each.name, each.users) for each in bpy.data.meshes),
        "keys": len(bpy.data.shape_keys),
        "actions": sorted(each.name for each in bpy.data.actions),
        "mesh": (mesh.name, mesh.use_fake_user, mesh.users),
        "mode": obj.mode,
        "active": bpy.context.view_layer.objects.active.name,
        "selected": [each.name for each in bpy.context.selected_objects],
        "hidden": (obj.hide_get(), obj.hide_render),
        "vertices": [vertex.select for vertex in mesh.vertices],
        "positions": read_positions(mesh).tolist(),
        "attributes": sorted(attribute.name for attribute in mesh.attributes),
        "shapes": keys and {k.name: key_positions(obj, k.name).tolist() for k in keys.key_blocks},
        "time": keys and (keys.use_relative, keys.eval_time, obj.active_shape_key_index),
    }


@pytest.fixture
def obj():
    obj = add_object(*random_closed(seed=1))
    obj.select_set(True)
    for vertex in obj.data.vertices:
        vertex.select = vertex.index % 3 == 0
    # Edit Mode makes the selection of edges and faces agree with it.
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.object.mode_set(mode="OBJECT")
    return obj


@pytest.fixture(params=[MemoryError, RuntimeError, KeyboardInterrupt])
def fails(request, monkeypatch):
    """Let the run fail after the shapes are written, before the density is."""

    def broken(*arguments):
        raise request.param("no room for the density")

    monkeypatch.setattr(write_back, "write_field", broken)


def fail(**options):
    # Blender turns exceptions of operators into RuntimeError.
    with pytest.raises((RuntimeError, KeyboardInterrupt), match="no room for the density"):
        run(**options)


@pytest.mark.parametrize("output", ["ABSOLUTE_KEYS", "RELATIVE_KEYS", "FINAL_SHAPE"])
@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_a_fresh_mesh(obj, fails, mode, output):
    obj.data.use_fake_user = True
    before = state(obj)
    bpy.ops.object.mode_set(mode=mode)
    fail(output=output, use_region=False)
    assert obj.mode == mode
    bpy.ops.object.mode_set(mode="OBJECT")
    assert state(obj) == before


def test_an_earlier_evolution_with_its_animation(obj, monkeypatch):
    run()
    bpy.ops.object.adaptive_fairing_animate(frame_start=1, frame_end=20)
    before = state(obj)
    monkeypatch.setattr(write_back, "write_field", _broken)
    fail(tau=0.1)
    assert state(obj) == before
    assert obj.data.shape_keys.animation_data.action is not None


@pytest.mark.parametrize("place", ["_write_record", "write_field"])
def test_the_colours_of_a_field_and_their_material(obj, monkeypatch, place):
    obj.data.materials.append(bpy.data.materials.new("Mine"))
    plain = state(obj)
    bpy.ops.object.adaptive_fairing_view(field="CURVATURE")
    bpy.ops.object.adaptive_fairing_material()
    before = state(obj)
    monkeypatch.setattr(write_back, place, _broken)
    fail()
    assert state(obj) == before
    assert obj.adaptive_fairing.view == "CURVATURE"
    assert obj.data.attributes.active_color_name == "fairing_mean_curvature_color"
    assert obj.material_slots[0].material["fairing_field"] == "CURVATURE"
    bpy.ops.object.adaptive_fairing_view_end()
    assert state(obj) == plain
    assert obj.data.attributes.active_color_name == ""
    assert obj.material_slots[0].material.name == "Mine"


def test_an_object_whose_result_goes_to_a_copy(obj, fails):
    obj.shape_key_add(name="Basis")
    obj.shape_key_add(name="Smile").points[0].co = (7, 7, 7)
    before = state(obj)
    fail()
    assert state(obj) == before


def test_a_mesh_of_two_objects(obj, fails):
    other = bpy.data.objects.new("Other", obj.data)
    bpy.context.scene.collection.objects.link(other)
    before = state(obj)
    fail()
    assert state(obj) == before
    assert other.data == obj.data


def test_a_run_that_works_leaves_no_backup(obj):
    run()
    bpy.ops.object.adaptive_fairing_animate(frame_start=1, frame_end=20)
    run(tau=0.1)
    assert list(bpy.data.meshes) == [obj.data]
    assert list(bpy.data.shape_keys) == [obj.data.shape_keys]
    # The second run keeps the animation.
    assert list(bpy.data.actions) == [obj.data.shape_keys.animation_data.action]


def _broken(*arguments):
    raise MemoryError("no room for the density")
