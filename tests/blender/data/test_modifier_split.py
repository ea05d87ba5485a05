"""The original on one side of a plane, by a modifier."""

import bpy
import numpy as np
import pytest
from support.objects import everything, shown_positions

from adaptive_fairing.blender.data import modifier
from adaptive_fairing.blender.data.stored_path import offset_name, write_vectors


@pytest.fixture
def original(obj):
    n = len(obj.data.vertices)
    return np.random.default_rng(4).normal(size=(n, 3)).astype(np.float32)


@pytest.mark.parametrize("has_result", [False, True])
def test_the_original_is_shown_behind_and_the_result_before_it(obj, original, has_result):
    if has_result:
        write_vectors(obj.data, offset_name(1), np.full_like(original, 0.5))
        modifier.add(obj, (1.0,), 1.0)
    result = shown_positions(obj)
    is_behind = result[:, 0] < 0.1
    obj.modifiers.new("Wireframe", "SUBSURF").levels = 0
    modifier.add_split(obj, original, is_behind)
    expected = np.where(is_behind[:, None], original, result)
    np.testing.assert_array_equal(shown_positions(obj), expected)
    names = [each.name for each in obj.modifiers]
    assert names == [
        *(["Adaptive Fairing"] if has_result else []),
        modifier.SPLIT_NAME,
        "Wireframe",
    ]


def test_a_second_plane_replaces_the_first_and_removed_nothing_is_left(obj, original):
    before = everything(obj)
    shown = shown_positions(obj)
    modifier.add_split(obj, original, np.ones(len(original), dtype=bool))
    modifier.add_split(obj, original, original[:, 1] < 0)
    assert len(obj.modifiers) == len(bpy.data.node_groups) == 1
    modifier.remove_split(obj)
    assert everything(obj) == before
    assert len(obj.modifiers) == len(bpy.data.node_groups) == 0
    np.testing.assert_array_equal(shown_positions(obj), shown)
