"""The evolution as shape keys: what is stored, what is shown, what is left alone."""

import bpy
import numpy as np
import pytest
from support.meshes import icosphere
from support.objects import add_object, key_positions, shown_positions

from adaptive_fairing.blender import compatibility
from adaptive_fairing.blender.data.mesh_arrays import read_positions
from adaptive_fairing.blender.data.shape_keys import (
    animate_evolution,
    has_foreign_keys,
    remove_fairing_keys,
    write_absolute_keys,
    write_relative_keys,
)
from adaptive_fairing.core import FairingError

VERTICES, FACES = icosphere(1)
# Float32 exactly, so that what comes back can be compared bit by bit.
VERTICES = VERTICES.astype(np.float32)
STEPS = [VERTICES * np.float32(1 - step / 8) for step in (1, 2, 3)]


@pytest.fixture
def obj():
    return add_object(VERTICES, FACES)


def key_names(obj):
    return [block.name for block in obj.data.shape_keys.key_blocks]


def test_absolute_keys_hold_the_input_and_every_step(obj):
    write_absolute_keys(obj, STEPS)
    assert obj.data.shape_keys.use_relative is False
    assert key_names(obj) == ["Basis", "Fairing 1", "Fairing 2", "Fairing 3"]
    np.testing.assert_array_equal(key_positions(obj, "Basis"), VERTICES)
    for index, positions in enumerate(STEPS, start=1):
        np.testing.assert_array_equal(key_positions(obj, f"Fairing {index}"), positions)


def test_absolute_keys_show_the_last_step(obj):
    write_absolute_keys(obj, STEPS)
    np.testing.assert_array_equal(shown_positions(obj), STEPS[-1])


@pytest.mark.parametrize("index", range(4))
def test_evaluation_time_runs_through_the_steps(obj, index):
    write_absolute_keys(obj, STEPS)
    keys = obj.data.shape_keys
    keys.eval_time = keys.key_blocks[index].frame
    np.testing.assert_array_equal(shown_positions(obj), [VERTICES, *STEPS][index])


def test_between_two_keys_the_shape_is_halfway(obj):
    write_absolute_keys(obj, STEPS)
    keys = obj.data.shape_keys
    keys.eval_time = (keys.key_blocks[1].frame + keys.key_blocks[2].frame) / 2
    np.testing.assert_allclose(shown_positions(obj), (STEPS[0] + STEPS[1]) / 2, atol=1e-6)


def test_relative_keys_show_the_last_step(obj):
    write_relative_keys(obj, STEPS)
    keys = obj.data.shape_keys
    assert keys.use_relative is True
    assert [block.value for block in keys.key_blocks[1:]] == [0, 0, 1]
    np.testing.assert_allclose(shown_positions(obj), STEPS[-1], atol=1e-7)
    np.testing.assert_array_equal(key_positions(obj, "Fairing 1"), STEPS[0])


@pytest.mark.parametrize("write", [write_absolute_keys, write_relative_keys])
def test_a_second_run_replaces_the_keys_of_the_first(obj, write):
    write_absolute_keys(obj, STEPS)
    animate_evolution(obj, 1, 31)
    write(obj, STEPS[:2])
    assert key_names(obj) == ["Basis", "Fairing 1", "Fairing 2"]
    np.testing.assert_array_equal(read_positions(obj.data), VERTICES)
    assert not bpy.data.actions, "the animation of the old keys is gone with them"


def test_removing_keys_gives_the_input_back(obj):
    write_absolute_keys(obj, STEPS)
    remove_fairing_keys(obj)
    assert obj.data.shape_keys is None
    np.testing.assert_array_equal(read_positions(obj.data), VERTICES)
    np.testing.assert_array_equal(shown_positions(obj), VERTICES)


def test_removing_keys_gives_the_basis_back_even_if_the_mesh_differs(obj):
    write_absolute_keys(obj, STEPS)
    obj.data.shape_keys.reference_key.points[0].co = (1, 2, 3)
    remove_fairing_keys(obj)
    np.testing.assert_array_equal(read_positions(obj.data)[0], (1, 2, 3))


@pytest.mark.parametrize(
    "names", [["Basis", "Smile"], ["Base", "Fairing 1"], ["Basis", "Fairing 2"]]
)
@pytest.mark.parametrize(
    "write",
    [
        lambda obj: write_absolute_keys(obj, STEPS),
        lambda obj: write_relative_keys(obj, STEPS),
        remove_fairing_keys,
    ],
    ids=["absolute", "relative", "remove"],
)
def test_keys_of_the_user_are_never_touched(obj, names, write):
    for name in names:
        obj.shape_key_add(name=name).points[0].co = (7, 7, 7)
    before = {name: key_positions(obj, name) for name in names}
    assert has_foreign_keys(obj.data)
    with pytest.raises(FairingError, match="shape keys of its own"):
        write(obj)
    assert key_names(obj) == names
    for name in names:
        np.testing.assert_array_equal(key_positions(obj, name), before[name])


def test_a_basis_alone_is_nobody_s_work(obj):
    obj.shape_key_add(name="Basis")
    assert not has_foreign_keys(obj.data)
    write_absolute_keys(obj, STEPS)
    assert key_names(obj) == ["Basis", "Fairing 1", "Fairing 2", "Fairing 3"]


def test_a_wrong_shape_in_any_step_changes_nothing(obj):
    with pytest.raises(ValueError, match="positions of shape"):
        write_absolute_keys(obj, [STEPS[0], STEPS[1][:-1]])
    assert obj.data.shape_keys is None


def test_animation_has_one_linear_keyframe_per_step(obj):
    write_absolute_keys(obj, STEPS)
    animate_evolution(obj, 5, 35)
    keys = obj.data.shape_keys
    (curve,) = compatibility.fcurves(keys)
    points = [tuple(point.co) for point in curve.keyframe_points]
    frames = [block.frame for block in keys.key_blocks]
    assert points == list(zip([5, 15, 25, 35], frames, strict=True))
    assert {point.interpolation for point in curve.keyframe_points} == {"LINEAR"}


def test_playing_the_timeline_shows_the_steps(obj):
    write_absolute_keys(obj, STEPS)
    animate_evolution(obj, 1, 31)
    for frame, positions in zip((1, 11, 21, 31), [VERTICES, *STEPS], strict=True):
        bpy.context.scene.frame_set(frame)
        np.testing.assert_array_equal(shown_positions(obj), positions)
    bpy.context.scene.frame_set(6)
    np.testing.assert_allclose(shown_positions(obj), (VERTICES + STEPS[0]) / 2, atol=1e-6)
