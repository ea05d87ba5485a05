"""Display of a result: by a modifier, beside the original, painted back in parts."""

import bpy
import numpy as np
import pytest
from support.objects import edited_vertices, key_positions, select, shown_positions
from support.results import coordinates, core_result, fairing_attributes, near, paper, run

from adaptive_fairing.blender.compatibility import set_modifier_input, weight_paint_settings
from adaptive_fairing.blender.data import results
from adaptive_fairing.blender.data.display import display_of
from adaptive_fairing.blender.data.results import end_comparison
from adaptive_fairing.blender.data.vertex_groups import PAINT_GROUP

pytestmark = pytest.mark.usefixtures("addon")


class TestModifier:
    def run(self, obj, **options):
        expected = core_result(obj)
        before = coordinates(obj)
        assert run(result="MODIFIER", **options) == {"FINISHED"}
        assert np.array_equal(coordinates(obj), before)
        return expected

    @pytest.mark.parametrize("strength", [0.0, 0.3, 0.75, 1.0, 1.2, 2.0])
    def test_it_shows_every_strength_and_the_mesh_stays(self, noisy, strength):
        expected = self.run(noisy)
        noisy.adaptive_fairing.strength = strength
        assert noisy.adaptive_fairing.strength == np.float32(strength)
        assert near(shown_positions(noisy), expected.at(strength))

    def test_its_input_is_the_slider(self, noisy):
        expected = self.run(noisy)
        (modifier,) = noisy.modifiers
        assert modifier.name == "Adaptive Fairing"
        sockets = modifier.node_group.interface.items_tree
        inputs = [each.name for each in sockets if each.in_out == "INPUT"]
        assert inputs == ["Geometry", "Strength", "Vertex Group"]
        set_modifier_input(modifier, sockets["Strength"].identifier, 0.5)
        noisy.update_tag()
        assert noisy.adaptive_fairing.strength == 0.5
        assert near(shown_positions(noisy), expected.at(0.5))

    def test_it_is_below_other_modifiers(self, noisy):
        noisy.modifiers.new("Subdivision", "SUBSURF")
        self.run(noisy)
        assert [each.name for each in noisy.modifiers] == ["Adaptive Fairing", "Subdivision"]

    def test_it_works_on_a_mesh_with_shape_keys(self, noisy):
        noisy.shape_key_add(name="Basis", from_mix=False)
        smile = noisy.shape_key_add(name="Smile", from_mix=False)
        smile.data[3].co.x += 1.0
        smile.value = 0.0
        before = key_positions(noisy, "Smile")
        expected = self.run(noisy)
        assert near(shown_positions(noisy), expected.positions)
        assert bpy.context.object == noisy
        bpy.ops.object.adaptive_fairing_apply()
        assert list(noisy.modifiers) == []
        assert near(shown_positions(noisy), expected.positions)
        smile.value = 1.0
        assert shown_positions(noisy)[3, 0] == pytest.approx(expected.positions[3, 0] + 1, abs=1e-6)
        assert not np.array_equal(key_positions(noisy, "Smile"), before)

    def test_apply_and_discard(self, noisy):
        before = coordinates(noisy)
        expected = self.run(noisy)
        bpy.ops.object.adaptive_fairing_discard()
        assert list(noisy.modifiers) == []
        assert (np.array_equal(coordinates(noisy), before), fairing_attributes(noisy)) == (True, [])
        assert len(bpy.data.node_groups) == 0
        self.run(noisy)
        bpy.ops.object.adaptive_fairing_apply()
        assert list(noisy.modifiers) == []
        assert near(coordinates(noisy), expected.positions)


