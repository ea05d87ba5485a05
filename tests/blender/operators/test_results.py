"""The result of a run: the slider, a second run, keeping, discarding, other work in between."""

import bpy
import numpy as np
import pytest
from support.objects import edit_net, key_positions, select, shown_positions
from support.results import coordinates, core_result, fairing_attributes, near, paper, run

from adaptive_fairing.blender.data.shape_keys import animated_frames

pytestmark = pytest.mark.usefixtures("addon")


def stroke(obj, vertex=5):
    """Move one vertex, as sculpting does."""
    obj.data.vertices[vertex].co.x += 0.3
    obj.data.update()


class TestLive:
    def test_the_mesh_itself_gets_the_result(self, noisy):
        expected = core_result(noisy)
        assert run() == {"FINISHED"}
        assert noisy.data.shape_keys is None
        assert list(noisy.modifiers) == []
        assert near(coordinates(noisy), expected.positions)
        assert np.array_equal(shown_positions(noisy), coordinates(noisy))

    @pytest.mark.parametrize("strength", [0.0, 0.3, 0.5, 0.6, 1.0, 1.2, 2.0, 5.0])
    def test_the_slider_shows_every_strength(self, noisy, strength):
        expected = core_result(noisy)
        run()
        noisy.adaptive_fairing.strength = strength
        assert near(coordinates(noisy), expected.at(strength))
        assert noisy.adaptive_fairing.strength == np.float32(strength)

    def test_strength_and_edges_reach_the_core(self, noisy):
        expected = core_result(noisy, strength=1.7, features="sharp")
        run(strength=1.7, features="sharp")
        assert near(coordinates(noisy), expected.positions)
        assert noisy.adaptive_fairing.strength == np.float32(1.7)

    def test_strength_0_and_discard_are_the_original_bit_by_bit(self, noisy):
        before = coordinates(noisy)
        run()
        noisy.adaptive_fairing.strength = 0.0
        assert np.array_equal(coordinates(noisy), before)
        noisy.adaptive_fairing.strength = 1.3
        bpy.ops.object.adaptive_fairing_discard()
        assert np.array_equal(coordinates(noisy), before)
        assert fairing_attributes(noisy) == []
        assert not bpy.ops.object.adaptive_fairing_discard.poll()

    def test_apply_keeps_the_shape_and_nothing_else(self, noisy):
        run()
        noisy.adaptive_fairing.strength = 0.7
        shown = coordinates(noisy)
        bpy.ops.object.adaptive_fairing_apply()
        assert np.array_equal(coordinates(noisy), shown)
        assert fairing_attributes(noisy) == []
        assert len(noisy.vertex_groups) == 0
        noisy.adaptive_fairing.strength = 0.0
        assert np.array_equal(coordinates(noisy), shown)

    def test_it_is_kept_in_the_file(self, noisy, tmp_path):
        before = coordinates(noisy)
        run()
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
        bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "a.blend"))
        obj = bpy.data.objects["Thing"]
        obj.adaptive_fairing.strength = 0.0
        assert np.array_equal(coordinates(obj), before)


