"""Everything that an object carries is still there after a run: one test for each thing.

Every feature is made on a box of quads and one hexagon, read, and read again after a run of the
operator with each kind of result, and of the job from .blend to .blend.
"""

import bpy
import numpy as np
import pytest
from support.features import FEATURES
from support.objects import add_object, bumpy_box, key_positions

from adaptive_fairing.blender.data.mesh_arrays import read_positions
from adaptive_fairing.blender.files.mesh_files import import_mesh, save_blend
from adaptive_fairing.blender.jobs.file_job import FairingJob, run_job
from adaptive_fairing.core import FairingSettings

pytestmark = pytest.mark.usefixtures("addon")

WAYS = ("ABSOLUTE_KEYS", "RELATIVE_KEYS", "FINAL_SHAPE", "job")


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", FEATURES)
def test_it_is_kept(name, way, tmp_path):
    obj = add_object(*bumpy_box())
    obj.select_set(True)
    read = FEATURES[name](obj)
    bpy.context.view_layer.update()
    start = read_positions(obj.data)
    before = read(obj)
    obj = fair(obj, way, tmp_path)
    assert obj.name == "Thing"
    assert read(obj) == before
    now = read_positions(obj.data)
    if way == "FINAL_SHAPE":
        assert (now != start).any()
    else:
        np.testing.assert_array_equal(now, start)
        assert (key_positions(obj, "Fairing 1") != start).any()


def fair(obj, way, tmp_path):
    """Fair an object; give what is then in its place."""
    name = obj.name
    if way == "job":
        save_blend(tmp_path / "in.blend")
        job = FairingJob(
            tmp_path / "in.blend", tmp_path / "out.blend", FairingSettings(steps=1), name
        )
        run_job(job)
        return import_mesh(tmp_path / "out.blend", name)
    assert bpy.ops.object.adaptive_fairing(algorithm="FAIR", output=way, steps=1) == {"FINISHED"}
    return bpy.data.objects[name]


# Data of others ----------------------------------------------------------------------------------


@pytest.mark.parametrize("way", WAYS)
def test_shape_keys_of_the_user_keep_values_animation_and_drivers(way, tmp_path):
    obj = add_object(*bumpy_box())
    obj.select_set(True)
    obj.shape_key_add(name="Basis")
    for name in ("Smile", "Frown"):
        obj.shape_key_add(name=name).points[3].co = (7, 7, 7)
    keys = obj.data.shape_keys
    keys.key_blocks["Smile"].value = 0.25
    keys.key_blocks["Smile"].slider_max = 2.0
    keys.key_blocks["Frown"].driver_add("value").driver.expression = "frame * 0.5"
    keys.key_blocks["Smile"].keyframe_insert("value", frame=3)

    def read(obj):
        keys = obj.data.shape_keys
        return (
            [(k.name, k.slider_max, key_positions(obj, k.name).tolist()) for k in keys.key_blocks],
            keys.use_relative,
            [(d.data_path, d.driver.expression) for d in keys.animation_data.drivers],
            keys.animation_data.action is not None,
        )

    before = read(obj)
    obj = fair(obj, way, tmp_path)
    assert read(obj) == before
    assert "Thing faired" in bpy.data.objects


@pytest.mark.parametrize("way", WAYS)
def test_other_users_of_the_mesh_keep_it(way, tmp_path):
    obj = add_object(*bumpy_box())
    other = bpy.data.objects.new("Other", obj.data)
    bpy.context.scene.collection.objects.link(other)
    obj.select_set(True)
    before = read_positions(obj.data)
    attributes = [a.name for a in obj.data.attributes]
    obj = fair(obj, way, tmp_path)
    mesh = bpy.data.objects["Other"].data
    assert mesh != obj.data
    assert mesh.shape_keys is None
    assert [a.name for a in mesh.attributes] == attributes
    np.testing.assert_array_equal(read_positions(mesh), before)


@pytest.mark.parametrize("way", WAYS)
def test_linked_data_stay_linked_and_their_file_is_untouched(way, tmp_path):
    obj = add_object(*bumpy_box(), name="Far")
    library = tmp_path / "library.blend"
    bpy.data.libraries.write(str(library), {obj})
    stored = library.read_bytes()
    bpy.data.objects.remove(obj)
    bpy.data.batch_remove(bpy.data.meshes)
    with bpy.data.libraries.load(str(library), link=True) as (_, wanted):
        wanted.objects = ["Far"]
    obj = wanted.objects[0]
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.update()
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj
    before = read_positions(obj.data)
    fair(obj, way, tmp_path)
    linked = next(o for o in bpy.data.objects if o.name == "Far" and o.library)
    assert linked.data.library is not None
    assert linked.data.shape_keys is None
    np.testing.assert_array_equal(read_positions(linked.data), before)
    copy = bpy.data.objects["Far faired"]
    assert copy.library is None and copy.data.library is None
    assert library.read_bytes() == stored


@pytest.mark.parametrize("way", WAYS)
def test_other_objects_are_as_they_were(way, tmp_path):
    other = add_object(*bumpy_box(), name="Bystander")
    other.modifiers.new("Round", "SUBSURF")
    other.shape_key_add(name="Basis")
    other.shape_key_add(name="Own").points[0].co = (9, 9, 9)
    obj = add_object(*bumpy_box())
    obj.select_set(True)
    fair(obj, way, tmp_path)
    other = bpy.data.objects["Bystander"]
    assert [key.name for key in other.data.shape_keys.key_blocks] == ["Basis", "Own"]
    assert tuple(key_positions(other, "Own")[0]) == (9, 9, 9)
    assert [modifier.type for modifier in other.modifiers] == ["SUBSURF"]
