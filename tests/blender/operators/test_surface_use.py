"""On a refined surface everything goes on working: keys, another run, views."""

import bpy
import numpy as np
import pytest
from support.meshes import noisy_ball
from support.objects import add_object, key_positions, shown_positions
from support.results import LEVELS, ULP, coordinates, near, paper, refined, run, surface

from adaptive_fairing.blender.data.color_map import CURVATURE_FIELDS
from adaptive_fairing.blender.data.fields import measure_field
from adaptive_fairing.blender.data.mesh_arrays import read_triangles
from adaptive_fairing.blender.data.results import end_comparison
from adaptive_fairing.blender.data.shape_keys import animated_frames
from adaptive_fairing.core import FairingSettings, LimitSurface, TriangleTopology

pytestmark = pytest.mark.usefixtures("addon")


class TestKeys:
    def test_the_evolution_is_the_refined_mesh_of_every_step(self, noisy):
        triangles = read_triangles(noisy.data)
        paper()
        steps = {b.name: key_positions(noisy, b.name) for b in noisy.data.shape_keys.key_blocks}
        surface("REFINED_2")
        assert noisy.adaptive_fairing.evolution == 1.0
        for name, positions in steps.items():
            assert near(key_positions(noisy, name), refined(triangles, positions, "REFINED_2"))
        noisy.adaptive_fairing.evolution = 0.5
        mixed = (steps["Fairing 1"] + steps["Fairing 2"]) / 2
        assert near(shown_positions(noisy), refined(triangles, mixed, "REFINED_2"))
        assert near(coordinates(noisy), shown_positions(noisy))
        surface("CONTROL")
        assert noisy.adaptive_fairing.evolution == pytest.approx(0.5)
        assert near(shown_positions(noisy), mixed)

    def test_the_animation_goes_along_and_comes_back(self, noisy):
        paper()
        bpy.ops.object.adaptive_fairing_animate(frame_start=7, frame_end=40)
        surface("REFINED_1")
        assert animated_frames(noisy) == (7.0, 40.0)
        bpy.context.scene.frame_set(40)
        assert near(shown_positions(noisy), key_positions(noisy, "Fairing 3"))
        bpy.ops.object.adaptive_fairing_animate(frame_start=1, frame_end=30)
        surface("CONTROL")
        assert animated_frames(noisy) == (1.0, 30.0)
        surface("LIMIT")
        bpy.ops.object.adaptive_fairing_animate_clear()
        surface("CONTROL")
        assert animated_frames(noisy) is None
        assert [action for action in bpy.data.actions if action.users] == []

    def test_shape_keys_of_the_user(self, noisy):
        noisy.shape_key_add(name="Basis", from_mix=False)
        smile = noisy.shape_key_add(name="Smile", from_mix=False)
        smile.data[3].co.x += 1.0
        triangles, smiling = read_triangles(noisy.data), key_positions(noisy, "Smile")
        run(result="MODIFIER")
        surface("REFINED_1")
        assert near(key_positions(noisy, "Smile"), refined(triangles, smiling, "REFINED_1"))
        noisy.data.shape_keys.key_blocks["Smile"].value = 0.5
        surface("CONTROL")
        assert noisy.data.shape_keys.key_blocks["Smile"].value == 0.5
        bpy.ops.object.adaptive_fairing_discard()
        assert np.array_equal(key_positions(noisy, "Smile"), smiling)


