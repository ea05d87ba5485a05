"""The surface that shows a result: every strength is refined, and nothing is lost."""

import bpy
import numpy as np
import pytest
from support import bad_meshes
from support.objects import (
    add_object,
    add_rich_object,
    corners,
    edit_net,
    everything,
    key_positions,
    shown_positions,
)
from support.results import LEVELS, coordinates, near, paper, refined, run, surface

from adaptive_fairing.blender.data import results, shown_surface
from adaptive_fairing.blender.data.mesh_arrays import read_triangles
from adaptive_fairing.blender.data.vertex_groups import PAINT_GROUP
from adaptive_fairing.core import LimitSurface, TriangleTopology
from adaptive_fairing.core.surface import memory_estimate

pytestmark = pytest.mark.usefixtures("addon")


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
        assert [n for n in noisy.data.attributes.keys() if "fairing" in n] == []
        assert len(bpy.data.meshes) == 1
        assert not bpy.ops.object.adaptive_fairing_surface.poll()

    def test_sculpting_on_the_refined_mesh_is_never_written_over(self, noisy):
        run()
        surface("REFINED_1")
        noisy.data.vertices[900].co.x += 0.3
        noisy.data.update()
        stroke = coordinates(noisy)[900]
        noisy.adaptive_fairing.strength = 0.2
        sculpted = coordinates(noisy)
        assert np.array_equal(sculpted[900], stroke)
        paper()
        assert np.array_equal(key_positions(noisy, "Basis"), sculpted)
        assert noisy.adaptive_fairing.control is None

    @pytest.mark.parametrize("work", ["attribute", "key", "stroke", "uv"])
    def test_other_work_on_the_refined_mesh_stays_in_the_file(self, noisy, work, capfd):
        paper() if work == "key" else run()
        surface("REFINED_1")
        mesh = noisy.data
        if work == "attribute":
            mesh.attributes.new("mine", "FLOAT", "POINT").data[700].value = 5.0
        elif work == "stroke":
            mesh.vertices[700].co.x = 9.0
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
        edit_net(noisy, "delete")
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
        results.follow_weights(noisy)
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
