"""The surface that shows a result: everything goes on working there, and nothing is lost."""

import bpy
import numpy as np
import pytest
from support import bad_meshes
from support.meshes import noisy_ball
from support.objects import (
    add_object,
    add_rich_object,
    corners,
    everything,
    key_positions,
    shown_positions,
)

from adaptive_fairing.blender.data import shown_surface
from adaptive_fairing.blender.data.color_map import CURVATURE_FIELDS
from adaptive_fairing.blender.data.fields import field_values
from adaptive_fairing.blender.data.mesh_arrays import read_mesh_coordinates, read_triangles
from adaptive_fairing.blender.data.run_record import end_comparison
from adaptive_fairing.blender.data.shape_keys import animated_frames
from adaptive_fairing.blender.data.stored_result import PAINT_GROUP
from adaptive_fairing.blender.operators import following
from adaptive_fairing.core import FairingSettings, LimitSurface, TriangleTopology
from adaptive_fairing.core.surface import memory_estimate

pytestmark = pytest.mark.usefixtures("addon")

LEVELS = {"LIMIT": 0, "REFINED_1": 1, "REFINED_2": 2, "REFINED_3": 3}
ROUNDING = 8 * 2.0**-23
"""Original, offset and sum are rounded to float32 at coordinates near 1, as is the expectation."""


@pytest.fixture
def noisy():
    obj = add_object(*noisy_ball(3, 0.02))
    obj.select_set(True)
    return obj


def run(**options):
    return bpy.ops.object.adaptive_fairing(**options)


def paper(**options):
    return run(**{"method": "adaptive_timestep", "steps": 3, "tau": 0.01, **options})


def surface(name):
    return bpy.ops.object.adaptive_fairing_surface(surface=name)


def coordinates(obj):
    return read_mesh_coordinates(obj.data)


def refined(obj_or_triangles, positions, name):
    """Return the core's refinement of positions."""
    surface = LimitSurface(TriangleTopology(obj_or_triangles, len(positions)), positions)
    return surface.refined(LEVELS[name]).vertices


def near(found, expected):
    return np.abs(found - expected).max() <= ROUNDING


class TestStrength:
    @pytest.mark.parametrize("way", ["LIVE", "MODIFIER"])
    @pytest.mark.parametrize("name", LEVELS)
    def test_every_strength_is_the_refined_mesh_of_that_strength(self, noisy, name, way):
        triangles = read_triangles(noisy.data)
        run(result=way)
        shown = {}
        for strength in (0.0, 0.4, 1.0, 1.7):
            noisy.adaptive_fairing.strength = strength
            shown[strength] = shown_positions(noisy)
        noisy.adaptive_fairing.strength = 1.0
        assert surface(name) == {"FINISHED"}
        assert len(noisy.data.polygons) == len(triangles) * 4 ** LEVELS[name]
        for strength, positions in shown.items():
            noisy.adaptive_fairing.strength = strength
            assert near(shown_positions(noisy), refined(triangles, positions, name))

    def test_back_on_the_control_mesh_it_has_the_strength_of_now(self, noisy):
        run()
        noisy.adaptive_fairing.strength = 0.3
        expected = coordinates(noisy)
        noisy.adaptive_fairing.strength = 1.0
        surface("REFINED_2")
        noisy.adaptive_fairing.strength = 0.3
        surface("CONTROL")
        assert np.array_equal(coordinates(noisy), expected)
        assert [mesh.name for mesh in bpy.data.meshes] == [noisy.data.name]

    def test_from_one_surface_to_another(self, noisy):
        run()
        surface("REFINED_1")
        expected = everything(noisy)
        surface("REFINED_3")
        surface("LIMIT")
        surface("REFINED_1")
        assert everything(noisy) == expected
        assert len(bpy.data.meshes) == 2

    def test_normals_are_those_of_the_limit_surface(self, noisy):
        triangles = read_triangles(noisy.data)
        run()
        positions = coordinates(noisy)
        surface("REFINED_1")
        flat = np.empty(3 * len(noisy.data.loops), dtype=np.float32)
        if hasattr(noisy.data, "calc_normals_split"):
            noisy.data.calc_normals_split()
        noisy.data.corner_normals.foreach_get("vector", flat)
        exact = LimitSurface(TriangleTopology(triangles, len(positions)), positions).refined(1)
        assert np.abs(flat.reshape(-1, 3) - exact.normals[corners(noisy.data)]).max() < 1e-3

    def test_large_meshes_have_blenders_own_normals(self, noisy, monkeypatch):
        run()
        monkeypatch.setattr(shown_surface, "LARGEST_EXACT", 4 * 1280)
        surface("REFINED_1")
        assert noisy.data.has_custom_normals
        surface("REFINED_2")
        assert not noisy.data.has_custom_normals
        assert all(polygon.use_smooth for polygon in noisy.data.polygons)

    def test_meshes_that_have_to_be_cut(self):
        obj = add_object(*bad_meshes.three_sheets())
        obj.select_set(True)
        paper()
        before = coordinates(obj)
        assert surface("REFINED_2") == {"FINISHED"}
        assert not obj.data.validate(verbose=True)
        surface("CONTROL")
        assert np.array_equal(coordinates(obj), before)


