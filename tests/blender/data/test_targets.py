"""Target of a run, and all that stays as it is."""

import bpy
import numpy as np
import pytest
from support.meshes import icosphere
from support.objects import add_object, key_positions

from adaptive_fairing.blender.data.mesh_arrays import read_positions
from adaptive_fairing.blender.data.shape_keys import write_absolute_keys
from adaptive_fairing.blender.data.targets import find_mesh_object, needs_copy, writable_object
from adaptive_fairing.core import FairingError

VERTICES, FACES = icosphere(1)


def test_the_only_mesh_is_found_among_other_things():
    obj = add_object(VERTICES, FACES)
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Null", None))
    assert find_mesh_object("x.blend") == obj


def test_a_mesh_is_found_by_name():
    add_object(VERTICES, FACES, "One")
    two = add_object(VERTICES, FACES, "Two")
    assert find_mesh_object("x.blend", "Two") == two


def test_several_meshes_are_named():
    for name in ("One", "Two"):
        add_object(VERTICES, FACES, name)
    with pytest.raises(FairingError, match=r"2 meshes: choose one with --object: 'One', 'Two'$"):
        find_mesh_object("x.blend")


def test_no_mesh_is_said_so():
    with pytest.raises(FairingError, match=r"^x.blend holds no mesh"):
        find_mesh_object("x.blend")


def test_an_unknown_name_lists_the_known_ones():
    add_object(VERTICES, FACES, "One")
    with pytest.raises(FairingError, match=r"no object 'Zwei'; its meshes are: 'One'$"):
        find_mesh_object("x.blend", "Zwei")


def test_a_camera_is_not_a_mesh():
    camera = bpy.data.objects.new("Eye", bpy.data.cameras.new("Eye"))
    bpy.context.scene.collection.objects.link(camera)
    with pytest.raises(FairingError, match=r"'Eye' in x\.blend is a camera, not a mesh"):
        find_mesh_object("x.blend", "Eye")


def test_an_object_outside_every_scene_is_not_faired():
    bpy.data.objects.new("Lost", bpy.data.meshes.new("Lost"))
    with pytest.raises(FairingError, match="not in any scene"):
        find_mesh_object("x.blend", "Lost")


def test_an_ordinary_object_is_written_itself():
    obj = add_object(VERTICES, FACES)
    mesh = obj.data
    mesh.use_fake_user = True
    assert writable_object(obj) == obj
    assert obj.data == mesh


def test_an_object_with_fairing_keys_is_written_itself():
    obj = add_object(VERTICES, FACES)
    write_absolute_keys(obj, [VERTICES])
    assert writable_object(obj) == obj


def test_others_that_share_the_mesh_keep_theirs():
    obj = add_object(VERTICES, FACES, "One")
    shared = obj.data
    other = bpy.data.objects.new("Two", shared)
    assert writable_object(obj) == obj
    assert other.data == shared
    assert obj.data != shared


def test_an_object_with_its_own_keys_is_copied_and_hidden():
    obj = add_object(VERTICES, FACES, "Face")
    obj.shape_key_add(name="Basis")
    smile = obj.shape_key_add(name="Smile")
    smile.points[0].co = (7, 7, 7)
    smile.value = 0.5
    obj.location = (1, 2, 3)

    copy = writable_object(obj)

    assert copy.name == "Face faired"
    assert copy.data.shape_keys is None
    assert len(bpy.data.shape_keys) == 1
    assert tuple(copy.location) == (1, 2, 3)
    assert copy.users_collection == obj.users_collection
    shown = VERTICES.astype(np.float32)
    shown[0] += np.float32(0.5) * (7 - shown[0])
    np.testing.assert_array_equal(read_positions(copy.data), shown)
    assert not copy.hide_render
    assert obj.hide_get()
    assert obj.hide_render
    assert [block.name for block in obj.data.shape_keys.key_blocks] == ["Basis", "Smile"]
    assert tuple(key_positions(obj, "Smile")[0]) == (7, 7, 7)
    assert smile.value == 0.5


@pytest.fixture
def library(tmp_path):
    """A .blend file with the object "Far" in it."""
    obj = add_object(VERTICES, FACES, "Far")
    path = tmp_path / "library.blend"
    bpy.data.libraries.write(str(path), {obj})
    bpy.data.objects.remove(obj)
    bpy.data.batch_remove(bpy.data.meshes)
    return path


def link(library, kind, name):
    with bpy.data.libraries.load(str(library), link=True) as (_, wanted):
        setattr(wanted, kind, [name])
    return getattr(wanted, kind)[0]


def test_a_linked_object_is_copied(library):
    obj = link(library, "objects", "Far")
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.update()
    assert needs_copy(obj)
    copy = writable_object(obj)
    assert copy.library is None
    assert copy.data.library is None
    assert obj.data.library is not None
    assert obj.hide_get()
    write_absolute_keys(copy, [2 * VERTICES])


def test_a_linked_mesh_of_a_local_object_becomes_local(library):
    obj = bpy.data.objects.new("Near", link(library, "meshes", "Far"))
    bpy.context.scene.collection.objects.link(obj)
    assert writable_object(obj) == obj
    assert obj.data.library is None
    write_absolute_keys(obj, [2 * VERTICES])


def test_an_override_is_copied(library):
    linked = link(library, "objects", "Far")
    bpy.context.scene.collection.objects.link(linked)
    obj = linked.override_create(remap_local_usages=True)
    copy = writable_object(obj)
    assert copy != obj
    assert copy.override_library is None
    assert copy.data.library is None
    write_absolute_keys(copy, [2 * VERTICES])
