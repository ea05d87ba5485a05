"""The evolution on the timeline."""

import bpy
import pytest
from support.meshes import icosphere
from support.objects import add_object

pytestmark = pytest.mark.usefixtures("addon")


@pytest.fixture
def obj():
    obj = add_object(*icosphere(1))
    obj.select_set(True)
    bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=2)
    return obj


def evolution_at(obj, frame):
    bpy.context.scene.frame_set(frame)
    return obj.adaptive_fairing.evolution


def test_the_frames_run_through_the_evolution(obj):
    assert bpy.ops.object.adaptive_fairing_animate(frame_start=11, frame_end=31) == {"FINISHED"}
    shown = [evolution_at(obj, frame) for frame in (1, 11, 16, 21, 31, 40)]
    assert shown == pytest.approx([0.0, 0.0, 0.25, 0.5, 1.0, 1.0])


def test_the_scene_is_made_long_enough_but_never_shorter(obj):
    scene = bpy.context.scene
    scene.frame_end = 50
    bpy.ops.object.adaptive_fairing_animate(frame_start=1, frame_end=40)
    assert scene.frame_end == 50
    bpy.ops.object.adaptive_fairing_animate(frame_start=1, frame_end=400)
    assert scene.frame_end == 400


def test_a_second_time_replaces_the_first(obj):
    bpy.ops.object.adaptive_fairing_animate(frame_start=1, frame_end=101)
    bpy.ops.object.adaptive_fairing_animate(frame_start=1, frame_end=11)
    assert [evolution_at(obj, frame) for frame in (11, 51, 101)] == [1.0, 1.0, 1.0]
    assert len(bpy.data.actions) == 1


def test_it_can_be_cleared(obj):
    bpy.ops.object.adaptive_fairing_animate(frame_start=1, frame_end=11)
    bpy.ops.object.adaptive_fairing_animate_clear()
    assert len(bpy.data.actions) == 0
    obj.adaptive_fairing.evolution = 0.5
    assert evolution_at(obj, 11) == pytest.approx(0.5)


def test_frames_in_the_wrong_order_are_refused(obj):
    with pytest.raises(RuntimeError, match="The last frame must come after the first"):
        bpy.ops.object.adaptive_fairing_animate(frame_start=5, frame_end=5)


@pytest.mark.parametrize("output", ["RELATIVE_KEYS", "FINAL_SHAPE"])
def test_without_an_evolution_it_says_what_to_do(obj, output):
    bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=1, output=output)
    with pytest.raises(RuntimeError, match="Fair the active object first"):
        bpy.ops.object.adaptive_fairing_animate()


def test_absolute_keys_of_someone_else_are_left_alone():
    obj = add_object(*icosphere(1))
    obj.shape_key_add(name="Open")
    obj.data.shape_keys.use_relative = False
    with pytest.raises(RuntimeError, match="Fair the active object first"):
        bpy.ops.object.adaptive_fairing_animate()


class TestPlay:
    """Without a window nothing moves, but all is set for it."""

    def test_the_first_time_it_animates_and_shows_the_density(self, obj):
        scene = bpy.context.scene
        scene.frame_set(60)
        assert bpy.ops.object.adaptive_fairing_play(frame_start=11, frame_end=31) == {"FINISHED"}
        assert (scene.frame_current, obj.adaptive_fairing.evolution) == (11, 0.0)
        assert scene.use_preview_range
        assert (scene.frame_preview_start, scene.frame_preview_end) == (11, 31)
        assert evolution_at(obj, 31) == 1.0
        assert obj.adaptive_fairing.view == "DENSITY"

    def test_again_it_keeps_the_frames_and_the_colours(self, obj):
        bpy.ops.object.adaptive_fairing_animate(frame_start=5, frame_end=9)
        bpy.ops.object.adaptive_fairing_play()
        scene = bpy.context.scene
        assert (scene.frame_preview_start, scene.frame_preview_end) == (5, 9)
        assert evolution_at(obj, 9) == 1.0
        assert obj.adaptive_fairing.view == ""

    @pytest.mark.parametrize("before", [(300, 400), (1, 5)])
    def test_the_preview_range_may_have_been_anywhere(self, obj, before):
        scene = bpy.context.scene
        scene.frame_end, scene.use_preview_range = 500, True
        scene.frame_preview_end = before[1]
        scene.frame_preview_start = before[0]
        bpy.ops.object.adaptive_fairing_play(frame_start=11, frame_end=31)
        assert (scene.frame_preview_start, scene.frame_preview_end) == (11, 31)

    def test_another_field_stays(self, obj):
        bpy.ops.object.adaptive_fairing_view(field="DISPLACEMENT")
        bpy.ops.object.adaptive_fairing_play()
        assert obj.adaptive_fairing.view == "DISPLACEMENT"

    def test_the_end_plays_the_whole_scene_again(self, obj):
        bpy.ops.object.adaptive_fairing_play()
        assert bpy.ops.object.adaptive_fairing_play_end() == {"FINISHED"}
        assert not bpy.context.scene.use_preview_range

    def test_frames_in_the_wrong_order_are_refused(self, obj):
        with pytest.raises(RuntimeError, match="The last frame must come after the first"):
            bpy.ops.object.adaptive_fairing_play(frame_start=5, frame_end=5)
        assert obj.adaptive_fairing.view == ""

    def test_without_an_evolution_it_says_what_to_do(self):
        bpy.ops.mesh.primitive_cube_add()
        with pytest.raises(RuntimeError, match="Fair the active object first"):
            bpy.ops.object.adaptive_fairing_play()
