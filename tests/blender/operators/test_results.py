"""The result of a run: the slider, a second run, keeping, discarding, other work in between."""

import bpy
import numpy as np
import pytest
from support.objects import edit_net, key_positions, select, shown_positions
from support.results import coordinates, core_result, fairing_attributes, near, paper, run, surface

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


class TestLinkedDuplicates:
    def test_the_others_keep_their_mesh_and_that_is_said(self, noisy, capfd):
        twin = bpy.data.objects.new("Twin", noisy.data)
        bpy.context.scene.collection.objects.link(twin)
        before = coordinates(twin)
        run()
        assert "Thing has a mesh of its own now" in capfd.readouterr().out
        assert np.array_equal(coordinates(twin), before)
        bpy.ops.object.adaptive_fairing_discard()
        assert np.array_equal(coordinates(noisy), before)

    @pytest.fixture
    def twins(self, noisy):
        twin = noisy.copy()
        twin.name = "Twin"
        bpy.context.scene.collection.objects.link(twin)
        twin.select_set(True)
        return noisy, twin

    @pytest.mark.parametrize("way", ["LIVE", "MODIFIER", "KEYS"])
    @pytest.mark.parametrize("end", ["apply", "discard"])
    def test_selected_together_they_have_one_run_and_one_result(self, twins, capfd, way, end):
        before = coordinates(twins[0])
        for again in (False, True):  # the second run replaces a result that both have
            paper(from_original=again) if way == "KEYS" else run(result=way, from_original=again)
            said = capfd.readouterr().out
            n_vertices = len(before)
            assert f"ed {n_vertices} vertices" in said
            assert "mesh of its own" not in said
            assert twins[0].data == twins[1].data
            assert list(bpy.data.meshes) == [twins[0].data]
            assert twins[0].data.name == "Thing"
        shown = shown_positions(twins[0])
        assert np.array_equal(shown_positions(twins[1]), shown)
        assert twins[1].adaptive_fairing.noise == twins[0].adaptive_fairing.noise
        assert len(twins[1].adaptive_fairing.shapes) == len(twins[0].adaptive_fairing.shapes)
        name = "evolution" if way == "KEYS" else "strength"
        setattr(twins[1].adaptive_fairing, name, 0.0)
        assert np.array_equal(shown_positions(twins[1]), before)
        if way != "MODIFIER":  # every object has its own modifier
            assert np.array_equal(shown_positions(twins[0]), before)
        setattr(twins[1].adaptive_fairing, name, 1.0)
        assert getattr(bpy.ops.object, f"adaptive_fairing_{end}")() == {"FINISHED"}
        for obj in twins:
            assert (obj.adaptive_fairing.result, list(obj.modifiers)) == ("", [])
            assert np.array_equal(shown_positions(obj), before if end == "discard" else shown)

    def test_one_that_is_not_selected_keeps_its_mesh(self, twins, capfd):
        third = twins[0].copy()
        third.name = "Third"
        bpy.context.scene.collection.objects.link(third)
        third.select_set(False)
        before = coordinates(third)
        run()
        assert "Thing has a mesh of its own now" in capfd.readouterr().out
        assert np.array_equal(coordinates(third), before)
        assert twins[0].data == twins[1].data != third.data

    def test_on_a_refined_surface_none_is_lost(self, noisy):
        run()
        surface("REFINED_1")
        twin = noisy.copy()
        twin.name = "Twin"
        bpy.context.scene.collection.objects.link(twin)
        shown = shown_positions(twin)
        surface("CONTROL")
        assert {obj.name for obj in bpy.data.objects} == {"Thing", "Twin"}
        assert np.array_equal(shown_positions(twin), shown)
        surface("REFINED_1")
        twin.data = noisy.data
        twin.select_set(True)
        run(from_original=True)
        assert twin.data == noisy.data
        assert twin.adaptive_fairing.control == noisy.adaptive_fairing.control
        assert sum(1 for mesh in bpy.data.meshes if mesh.users) == 2
        bpy.ops.object.adaptive_fairing_discard()
        assert {obj.name for obj in bpy.data.objects} == {"Thing", "Twin"}


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


class TestSeveralObjects:
    @pytest.fixture
    def three(self, noisy):
        for name in ("Second", "Clean"):
            copy = noisy.copy()
            copy.name, copy.data = name, noisy.data.copy()
            bpy.context.scene.collection.objects.link(copy)
            copy.select_set(name == "Second")
        run()
        bpy.data.objects["Clean"].select_set(True)
        return [noisy, bpy.data.objects["Second"], bpy.data.objects["Clean"]]

    @pytest.mark.parametrize("end", ["apply", "discard"])
    def test_a_result_ends_on_all_that_are_selected_and_have_one(self, three, end):
        shown = [coordinates(obj) for obj in three]
        original = shown[2]
        assert getattr(bpy.ops.object, f"adaptive_fairing_{end}")() == {"FINISHED"}
        for obj, positions in zip(three, shown, strict=True):
            assert obj.adaptive_fairing.result == ""
            expected = positions if end == "apply" else original
            assert np.array_equal(coordinates(obj), expected)

    def test_one_of_which_the_original_is_lost_stays(self, three, capfd):
        first, second, _ = three
        second.data.attributes.remove(second.data.attributes[".fairing_original"])
        changed = coordinates(second)
        assert bpy.ops.object.adaptive_fairing_discard() == {"FINISHED"}
        assert first.adaptive_fairing.result == ""
        assert np.array_equal(coordinates(second), changed)
        assert "Second: there is no result on this object" in capfd.readouterr().out

    def test_one_that_is_not_selected_keeps_its_result(self, three):
        first, second, _ = three
        second.select_set(False)
        bpy.ops.object.adaptive_fairing_discard()
        assert (first.adaptive_fairing.result, second.adaptive_fairing.result) == ("", "LIVE")