class TestASecondRun:
    def test_it_starts_from_what_is_shown(self, noisy):
        run()
        noisy.adaptive_fairing.strength = 0.6
        expected = core_result(noisy)
        run()
        assert near(coordinates(noisy), expected.positions)

    def test_discard_goes_back_to_the_first_original(self, noisy):
        before = coordinates(noisy)
        run()
        run(features="smooth")
        paper()
        run()
        bpy.ops.object.adaptive_fairing_discard()
        assert np.array_equal(coordinates(noisy), before)

    def test_two_regions_add_up_and_0_brings_back_the_second(self, noisy):
        """0 brought back both."""
        before = coordinates(noisy)
        upper = before[:, 2] > 0
        group = noisy.vertex_groups.new(name="Upper")
        group.add(np.flatnonzero(upper).tolist(), 1.0, "REPLACE")
        run(vertex_group="Upper")
        first = coordinates(noisy)
        assert np.array_equal(first[~upper], before[~upper])
        run(vertex_group="Upper", invert_vertex_group=True)
        second = coordinates(noisy)
        assert near(second[upper], first[upper])
        assert not np.array_equal(second[~upper], before[~upper])
        noisy.adaptive_fairing.strength = 0.0
        assert near(coordinates(noisy)[upper], first[upper])
        assert np.array_equal(coordinates(noisy)[~upper], before[~upper])
        noisy.adaptive_fairing.strength = 1.0
        assert near(coordinates(noisy), second)
        bpy.ops.object.adaptive_fairing_discard()
        assert np.array_equal(coordinates(noisy), before)

    def test_a_selected_region_and_the_rest(self, noisy):
        before = coordinates(noisy)
        upper = before[:, 2] > 0
        for wanted in (upper, ~upper):
            select(noisy, wanted)
            bpy.ops.object.mode_set(mode="EDIT")
            assert run() == {"FINISHED"}
            assert noisy.mode == "EDIT"
            bpy.ops.object.mode_set(mode="OBJECT")
        moved = np.abs(coordinates(noisy) - before).max(axis=1) > 0
        assert moved[upper].mean() > 0.9
        assert moved[~upper].mean() > 0.9

    def test_from_original_discards_the_first(self, noisy):
        expected = core_result(noisy, features="smooth")
        run(strength=0.5)
        run(features="smooth", from_original=True)
        assert near(coordinates(noisy), expected.positions)


class TestWorkInBetween:
    def test_a_stroke_is_not_lost(self, noisy):
        """Run, sculpt, run: the stroke was gone."""
        run()
        stroke(noisy)
        sculpted = coordinates(noisy)
        paper()
        assert np.array_equal(key_positions(noisy, "Basis"), sculpted)
        bpy.ops.object.adaptive_fairing_discard()
        assert np.array_equal(coordinates(noisy), sculpted)

    @pytest.mark.parametrize("change", ["subdivide", "delete", "remesh"])
    def test_other_vertices_are_kept(self, noisy, change):
        run()
        if change == "remesh":
            noisy.data.remesh_voxel_size = 0.2
            bpy.ops.object.voxel_remesh()
        else:
            edit_net(noisy, change)
        changed = coordinates(noisy)
        noisy.adaptive_fairing.strength = 0.0
        assert np.array_equal(coordinates(noisy), changed)
        paper()
        assert np.array_equal(key_positions(noisy, "Basis"), changed)
        assert fairing_attributes(noisy) == ["fairing_density", "fairing_density_color"]
        bpy.ops.object.adaptive_fairing_discard()
        assert np.array_equal(coordinates(noisy), changed)

    def test_a_renamed_object_gets_its_result(self, noisy):
        run()
        noisy.name = "Other"
        assert bpy.ops.object.adaptive_fairing_discard() == {"FINISHED"}


class TestNothingToDo:
    @pytest.fixture
    def clean(self):
        bpy.ops.mesh.primitive_uv_sphere_add()
        return bpy.context.object

    def test_nothing_changed_means_nothing(self, clean, capfd):
        before, names = coordinates(clean), clean.data.attributes.keys()
        assert run() == {"CANCELLED"}
        said = capfd.readouterr().out
        assert said.count("nothing was changed") == 1
        assert "Denoised" not in said
        assert np.array_equal(coordinates(clean), before)
        assert clean.data.attributes.keys() == names
        assert clean.data.shape_keys is None
        assert list(clean.modifiers) == []
        assert clean.adaptive_fairing.result == ""
        assert len(clean.adaptive_fairing.shapes) == 0

    def test_it_can_be_denoised_all_the_same(self):
        bpy.ops.mesh.primitive_monkey_add()
        assert run() == {"CANCELLED"}
        assert run(clean="denoise") == {"FINISHED"}


@pytest.mark.parametrize("end", ["apply", "discard"])
@pytest.mark.parametrize("way", ["LIVE", "MODIFIER", "KEYS"])
def test_the_end_of_a_result_leaves_no_statistics_and_no_density(noisy, end, way):
    names = noisy.data.attributes.keys()
    paper() if way == "KEYS" else run(result=way, store_density=True)
    assert "fairing_density" in noisy.data.attributes
    getattr(bpy.ops.object, f"adaptive_fairing_{end}")()
    record = noisy.adaptive_fairing
    assert (record.result, record.notes, len(record.shapes)) == ("", "", 0)
    assert noisy.data.attributes.keys() == names


