"""The results of several objects: linked duplicates of one mesh, and objects selected together."""

import bpy
import numpy as np
import pytest
from support.objects import shown_positions
from support.results import coordinates, near, paper, run, surface

pytestmark = pytest.mark.usefixtures("addon")


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
        # Blender adds up what it shows of keys, in single precision.
        equal = near if (way, end) == ("KEYS", "apply") else np.array_equal
        for obj in twins:
            assert (obj.adaptive_fairing.result, list(obj.modifiers)) == ("", [])
            assert equal(shown_positions(obj), before if end == "discard" else shown)

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