class TestComparing:
    @pytest.mark.parametrize("way", ["LIVE", "MODIFIER", "KEYS"])
    def test_before_shows_the_original_and_the_result_again(self, noisy, way):
        before = coordinates(noisy)
        paper() if way == "KEYS" else run(result=way)
        shown = shown_positions(noisy)
        bpy.ops.object.adaptive_fairing_before()
        assert np.array_equal(shown_positions(noisy), before)
        bpy.ops.object.adaptive_fairing_before()
        assert np.array_equal(shown_positions(noisy), shown)

    @pytest.mark.parametrize("way", ["LIVE", "MODIFIER", "KEYS"])
    def test_after_a_second_run_it_shows_the_original_of_the_first(self, noisy, way):
        before = coordinates(noisy)
        for wanted in (before[:, 2] > 0, before[:, 2] < 0):
            select(noisy, wanted)
            bpy.ops.object.mode_set(mode="EDIT")
            paper() if way == "KEYS" else run(result=way)
            bpy.ops.object.mode_set(mode="OBJECT")
        shown = shown_positions(noisy)
        for expected in (before, shown):
            bpy.ops.object.adaptive_fairing_before()
            assert np.array_equal(shown_positions(noisy), expected)
        name = "evolution" if way == "KEYS" else "strength"
        setattr(noisy.adaptive_fairing, name, 0.0)  # takes back the second run alone
        assert not np.array_equal(shown_positions(noisy), before)

    @pytest.mark.parametrize("name", ["before", "split"])
    @pytest.mark.parametrize("way", ["LIVE", "MODIFIER", "KEYS"])
    def test_it_is_a_step_of_the_history(self, noisy, way, name):
        paper() if way == "KEYS" else run(result=way)
        bpy.ops.ed.undo_push(message="run")
        called, shown = noisy.name, shown_positions(noisy)
        getattr(bpy.ops.object, f"adaptive_fairing_{name}")("EXEC_DEFAULT", True)
        assert not np.array_equal(shown_positions(noisy), shown)
        bpy.ops.ed.undo()
        obj = bpy.data.objects[called]
        assert np.array_equal(shown_positions(obj), shown)
        assert not (obj.adaptive_fairing.is_before or obj.adaptive_fairing.is_split)
        assert display_of(obj).goes_on

    def test_the_slider_ends_it(self, noisy):
        run()
        bpy.ops.object.adaptive_fairing_before()
        noisy.adaptive_fairing.strength = 0.5
        shown = coordinates(noisy)
        end_comparison(noisy)
        assert np.array_equal(coordinates(noisy), shown)

    @pytest.mark.parametrize("way", ["LIVE", "MODIFIER", "KEYS", "RELATIVE_KEYS"])
    @pytest.mark.parametrize("mode", ["OBJECT", "SCULPT"])
    def test_a_split_shows_both_and_ends_without_a_trace(self, noisy, way, mode):
        before = coordinates(noisy)
        if way == "KEYS":
            paper()
        elif way == "RELATIVE_KEYS":
            paper(output=way)
        else:
            run(result=way)
        after = shown_positions(noisy)
        names, modifiers = noisy.data.attributes.keys(), noisy.modifiers.keys()
        bpy.ops.object.mode_set(mode=mode)
        bpy.ops.object.adaptive_fairing_split()
        left = before[:, 0] < np.float32(noisy.adaptive_fairing.split_point[0])
        assert 0.3 < left.mean() < 0.7
        assert np.array_equal(shown_positions(noisy)[left], before[left])
        assert near(shown_positions(noisy)[~left], after[~left])
        bpy.ops.object.adaptive_fairing_split()
        assert noisy.mode == mode
        assert np.array_equal(shown_positions(noisy), after)
        bpy.ops.object.adaptive_fairing_split()
        bpy.ops.object.mode_set(mode="OBJECT")
        end_comparison(noisy)
        assert (noisy.data.attributes.keys(), noisy.modifiers.keys()) == (names, modifiers)
        bpy.ops.object.adaptive_fairing_split()
        bpy.ops.object.adaptive_fairing_apply()
        assert near(coordinates(noisy), after)
        assert (list(noisy.modifiers), list(bpy.data.node_groups)) == ([], [])

    @pytest.mark.parametrize("way", ["LIVE", "MODIFIER", "KEYS"])
    def test_the_slider_moves_the_right_half_only(self, noisy, way):
        before = coordinates(noisy)
        paper() if way == "KEYS" else run(result=way)
        record, name = noisy.adaptive_fairing, "evolution" if way == "KEYS" else "strength"
        setattr(record, name, 0.4)
        expected = shown_positions(noisy)
        setattr(record, name, 1.0)
        bpy.ops.object.adaptive_fairing_split()
        setattr(record, name, 0.4)
        left = before[:, 0] < np.float32(record.split_point[0])
        assert np.array_equal(shown_positions(noisy)[left], before[left])
        assert near(shown_positions(noisy)[~left], expected[~left])

    def test_a_split_below_a_modifier_has_the_keys_of_the_user(self, noisy):
        noisy.shape_key_add(name="Basis", from_mix=False)
        smile = noisy.shape_key_add(name="Smile", from_mix=False)
        smile.data[3].co.x -= 1.0
        smile.value = 1.0
        shown = shown_positions(noisy)
        run(result="MODIFIER")
        bpy.ops.object.adaptive_fairing_split()
        left = shown[:, 0] < np.float32(noisy.adaptive_fairing.split_point[0])
        assert np.array_equal(shown_positions(noisy)[left], shown[left])


