"""Shape keys that are read, taken to another mesh, and cleared."""

import bpy
import numpy as np
import pytest
from support.meshes import icosphere
from support.objects import add_object, key_positions

from adaptive_fairing.blender.data.shape_keys import clear_keys, read_keys, write_keys


@pytest.fixture
def obj():
    """A ball with relative keys: one relative to another, one animated, one driven."""
    obj = add_object(*icosphere(1))
    for number, name in enumerate(("Basis", "Smile", "Frown")):
        block = obj.shape_key_add(name=name, from_mix=False)
        block.points[number].co.z += number
    blocks = obj.data.shape_keys.key_blocks
    blocks["Smile"].value, blocks["Smile"].slider_max = 0.25, 3.0
    blocks["Frown"].relative_key = blocks["Smile"]
    blocks["Frown"].mute = True
    blocks["Smile"].keyframe_insert("value", frame=1)
    blocks["Frown"].driver_add("value").driver.expression = "0.5"
    obj.active_shape_key_index, obj.show_only_shape_key = 2, True
    return obj


def test_all_positions_are_read_in_order(obj):
    keys = read_keys(obj.data)
    assert keys.source == obj.data.shape_keys
    for name, positions in zip(("Basis", "Smile", "Frown"), keys.positions, strict=True):
        np.testing.assert_array_equal(positions, key_positions(obj, name))
    assert read_keys(add_object(*icosphere(0)).data) is None


def test_another_object_gets_them_with_all_that_they_have(obj):
    keys = read_keys(obj.data)
    other = add_object(*icosphere(1))
    other.active_shape_key_index, other.show_only_shape_key = 0, False
    write_keys(other, keys, [2 * positions for positions in keys.positions])
    new = other.data.shape_keys
    assert new != obj.data.shape_keys
    for old, block in zip(obj.data.shape_keys.key_blocks, new.key_blocks, strict=True):
        assert block.name == old.name
        np.testing.assert_array_equal(
            key_positions(other, block.name), 2 * key_positions(obj, old.name)
        )
        assert block.relative_key.name == old.relative_key.name
        assert (block.value, block.mute, block.slider_max) == (old.value, old.mute, old.slider_max)
    assert new.animation_data.action == obj.data.shape_keys.animation_data.action
    (driver,) = new.animation_data.drivers
    assert driver.driver.expression == "0.5"


def test_absolute_keys_stand_at_the_same_times(obj):
    keys = obj.data.shape_keys
    keys.use_relative = False
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.shape_key_retime()
    keys.eval_time = 15.0
    other = add_object(*icosphere(1))
    write_keys(other, read_keys(obj.data), read_keys(obj.data).positions)
    new = other.data.shape_keys
    assert not new.use_relative
    assert [block.frame for block in new.key_blocks] == [block.frame for block in keys.key_blocks]
    assert new.eval_time == 15.0


@pytest.mark.parametrize("is_copy", [False, True])
def test_cleared_keys_leave_no_block_behind(obj, is_copy):
    """Blender leaves the block of a copied mesh in the file."""
    cleared = obj
    if is_copy:
        cleared = obj.copy()
        cleared.data = obj.data.copy()
        bpy.context.scene.collection.objects.link(cleared)
    clear_keys(cleared)
    assert cleared.data.shape_keys is None
    assert len(bpy.data.shape_keys) == (1 if is_copy else 0)
    clear_keys(cleared)  # nothing to do is no error