class TestTheRedoPanel:
    """Undo, and the same again with one property changed."""

    def test_what_does_not_change_the_solve_costs_none(self, noisy, monkeypatch, capfd):
        from adaptive_fairing.blender.jobs import solve

        run()
        shown = coordinates(noisy)
        bpy.ops.object.adaptive_fairing_discard()
        monkeypatch.setattr(solve, "denoise", None)  # would fail if it were called
        capfd.readouterr()
        assert run(result="MODIFIER", store_density=True) == {"FINISHED"}
        assert "vertices, 0.0 s" in capfd.readouterr().out
        assert near(shown_positions(noisy), shown)
        assert "fairing_density" in noisy.data.attributes

    def test_other_settings_are_solved_anew(self, noisy):
        run()
        bpy.ops.object.adaptive_fairing_discard()
        expected = core_result(noisy, features="smooth", strength=0.6)
        run(features="smooth", strength=0.6)
        assert near(coordinates(noisy), expected.positions)


class TestKeys:
    @pytest.mark.parametrize("by", ["shape_key_clear", "foreign key"])
    def test_without_its_keys_there_is_no_result_to_change(self, noisy, by):
        paper()
        if by == "foreign key":
            noisy.shape_key_add(name="Smile", from_mix=False)
        else:
            noisy.shape_key_clear()
        for end in ("apply", "surface", "split"):
            with pytest.raises(RuntimeError, match="The mesh was changed since the last run"):
                getattr(bpy.ops.object, f"adaptive_fairing_{end}")()

    def test_the_paper_starts_from_what_is_shown_and_keeps_the_original(self, noisy):
        before = coordinates(noisy)
        run()
        denoised = coordinates(noisy)
        paper()
        assert np.array_equal(key_positions(noisy, "Basis"), denoised)
        assert np.array_equal(coordinates(noisy), key_positions(noisy, "Fairing 3"))
        bpy.ops.object.adaptive_fairing_discard()
        assert noisy.data.shape_keys is None
        assert np.array_equal(coordinates(noisy), before)

    def test_a_second_run_starts_from_the_slider(self, noisy):
        paper()
        noisy.adaptive_fairing.evolution = 0.5
        shown = shown_positions(noisy)
        paper(steps=1)
        assert near(key_positions(noisy, "Basis"), shown)

    @pytest.mark.parametrize("evolution", [0.0, 0.2, 1 / 3, 0.5, 0.9, 1.0])
    def test_the_mesh_has_the_shape_that_the_slider_shows(self, noisy, evolution):
        paper()
        noisy.adaptive_fairing.evolution = evolution
        is_beside_basis = evolution < 0.3
        shown = key_positions(noisy, "Basis") if is_beside_basis else shown_positions(noisy)
        assert near(coordinates(noisy), shown)
        keys = noisy.data.shape_keys
        basis = key_positions(noisy, "Basis")
        sum_of_keys = basis + sum(
            block.value * (key_positions(noisy, block.name) - basis) for block in keys.key_blocks
        )
        assert near(sum_of_keys, shown_positions(noisy))

    def test_a_second_run_keeps_the_animation(self, noisy):
        paper()
        bpy.ops.object.adaptive_fairing_animate(frame_start=7, frame_end=40)
        paper(steps=2)
        assert animated_frames(noisy) == (7.0, 40.0)
        bpy.context.scene.frame_set(40)
        assert near(shown_positions(noisy), key_positions(noisy, "Fairing 2"))

    def test_apply_keeps_what_is_shown(self, noisy):
        paper()
        noisy.adaptive_fairing.evolution = 0.5
        shown = shown_positions(noisy)
        bpy.ops.object.adaptive_fairing_apply()
        assert noisy.data.shape_keys is None
        assert near(coordinates(noisy), shown)
