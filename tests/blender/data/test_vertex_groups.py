"""Vertex groups as arrays, and back."""

import numpy as np
import pytest
from support.meshes import icosphere
from support.objects import add_object

from adaptive_fairing.blender.data.vertex_groups import (
    add_weights,
    group_weights,
    read_groups,
    same_groups,
    write_groups,
)


@pytest.fixture
def obj():
    """A ball with a group of all weights, one with a few vertices, and an empty one."""
    obj = add_object(*icosphere(1))
    n = len(obj.data.vertices)
    everywhere = obj.vertex_groups.new(name="everywhere")
    add_weights(everywhere, range(n), np.linspace(0, 1, n, dtype=np.float32))
    few = obj.vertex_groups.new(name="few")
    add_weights(few, [2, 7, 11], np.float32([0.5, 0.0, 0.5]))
    few.lock_weight = True
    obj.vertex_groups.new(name="empty")
    return obj


def test_weights_locks_and_members_are_read(obj):
    everywhere, few, empty = read_groups(obj)
    n = len(obj.data.vertices)
    np.testing.assert_array_equal(everywhere.weights, np.linspace(0, 1, n, dtype=np.float32))
    assert everywhere.is_member.all()
    assert (few.name, few.is_locked) == ("few", True)
    # Vertex 7 has weight 0 and is a member all the same.
    assert np.flatnonzero(few.is_member).tolist() == [2, 7, 11]
    assert few.weights[[2, 7, 11]].tolist() == [0.5, 0.0, 0.5]
    assert not empty.is_member.any()


def test_one_group_alone_has_the_same_weights(obj):
    for group, expected in zip(obj.vertex_groups, read_groups(obj), strict=True):
        np.testing.assert_array_equal(group_weights(obj, group), expected.weights)


def test_written_to_another_object_they_are_the_same_and_the_same_one_is_active(obj):
    groups = read_groups(obj)
    other = add_object(*icosphere(1))
    other.vertex_groups.new(name="old")
    other.vertex_groups.new(name="second")
    other.vertex_groups.active_index = 1
    write_groups(other, groups)
    assert same_groups(read_groups(other), groups)
    assert other.vertex_groups.active_index == 1


def test_a_difference_is_seen(obj):
    groups = read_groups(obj)
    assert same_groups(groups, read_groups(obj))
    obj.vertex_groups["few"].lock_weight = False
    assert not same_groups(groups, read_groups(obj))
    obj.vertex_groups["few"].lock_weight = True
    obj.vertex_groups["few"].remove([7])  # had weight 0: only its membership changes
    assert not same_groups(groups, read_groups(obj))
    assert not same_groups(groups[:2], groups)


def test_taken_to_another_mesh_weights_and_members_go_alike(obj):
    groups = [group.with_weights(lambda values: values[::2]) for group in read_groups(obj)]
    assert np.flatnonzero(groups[1].is_member).tolist() == [1]
    assert groups[1].weights[1] == 0.5


def test_without_groups_there_is_nothing():
    assert read_groups(add_object(*icosphere(0))) == []