class TestNothingIsLost:
    @pytest.mark.parametrize("name", LEVELS)
    @pytest.mark.parametrize("way", ["LIVE", "MODIFIER", "KEYS"])
    def test_discard_brings_everything_back_bit_by_bit(self, way, name):
        obj = add_rich_object()
        obj.select_set(True)
        bpy.context.view_layer.objects.active = obj
        before, name_before = everything(obj), obj.data.name
        paper() if way == "KEYS" else run(result=way, clean="denoise")
        surface(name)
        assert obj.data.name == name_before
        if way != "KEYS":
            obj.adaptive_fairing.strength = 0.6
        bpy.ops.object.adaptive_fairing_discard()
        after = everything(obj)
        after.pop("fairing_density", None), after.pop("fairing_density_color", None)
        assert after == before
        assert [mesh.name for mesh in bpy.data.meshes] == [name_before]
        assert obj.adaptive_fairing.control is None

    def test_apply_keeps_the_refined_mesh_and_nothing_else(self, noisy):
        run()
        noisy.adaptive_fairing.strength = 0.7
        surface("REFINED_1")
        shown = coordinates(noisy)
        bpy.ops.object.adaptive_fairing_apply()
        assert np.array_equal(coordinates(noisy), shown)
        assert [n for n in noisy.data.attributes.keys() if n.startswith("fairing")] == []
        assert len(bpy.data.meshes) == 1
        assert not bpy.ops.object.adaptive_fairing_surface.poll()

    def test_sculpting_on_the_refined_mesh_is_never_written_over(self, noisy):
        run()
        surface("REFINED_1")
        noisy.data.vertices[900].co.x += 0.3
        noisy.data.update()
        sculpted = coordinates(noisy)
        noisy.adaptive_fairing.strength = 0.2
        assert not bpy.ops.object.adaptive_fairing_surface.poll()
        assert np.array_equal(coordinates(noisy), sculpted)
        paper()
        assert np.array_equal(key_positions(noisy, "Basis"), sculpted)
        assert noisy.adaptive_fairing.control is None

    @pytest.mark.parametrize("work", ["attribute", "key", "uv"])
    def test_other_work_on_the_refined_mesh_stays_in_the_file(self, noisy, work, capfd):
        paper() if work == "key" else run()
        surface("REFINED_1")
        mesh = noisy.data
        if work == "attribute":
            mesh.attributes.new("mine", "FLOAT", "POINT").data[700].value = 5.0
        elif work == "uv":
            mesh.uv_layers.new(name="Mine")
        else:
            mesh.shape_keys.key_blocks["Fairing 2"].data[700].co.x = 9.0
        surface("CONTROL")
        assert "it stays in the file" in capfd.readouterr().out
        assert mesh.name.endswith("refined") and mesh.use_fake_user
        assert noisy.data != mesh

    def test_weights_of_another_net_do_not_go_back(self, noisy):
        """Deleting vertices of an evolution gives all others new numbers."""
        paper()
        noisy.vertex_groups.new(name="Odd").add(range(1, 600, 2), 1.0, "REPLACE")
        before = everything(noisy)
        surface("REFINED_1")
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="DESELECT")
        bpy.ops.object.mode_set(mode="OBJECT")
        noisy.data.vertices[0].select = True
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.delete(type="VERT")
        bpy.ops.object.mode_set(mode="OBJECT")
        edited = noisy.data
        surface("CONTROL")
        assert everything(noisy) == before
        assert edited.use_fake_user

    def test_unused_data_can_be_purged(self, noisy):
        before = coordinates(noisy)
        run()
        surface("REFINED_1")
        bpy.data.orphans_purge(do_recursive=True)
        bpy.ops.object.adaptive_fairing_discard()
        assert np.array_equal(coordinates(noisy), before)

    def test_materials_and_painting_go_back_to_the_control_mesh(self, noisy):
        run()
        surface("REFINED_1")
        red = bpy.data.materials.new("Red")
        noisy.data.materials.append(red)
        bpy.ops.object.adaptive_fairing_paint()
        noisy.vertex_groups[PAINT_GROUP].add(range(40), 0.25, "REPLACE")
        following.follow_weights(noisy)
        bpy.ops.object.mode_set(mode="OBJECT")
        shown = coordinates(noisy)
        surface("CONTROL")
        assert list(noisy.data.materials) == [red]
        weights = [v.groups[0].weight for v in noisy.data.vertices]
        assert weights == [0.25] * 40 + [1.0] * (len(weights) - 40)
        assert len(bpy.data.meshes) == 1
        surface("REFINED_1")
        found = coordinates(noisy)
        assert near(found[:40], shown[:40])

    def test_copies_of_the_object_do_not_share_the_control_mesh(self, noisy):
        before = coordinates(noisy)
        run()
        surface("REFINED_1")
        bpy.ops.object.duplicate()
        copy = bpy.context.object
        assert copy != noisy
        shown = coordinates(noisy)
        bpy.ops.object.adaptive_fairing_discard()
        assert np.array_equal(coordinates(copy), before)
        assert np.array_equal(coordinates(noisy), shown)
        noisy.adaptive_fairing.strength = 0.0
        bpy.context.view_layer.objects.active = noisy
        bpy.ops.object.adaptive_fairing_discard()
        assert np.array_equal(coordinates(noisy), before)

    def test_it_is_kept_in_the_file(self, noisy, tmp_path):
        before = coordinates(noisy)
        run()
        surface("REFINED_2")
        shown = coordinates(noisy)
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
        bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "a.blend"))
        obj = bpy.data.objects["Thing"]
        assert np.array_equal(coordinates(obj), shown)
        obj.adaptive_fairing.strength = 0.4
        bpy.ops.object.adaptive_fairing_discard()
        assert np.array_equal(coordinates(obj), before)


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
        moved = np.abs(after - before).max(axis=1) > ROUNDING
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
            values = field_values(noisy, field, FairingSettings())
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
        end_comparison(noisy.adaptive_fairing)
        assert np.array_equal(coordinates(noisy), shown)

    def test_in_edit_mode(self, noisy):
        run()
        bpy.ops.object.mode_set(mode="EDIT")
        assert surface("REFINED_1") == {"FINISHED"}
        assert noisy.mode == "EDIT"
        bpy.ops.object.mode_set(mode="OBJECT")
        assert len(noisy.data.polygons) > 1280


def test_what_does_not_fit_into_memory_is_refused_and_the_control_mesh_stays(noisy, monkeypatch):
    run()
    shown = coordinates(noisy)
    monkeypatch.setattr(memory_estimate, "available_bytes", lambda: 10**6)
    with pytest.raises(RuntimeError, match="choose fewer levels"):
        surface("REFINED_3")
    assert np.array_equal(coordinates(noisy), shown)
    assert len(bpy.data.meshes) == 1
    noisy.adaptive_fairing.strength = 0.5
    assert not np.array_equal(coordinates(noisy), shown)