def edited_positions(obj):
    """Coordinates that Edit Mode shows."""
    return np.float32([vertex.co for vertex in edited_vertices(obj)])


class TestEditMode:
    """A run on selected vertices is judged where it was called."""

    @pytest.fixture
    def upper(self, noisy):
        is_upper = coordinates(noisy)[:, 2] > 0
        select(noisy, is_upper)
        bpy.ops.object.mode_set(mode="EDIT")
        return is_upper

    def test_the_slider_moves_the_region_and_the_selection_stays(self, noisy, upper):
        before = edited_positions(noisy)
        run()
        denoised = edited_positions(noisy)
        noisy.adaptive_fairing.strength = 0.0
        assert np.array_equal(edited_positions(noisy), before)
        noisy.adaptive_fairing.strength = 1.0
        assert near(edited_positions(noisy), denoised)
        assert np.array_equal([each.select for each in edited_vertices(noisy)], upper)
        assert noisy.mode == "EDIT"

    @pytest.mark.usefixtures("upper")
    def test_moved_vertices_stay_and_another_net_ends_the_slider(self, noisy):
        run()
        edited_vertices(noisy)[7].co.x += 1.0
        moved = edited_positions(noisy)[7]
        noisy.adaptive_fairing.strength = 0.4
        assert np.array_equal(edited_positions(noisy)[7], moved)
        bpy.ops.mesh.subdivide()
        assert not display_of(noisy).is_whole

    @pytest.mark.parametrize("step", ["slider", "before", "split", "apply", "discard"])
    @pytest.mark.usefixtures("upper")
    def test_undo_brings_back_mesh_and_result_together(self, noisy, step):
        bpy.ops.ed.undo_push(message="before the run")
        run()
        bpy.ops.ed.undo_push(message="run")
        shown, name = edited_positions(noisy), noisy.name
        if step == "slider":
            noisy.adaptive_fairing.strength = 0.5
        else:
            getattr(bpy.ops.object, f"adaptive_fairing_{step}")()
        bpy.ops.ed.undo_push(message=step)
        bpy.ops.ed.undo()
        obj = bpy.data.objects[name]
        assert np.array_equal(edited_positions(obj), shown)
        bpy.ops.object.mode_set(mode="OBJECT")
        assert display_of(obj).goes_on
        assert obj.adaptive_fairing.strength == 1.0

    @pytest.mark.parametrize("way", ["LIVE", "MODIFIER"])
    def test_before_shows_the_original_and_the_result_again(self, noisy, way):
        before = coordinates(noisy)
        run(result=way)
        shown = shown_positions(noisy)
        bpy.ops.object.mode_set(mode="EDIT")
        for expected in (before, shown):
            bpy.ops.object.adaptive_fairing_before()
            bpy.ops.object.mode_set(mode="OBJECT")
            assert np.array_equal(shown_positions(noisy), expected)
            bpy.ops.object.mode_set(mode="EDIT")

    def test_an_evolution_is_at_its_nearest_step(self, noisy):
        paper()
        bpy.ops.object.mode_set(mode="EDIT")
        for evolution, name in ((0.0, "Basis"), (0.3, "Fairing 1"), (0.7, "Fairing 2")):
            noisy.adaptive_fairing.evolution = evolution
            assert noisy.adaptive_fairing.evolution == pytest.approx(evolution)
            assert np.array_equal(edited_positions(noisy), key_positions(noisy, name))


