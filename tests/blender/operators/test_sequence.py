"""The operator for frames: its result is that of the command line; what it refuses."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from support.batches import batch
from support.meshes import graded_sphere, random_closed
from support.objects import add_object, keyframe_motion, world_positions

from adaptive_fairing.blender.files.mesh_files import save_blend
from adaptive_fairing.blender.jobs.frames import read_frames
from adaptive_fairing.core import FairingSettings, InputError, fair

pytestmark = pytest.mark.usefixtures("addon")

FRAMES = (3, 4, 5)
FLOAT32 = 2.0**-21


def fair_frames(**options):
    settings = {"algorithm": "FAIR", "steps": 2, **options}
    frames = {"frame_start": FRAMES[0], "frame_end": FRAMES[-1]}
    return bpy.ops.object.adaptive_fairing_sequence(**{**frames, **settings})


@pytest.fixture
def bean():
    """A noisy ball under a modifier and a moving object, active and selected."""
    vertices, faces = graded_sphere(2)
    noise = np.random.default_rng(1).normal(scale=0.02, size=vertices.shape)
    obj = add_object(vertices + noise, faces, "Bean")
    modifier = obj.modifiers.new("Stretch", "SIMPLE_DEFORM")
    modifier.deform_method, modifier.deform_axis = "STRETCH", "X"
    for frame, amount in ((FRAMES[0], 0.0), (FRAMES[-1], 1.0)):
        modifier.factor = amount
        modifier.keyframe_insert("factor", frame=frame)
        keyframe_motion(obj, frame, amount)
    obj.select_set(True)
    bpy.context.scene.frame_set(1)
    return obj


def test_every_frame_is_that_of_the_command_line(bean, tmp_path):
    save_blend(tmp_path / "bean.blend")
    assert fair_frames() == {"FINISHED"}
    result = bpy.context.view_layer.objects.active
    by_operator = []
    for frame in FRAMES:
        bpy.context.scene.frame_set(frame)
        by_operator.append(world_positions(result))
    arguments = ["--frames", "3-5", "--steps", "2", "--same-strength", "--quiet"]
    out = tmp_path / "all.blend"
    assert batch(tmp_path / "bean.blend", *arguments, "-o", out, algorithm="fair") == 0
    bpy.ops.wm.open_mainfile(filepath=str(out))
    for frame, shape in zip(FRAMES, by_operator, strict=True):
        bpy.context.scene.frame_set(frame)
        found = world_positions(bpy.data.objects["Bean faired"])
        np.testing.assert_allclose(found, shape, rtol=0, atol=4 * FLOAT32)


def test_each_frame_may_have_its_own_strength(bean):
    frames = read_frames(bean, FRAMES)
    assert fair_frames(same_strength=False) == {"FINISHED"}
    result = bpy.context.view_layer.objects.active
    data, matrix = frames[-1].data, frames[-1].matrix
    expected = fair(data.vertices, data.triangles, FairingSettings(steps=2)).positions
    expected = expected @ matrix[:3, :3].T + matrix[:3, 3]
    bpy.context.scene.frame_set(FRAMES[-1])
    np.testing.assert_allclose(world_positions(result), expected, rtol=0, atol=20 * FLOAT32)


def test_the_result_takes_the_place_of_the_object(bean):
    before = [modifier.name for modifier in bean.modifiers]
    assert fair_frames() == {"FINISHED"}
    result = bpy.context.view_layer.objects.active
    assert result.name == "Bean faired"
    assert bpy.context.selected_objects == [result]
    assert not bean.visible_get()
    assert [modifier.name for modifier in bean.modifiers] == before
    assert bpy.context.scene.frame_current == 1
    assert len(bpy.data.meshes) == 2
    assert [key.name for key in result.data.shape_keys.key_blocks] == [
        f"Frame {frame}" for frame in FRAMES
    ]


def test_a_stopping_rule_of_the_first_frame_holds_for_all(bean):
    data = read_frames(bean, FRAMES)[0].data
    settings = FairingSettings(steps=9, tau=0.016, stop_curvature=0.8)
    n_steps = len(fair(data.vertices, data.triangles, settings).steps)
    assert 1 < n_steps < 9
    shapes = []
    for options in ({"steps": 9, "stop_curvature": 0.8}, {"steps": n_steps}):
        bpy.context.view_layer.objects.active = bean
        assert fair_frames(tau=0.016, **options) == {"FINISHED"}
        keys = bpy.context.view_layer.objects.active.data.shape_keys.key_blocks
        shapes.append([point.co[:] for key in keys for point in key.points])
    assert shapes[0] == shapes[1]


def test_faces_that_change_are_refused_and_nothing_is_left(bean):
    modifier = bean.modifiers.new("Subdivision", "SUBSURF")
    for frame, levels in ((FRAMES[0], 0), (FRAMES[-1], 1)):
        modifier.levels = levels
        modifier.keyframe_insert("levels", frame=frame)
    with pytest.raises(RuntimeError, match="the faces at frame 4 are not those of frame 3"):
        fair_frames()
    assert bpy.context.scene.frame_current == 1
    assert [obj.name for obj in bpy.data.objects] == ["Bean"]
    assert bean.visible_get()


def test_an_empty_range_is_refused(bean):
    with pytest.raises(RuntimeError, match="The last frame must come after the first"):
        fair_frames(frame_end=FRAMES[0])


def test_an_object_without_faces_is_refused():
    obj = add_object(random_closed(1)[0], [], "Points")
    with pytest.raises(InputError, match="there are no faces at frame 3"):
        read_frames(obj, FRAMES)


def test_a_frame_that_fails_is_told_and_the_others_are_kept(bean, monkeypatch):
    from adaptive_fairing.blender.jobs import solve

    real, calls = solve.fair_steps, []

    def sometimes(*given, **options):
        calls.append(1)
        if len(calls) == 2:
            raise InputError("no good")
        return real(*given, **options)

    monkeypatch.setattr(solve, "fair_steps", sometimes)
    assert fair_frames() == {"FINISHED"}
    keys = bpy.context.view_layer.objects.active.data.shape_keys.key_blocks
    assert [key.name for key in keys] == ["Frame 3", "Frame 5"]


def test_poll_says_what_is_missing(bean):
    bpy.ops.object.mode_set(mode="EDIT")
    with pytest.raises(RuntimeError, match="Change to Object Mode"):
        fair_frames()
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.objects.active = None
    with pytest.raises(RuntimeError, match="Make a mesh object active"):
        fair_frames()
