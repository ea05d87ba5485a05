"""The vertex group whose weights bring the original back."""

import numpy as np

from adaptive_fairing.blender.data.vertex_groups import (
    PAINT_GROUP,
    forget_weights,
    have_weights_changed,
    made_paint_group,
    paint_weights,
    remove_paint_group,
)


def test_a_new_one_shows_the_whole_result_and_is_active(obj):
    other = obj.vertex_groups.new(name="Other")
    assert paint_weights(obj) is None
    group = made_paint_group(obj)
    assert obj.vertex_groups.active == group
    assert np.array_equal(paint_weights(obj), np.ones(len(obj.data.vertices)))
    obj.vertex_groups.active = other
    assert made_paint_group(obj) == group
    assert obj.vertex_groups.active == group
    assert len(obj.vertex_groups) == 2


def test_painted_weights_count_once_the_old_ones_are_forgotten(obj):
    group = made_paint_group(obj)
    before = paint_weights(obj)
    group.add([3], 0.25, "REPLACE")
    group.remove([4])
    assert paint_weights(obj) is before
    forget_weights()
    expected = np.ones(len(before), dtype=np.float32)
    expected[3], expected[4] = 0.25, 0.0
    assert np.array_equal(paint_weights(obj), expected)


def test_weights_that_were_painted_since_they_were_read_have_changed(obj):
    assert not have_weights_changed(obj)  # there is no group
    group = made_paint_group(obj)
    assert have_weights_changed(obj)
    assert not have_weights_changed(obj)
    group.add([3], 0.25, "REPLACE")
    assert have_weights_changed(obj)
    assert paint_weights(obj)[3] == 0.25
    assert not have_weights_changed(obj)


def test_every_object_has_its_own(obj):
    twin = obj.copy()
    twin.data = obj.data.copy()
    made_paint_group(twin).add([0], 0.5, "REPLACE")
    made_paint_group(obj)
    forget_weights()
    assert (paint_weights(obj)[0], paint_weights(twin)[0], paint_weights(obj)[0]) == (1, 0.5, 1)


def test_it_is_removed_and_nothing_else(obj):
    obj.vertex_groups.new(name="Other")
    made_paint_group(obj)
    for _ in range(2):
        remove_paint_group(obj)
        assert obj.vertex_groups.keys() == ["Other"]
    assert paint_weights(obj) is None
    assert PAINT_GROUP not in obj.vertex_groups