class TestAnotherRun:
    @pytest.mark.parametrize("way", ["LIVE", "MODIFIER"])
    def test_it_works_on_the_control_mesh_and_is_refined_again(self, noisy, way):
        run(result=way)
        noisy.adaptive_fairing.strength = 0.6
        run(features="smooth", result=way)
        expected = shown_positions(noisy)
        triangles = read_triangles(noisy.data)
        bpy.ops.object.adaptive_fairing_discard()

        run(result=way)
        surface("REFINED_1")
        noisy.adaptive_fairing.strength = 0.6
        run(features="smooth", result=way)
        assert noisy.adaptive_fairing.surface == "REFINED_1"
        assert near(shown_positions(noisy), refined(triangles, expected, "REFINED_1"))
        surface("CONTROL")
        assert near(shown_positions(noisy), expected)

    def test_the_result_goes_to_a_copy_of_an_object_with_keys_of_its_own(self, noisy):
        noisy.shape_key_add(name="Basis", from_mix=False)
        smile = noisy.shape_key_add(name="Smile", from_mix=False)
        smile.data[3].co.x += 1.0
        smile.value = 0.0
        before, n = coordinates(noisy), len(noisy.data.vertices)
        run(result="MODIFIER")
        noisy.adaptive_fairing.strength = 0.5
        shown, triangles = shown_positions(noisy), read_triangles(noisy.data)
        surface("REFINED_1")
        run(features="smooth")
        copy = bpy.context.object
        assert copy != noisy and copy.data.shape_keys is None
        assert len(copy.data.vertices) == len(noisy.data.vertices) > n
        assert near(shown_positions(noisy), refined(triangles, shown, "REFINED_1"))
        bpy.ops.object.adaptive_fairing_discard()
        assert np.array_equal(coordinates(copy), before)
        bpy.context.view_layer.objects.active = noisy
        bpy.ops.object.adaptive_fairing_discard()
        assert np.array_equal(coordinates(noisy), before)
        assert [block.name for block in noisy.data.shape_keys.key_blocks] == ["Basis", "Smile"]

    def test_a_region_chosen_on_the_refined_mesh(self):
        noisy = add_object(*noisy_ball(4, 0.02))
        noisy.select_set(True)
        n = len(noisy.data.vertices)
        run(strength=0.5)
        surface("REFINED_1")
        before = coordinates(noisy)
        group = noisy.vertex_groups.new(name="Part")
        group.add(np.flatnonzero(before[:, 2] > 0.5).tolist(), 1.0, "REPLACE")
        run(vertex_group="Part", features="smooth")
        after = coordinates(noisy)
        moved = np.abs(after - before).max(axis=1) > 4 * ULP
        assert moved[:n][before[:n, 2] > 0.6].mean() > 0.9
        assert not moved[before[:, 2] < 0].any()
        assert list(noisy.vertex_groups.keys()) == ["Part"]
        assert len(bpy.data.meshes) == 2

    def test_only_the_final_shape_is_left_unrefined(self, noisy):
        n = len(noisy.data.vertices)
        paper()
        surface("REFINED_1")
        paper(output="FINAL_SHAPE")
        assert len(noisy.data.vertices) == n and noisy.data.shape_keys is None
        assert len(bpy.data.meshes) == 1

    def test_compare_takes_the_control_mesh(self, noisy):
        n = len(noisy.data.vertices)
        run()
        surface("REFINED_1")
        bpy.ops.object.adaptive_fairing_compare()
        copies = [o for o in bpy.data.objects if o.type == "MESH" and o != noisy]
        assert [len(copy.data.vertices) for copy in copies] == [n] * 3
        assert len(noisy.data.vertices) > n


class TestViews:
    def test_colors_are_made_anew(self, noisy):
        run()
        bpy.ops.object.adaptive_fairing_view(field="REMOVED")
        for name in ("REFINED_1", "CONTROL"):
            surface(name)
            assert noisy.adaptive_fairing.view == "REMOVED"
            values = np.empty(len(noisy.data.vertices), dtype=np.float32)
            noisy.data.attributes["fairing_removed"].data.foreach_get("value", values)
            assert np.ptp(values) > 0
        bpy.ops.object.adaptive_fairing_view_end()
        surface("REFINED_1")
        assert "fairing_removed" not in noisy.data.attributes

    @pytest.mark.parametrize("name", LEVELS)
    def test_curvature_is_that_of_the_control_meshs_surface(self, noisy, name):
        triangles = read_triangles(noisy.data)
        run()
        noisy.adaptive_fairing.strength = 0.5
        positions = coordinates(noisy)
        limit = LimitSurface(TriangleTopology(triangles, len(positions)), positions)
        noisy.adaptive_fairing.strength = 1.0
        surface(name)
        noisy.adaptive_fairing.strength = 0.5
        refined_mesh, shown = noisy.data, coordinates(noisy)
        for row, field in enumerate(CURVATURE_FIELDS):
            values = measure_field(noisy, field, FairingSettings()).values
            assert np.array_equal(values, limit.refined_curvature(LEVELS[name])[row])
        assert noisy.data == refined_mesh and np.array_equal(coordinates(noisy), shown)
        noisy.adaptive_fairing.strength = 1.0
        assert not np.array_equal(coordinates(noisy), shown)

    def test_before_and_split(self, noisy):
        run()
        surface("REFINED_1")
        shown = coordinates(noisy)
        bpy.ops.object.adaptive_fairing_before()
        original = coordinates(noisy)
        assert not near(original, shown)
        bpy.ops.object.adaptive_fairing_before()
        bpy.ops.object.adaptive_fairing_split()
        left = original[:, 0] < np.float32(noisy.adaptive_fairing.split_point[0])
        assert np.array_equal(coordinates(noisy)[left], original[left])
        end_comparison(noisy)
        assert np.array_equal(coordinates(noisy), shown)

    def test_in_edit_mode(self, noisy):
        run()
        bpy.ops.object.mode_set(mode="EDIT")
        assert surface("REFINED_1") == {"FINISHED"}
        assert noisy.mode == "EDIT"
        bpy.ops.object.mode_set(mode="OBJECT")
        assert len(noisy.data.polygons) > 1280
