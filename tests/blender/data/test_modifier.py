"""The modifier adds the offset at its strength, whatever else the object has."""

import bpy
import numpy as np
import pytest
from support.meshes import icosphere
from support.objects import add_object, shown_positions

from adaptive_fairing.blender.data import modifier
from adaptive_fairing.blender.data.mesh_arrays import read_mesh_coordinates
from adaptive_fairing.blender.data.stored_path import offset_name, write_vectors
from adaptive_fairing.blender.data.vertex_groups import add_weights

KNOTS = (0.5, 1.0, 2.0)


def with_offsets():
    """Add a ball with an offset at every strength; give the object and (k, n, 3)."""
    obj = add_object(*icosphere(1))
    offsets = np.random.default_rng(1).normal(size=(len(KNOTS), len(obj.data.vertices), 3))
    for index, offset in enumerate(offsets, start=1):
        write_vectors(obj.data, offset_name(index), offset)
    return obj, offsets


def expected(obj, offsets, strength):
    flat = np.concatenate([np.zeros((1, offsets[0].size)), offsets.reshape(len(KNOTS), -1)])
    moves = [np.interp(strength, (0.0, *KNOTS), column) for column in flat.T]
    return read_mesh_coordinates(obj.data) + np.reshape(moves, (-1, 3))


@pytest.mark.parametrize("strength", [0.0, 0.2, 0.5, 0.8, 1.0, 1.7, 2.0])
def test_it_shows_the_strength_and_leaves_the_mesh(strength):
    obj, offsets = with_offsets()
    before = read_mesh_coordinates(obj.data)
    modifier.add(obj, KNOTS, strength)
    assert modifier.strength_of(obj) == np.float32(strength)
    np.testing.assert_allclose(shown_positions(obj), expected(obj, offsets, strength), atol=2e-6)
    np.testing.assert_array_equal(read_mesh_coordinates(obj.data), before)


def test_another_strength_shows_at_once():
    obj, offsets = with_offsets()
    modifier.add(obj, KNOTS, 1.0)
    modifier.set_strength(obj, 0.3)
    np.testing.assert_allclose(shown_positions(obj), expected(obj, offsets, 0.3), atol=2e-6)


def test_weights_of_a_group_scale_the_offset():
    obj, offsets = with_offsets()
    modifier.add(obj, KNOTS, 1.0)
    weights = np.linspace(0, 1, len(obj.data.vertices), dtype=np.float32)
    add_weights(obj.vertex_groups.new(name="paint"), range(len(weights)), weights)
    modifier.set_group(obj, "paint")
    before = read_mesh_coordinates(obj.data)
    scaled = before + weights[:, None] * (expected(obj, offsets, 1.0) - before)
    np.testing.assert_allclose(shown_positions(obj), scaled, atol=2e-6)


def test_a_new_name_does_not_hide_it_and_another_modifier_is_not_it():
    obj, _ = with_offsets()
    assert modifier.find(obj) is None
    assert modifier.strength_of(obj) == 0.0
    obj.modifiers.new("Adaptive Fairing", "NODES")
    assert modifier.find(obj) is None
    added = modifier.add(obj, KNOTS, 1.0)
    added.name = "Mine"
    assert modifier.find(obj) == added
    assert obj.modifiers[0] == added


def test_objects_with_the_same_strengths_share_the_nodes_and_the_last_takes_them_along():
    first, _ = with_offsets()
    second, _ = with_offsets()
    third, _ = with_offsets()
    for obj, knots in ((first, KNOTS), (second, KNOTS), (third, KNOTS[:2])):
        modifier.add(obj, knots, 1.0)
    nodes = [modifier.find(obj).node_group for obj in (first, second, third)]
    assert nodes[0] == nodes[1] != nodes[2]
    assert modifier.strength_of(second) == 1.0
    modifier.set_strength(first, 0.25)
    assert modifier.strength_of(second) == 1.0  # the nodes are shared, the input is not
    for obj, left in ((first, 2), (second, 1), (third, 0)):
        modifier.remove(obj)
        assert modifier.find(obj) is None
        assert len(bpy.data.node_groups) == left
    modifier.remove(third)  # nothing to do is no error