class TestPaintBack:
    @pytest.mark.parametrize("way", ["LIVE", "MODIFIER"])
    def test_weights_go_from_the_original_to_the_result(self, noisy, way):
        before = coordinates(noisy)
        run(result=way)
        after = shown_positions(noisy)
        assert bpy.ops.object.adaptive_fairing_paint() == {"FINISHED"}
        assert noisy.mode == "WEIGHT_PAINT"
        settings = weight_paint_settings(bpy.context)
        assert (settings.use_unified_weight, settings.weight) == (True, 0.0), "of every brush"
        assert np.array_equal(shown_positions(noisy), after)
        group = noisy.vertex_groups[PAINT_GROUP]
        group.add([0, 1], 0.0, "REPLACE")
        group.add([2], 0.5, "REPLACE")
        noisy.data.update()
        results.follow_weights(noisy)
        shown = shown_positions(noisy)
        assert np.array_equal(shown[:2], before[:2])
        assert near(shown[2], (before[2] + after[2]) / 2)
        assert np.array_equal(shown[3:], after[3:])
        bpy.ops.object.mode_set(mode="OBJECT")
        bpy.ops.object.adaptive_fairing_apply()
        assert np.array_equal(coordinates(noisy), shown)
        assert PAINT_GROUP not in noisy.vertex_groups

    @pytest.mark.parametrize("way", ["LIVE", "MODIFIER"])
    def test_the_mask_of_sculpt_mode_brings_the_original_back(self, noisy, way):
        before = coordinates(noisy)
        run(result=way)
        after = shown_positions(noisy)
        mask = np.zeros(len(before), dtype=np.float32)
        mask[:50], mask[50] = 1.0, 0.5
        bpy.ops.object.mode_set(mode="SCULPT")
        with pytest.raises(RuntimeError, match="Mask where the original is to come back"):
            bpy.ops.object.adaptive_fairing_paint()
        bpy.ops.object.mode_set(mode="OBJECT")
        noisy.data.attributes.new(".sculpt_mask", "FLOAT", "POINT").data.foreach_set("value", mask)
        bpy.ops.object.mode_set(mode="SCULPT")
        assert bpy.ops.object.adaptive_fairing_paint() == {"FINISHED"}
        assert noisy.mode == "SCULPT"
        shown = shown_positions(noisy)
        assert np.array_equal(shown[:50], before[:50])
        assert near(shown[50], (before[50] + after[50]) / 2)
        assert np.array_equal(shown[51:], after[51:])
        noisy.adaptive_fairing.strength = 1.5
        assert np.array_equal(shown_positions(noisy)[:50], before[:50])

    def test_a_second_run_keeps_what_was_painted(self, noisy):
        before = coordinates(noisy)
        run()
        bpy.ops.object.adaptive_fairing_paint()
        noisy.vertex_groups[PAINT_GROUP].add(range(50), 0.0, "REPLACE")
        results.follow_weights(noisy)
        bpy.ops.object.mode_set(mode="OBJECT")
        other = noisy.vertex_groups.new(name="Other")
        other.add(range(50, len(before)), 1.0, "REPLACE")
        run(vertex_group="Other")
        assert np.array_equal(coordinates(noisy)[:50], before[:50])
        noisy.adaptive_fairing.strength = 1.5
        assert np.array_equal(coordinates(noisy)[:50], before[:50])
