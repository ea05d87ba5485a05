"""A visit to Object Mode: back in the mode before, whatever happens, if there is a way back."""

import bpy
import numpy as np
import pytest
from support.meshes import icosphere
from support.objects import add_object

from adaptive_fairing.blender.data.mesh_arrays import read_mesh_coordinates
from adaptive_fairing.blender.data.object_mode import object_mode

MODES = ["OBJECT", "EDIT", "SCULPT", "WEIGHT_PAINT"]


@pytest.mark.parametrize("mode", MODES)
def test_the_mode_is_the_same_before_and_after(obj, mode):
    bpy.ops.object.mode_set(mode=mode)
    with object_mode(bpy.context):
        assert obj.mode == "OBJECT"
        moved = 2 * read_mesh_coordinates(obj.data)
        obj.data.vertices.foreach_set("co", moved.ravel())
    assert obj.mode == mode
    bpy.ops.object.mode_set(mode="OBJECT")
    assert np.array_equal(read_mesh_coordinates(obj.data), moved)
    assert list(bpy.data.meshes) == [obj.data]


@pytest.mark.parametrize("mode", MODES)
def test_after_an_error_too(obj, mode):
    bpy.ops.object.mode_set(mode=mode)
    with pytest.raises(ValueError, match="bad"), object_mode(bpy.context):
        raise ValueError("bad")
    assert obj.mode == mode


@pytest.mark.parametrize("change", ["hidden", "removed", "another active"])
def test_without_a_way_back_it_stays_in_object_mode(obj, change):
    other = add_object(*icosphere(1), name="Other")
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.mode_set(mode="EDIT")
    with object_mode(bpy.context):
        if change == "hidden":
            obj.hide_set(True)
        elif change == "removed":
            bpy.data.objects.remove(obj)
        else:
            bpy.context.view_layer.objects.active = other
    assert {each.mode for each in bpy.data.objects} == {"OBJECT"}


def test_without_an_active_object_there_is_nothing_to_leave(obj):
    bpy.context.view_layer.objects.active = None
    with object_mode(bpy.context):
        pass
    assert obj.mode == "OBJECT"
