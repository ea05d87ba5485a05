"""The operator that fairs: its result is the core's, its errors say what to do."""

from dataclasses import fields

import bpy
import numpy as np
import pytest
from support.meshes import graded_sphere, icosphere
from support.objects import add_object, key_positions, numbers

from adaptive_fairing.blender.data.mesh_arrays import read_mesh, read_positions
from adaptive_fairing.blender.properties import (
    DENOISE_NAMES,
    FAIRING_NAMES,
    SOLVER_NAMES,
    fairing_settings,
    solver_settings,
)
from adaptive_fairing.cli.options import parse, settings_of
from adaptive_fairing.core import DenoiseSettings, FairingSettings, fair

pytestmark = pytest.mark.usefixtures("addon")


def run(**options):
    """Fair the selected objects by a method of the paper."""
    return bpy.ops.object.adaptive_fairing(**{"method": "adaptive_timestep", **options})


def noisy_sphere(levels=2, seed=1, **options):
    """Add a selected sphere with noise."""
    vertices, faces = icosphere(levels)
    vertices = vertices + np.random.default_rng(seed).normal(0.0, 0.02, vertices.shape)
    obj = add_object(vertices, faces, **options)
    obj.select_set(True)
    return obj


def core_result(obj, **settings):
    """Fair the undeformed mesh of an object with the core."""
    data = read_mesh(obj.data)
    return fair(data.vertices, data.triangles, FairingSettings(**settings))


class TestSettings:
    def test_every_setting_of_the_core_is_a_property(self):
        assert set(FAIRING_NAMES) == set(FairingSettings.names())
        of_denoise = {field.name for field in fields(DenoiseSettings)}
        assert set(DENOISE_NAMES) == of_denoise
        assert set(SOLVER_NAMES) == of_denoise | set(FAIRING_NAMES)

    def test_panel_command_line_and_python_start_with_denoise(self):
        assert solver_settings(bpy.context.scene.adaptive_fairing) == DenoiseSettings()
        assert settings_of(parse(["in.ply"])) == DenoiseSettings()

    def test_the_papers_defaults_are_the_cores(self):
        bpy.context.scene.adaptive_fairing.method = "adaptive_timestep"
        assert solver_settings(bpy.context.scene.adaptive_fairing) == FairingSettings()

    def test_numbers_come_through_as_they_were_typed(self):
        settings = bpy.context.scene.adaptive_fairing
        settings.method = "uniform"
        settings.tau, settings.cg_tolerance, settings.stop_rate = 0.0107, 3e-8, 0.7
        made = solver_settings(settings)
        assert (made.tau, made.cg_tolerance, made.stop_rate) == (0.0107, 3e-8, 0.7)

    def test_zero_turns_a_stopping_rule_off(self):
        made = fairing_settings(bpy.context.scene.adaptive_fairing)
        assert made.stop_curvature is None
        assert made.stop_rate is None

    @pytest.mark.parametrize(
        ("options", "message"),
        [
            ({"steps": 4}, "steps belongs to the paper's methods, not to 'auto'"),
            ({"method": "auto", "tau": 0.1}, "tau belongs to the paper's methods, not to 'auto'"),
            (
                {"method": "uniform", "strength": 2.0},
                "strength belongs to method=\"auto\", not to 'uniform'",
            ),
        ],
    )
    def test_a_script_cannot_mix_the_two_algorithms(self, options, message):
        noisy_sphere()
        with pytest.raises(RuntimeError, match=message):
            bpy.ops.object.adaptive_fairing(**options)


class TestResult:
    @pytest.mark.parametrize("method", ["uniform", "adaptive_timestep", "adaptive_tensor"])
    @pytest.mark.parametrize("density", ["edge_length", "area"])
    def test_every_key_is_the_step_of_the_core_to_the_last_bit_of_float32(self, method, density):
        vertices, faces = graded_sphere(2)
        obj = add_object(vertices, faces)
        obj.select_set(True)
        options = {"method": method, "density": density, "tau": 0.01, "steps": 3}
        expected = core_result(obj, **options)
        before = read_positions(obj.data)
        assert run(**options) == {"FINISHED"}
        assert np.array_equal(read_positions(obj.data), before)
        for step in expected.steps:
            found = key_positions(obj, f"Fairing {step.index}")
            assert np.array_equal(found, step.positions.astype(np.float32))

    def test_evolution_shows_the_last_step(self):
        obj = noisy_sphere()
        run(steps=3)
        keys = obj.data.shape_keys
        assert not keys.use_relative
        assert keys.eval_time == keys.key_blocks["Fairing 3"].frame
        assert obj.adaptive_fairing.evolution == 1.0

    def test_relative_keys_show_the_last_step(self):
        obj = noisy_sphere()
        run(steps=2, output="RELATIVE_KEYS")
        keys = obj.data.shape_keys
        assert keys.use_relative
        assert [block.value for block in keys.key_blocks] == [0.0, 0.0, 1.0]

    def test_the_final_shape_leaves_no_keys(self):
        obj = noisy_sphere()
        expected = core_result(obj, steps=2)
        run(steps=2, output="FINAL_SHAPE")
        assert obj.data.shape_keys is None
        assert np.array_equal(read_positions(obj.data), expected.positions.astype(np.float32))

    def test_the_density_of_the_last_step_is_stored(self):
        obj = noisy_sphere()
        expected = core_result(obj, steps=2)
        run(steps=2)
        stored = numbers(obj.data, "fairing_density")
        assert np.array_equal(stored, expected.steps[-1].density.astype(np.float32))
        assert "fairing_density_color" in obj.data.color_attributes

    def test_the_record_holds_what_the_core_measured(self):
        obj = noisy_sphere()
        expected = core_result(obj, steps=3)
        run(steps=3)
        record = obj.adaptive_fairing
        energies = [shape.curvature_energy for shape in record.shapes]
        measured = [expected.initial, *expected.steps]
        assert energies == [np.float32(each.curvature_energy) for each in measured]
        assert [shape.volume for shape in record.shapes] == [np.float32(m.volume) for m in measured]
        moved = np.linalg.norm(expected.positions - read_positions(obj.data), axis=1).max()
        assert record.shapes[-1].displacement == pytest.approx(moved, rel=1e-5)
        assert record.stop_reason == "steps"
        assert record.seconds > 0

    def test_a_stopping_rule_ends_the_run_early(self):
        obj = noisy_sphere()
        threshold = core_result(obj, steps=2).steps[-1].curvature_ratio + 1e-4
        run(steps=9, stop_curvature=threshold)
        assert obj.adaptive_fairing.stop_reason == "curvature"
        assert obj.data.shape_keys.key_blocks.keys() == ["Basis", "Fairing 1", "Fairing 2"]

    def test_it_is_one_undo_step_with_a_redo_panel(self):
        options = bpy.types.OBJECT_OT_adaptive_fairing.bl_options
        assert options == {"REGISTER", "UNDO"}

    def test_faces_that_share_an_edge_three_times_are_noted(self):
        vertices, faces = icosphere(1)
        apex = len(vertices)
        flap = [[*faces[0][:2], apex]]
        obj = add_object(np.concatenate([vertices, [[2.0, 2, 2]]]), [*faces.tolist(), *flap])
        obj.select_set(True)
        run(steps=1)
        assert "more than two triangles" in obj.adaptive_fairing.notes


class TestSeveralObjects:
    def test_all_selected_meshes_are_faired(self):
        objects = [noisy_sphere(name=f"Ball {seed}", seed=seed) for seed in (1, 2)]
        expected = [core_result(obj, steps=1).positions.astype(np.float32) for obj in objects]
        run(steps=1)
        for obj, positions in zip(objects, expected, strict=True):
            assert np.array_equal(key_positions(obj, "Fairing 1"), positions)

    def test_one_that_cannot_be_faired_does_not_keep_the_others_from_it(self):
        empty = add_object([[0, 0, 0], [1, 0, 0]], [], name="Wire")
        empty.select_set(True)
        obj = noisy_sphere()
        assert run(steps=1) == {"FINISHED"}
        assert "Fairing 1" in obj.data.shape_keys.key_blocks
        assert empty.data.shape_keys is None

    def test_two_objects_with_one_mesh_get_a_mesh_each(self):
        first = noisy_sphere()
        second = bpy.data.objects.new("Second", first.data)
        bpy.context.scene.collection.objects.link(second)
        second.select_set(True)
        run(steps=1)
        assert first.data != second.data
        assert np.array_equal(key_positions(first, "Fairing 1"), key_positions(second, "Fairing 1"))


class TestShapeKeysOfTheUser:
    def with_keys(self):
        obj = noisy_sphere()
        obj.shape_key_add(name="Basis", from_mix=False)
        smile = obj.shape_key_add(name="Smile", from_mix=False)
        smile.data[0].co.x += 1.0
        return obj

    def test_the_result_goes_to_a_copy(self):
        obj = self.with_keys()
        before = key_positions(obj, "Smile")
        run(steps=1)
        assert obj.data.shape_keys.key_blocks.keys() == ["Basis", "Smile"]
        assert np.array_equal(key_positions(obj, "Smile"), before)
        copy = bpy.data.objects[f"{obj.name} faired"]
        assert copy.data.shape_keys.key_blocks.keys() == ["Basis", "Fairing 1"]
        assert bpy.context.view_layer.objects.active == copy
        assert copy.select_get()

    def test_or_the_operator_refuses(self):
        obj = self.with_keys()
        with pytest.raises(RuntimeError, match=r"Thing: has shape keys of its own.*copy"):
            run(steps=1, existing_keys="REFUSE")
        assert obj.data.shape_keys.key_blocks.keys() == ["Basis", "Smile"]
        assert len(bpy.data.objects) == 1


class TestErrors:
    """Each says in one line what is wrong and what to do."""

    def test_nothing_selected(self):
        with pytest.raises(RuntimeError, match="Select a mesh object"):
            run()

    def test_no_mesh_selected(self):
        light = bpy.data.objects.new("Light", bpy.data.lights.new("Light", "POINT"))
        bpy.context.scene.collection.objects.link(light)
        light.select_set(True)
        with pytest.raises(RuntimeError, match="Select a mesh object"):
            run()

    def test_another_mode(self):
        noisy_sphere()
        bpy.ops.object.mode_set(mode="VERTEX_PAINT")
        with pytest.raises(RuntimeError, match="Change to Object Mode, Edit Mode or Sculpt Mode"):
            run()

    def test_no_time(self):
        obj = noisy_sphere()
        with pytest.raises(RuntimeError, match="tau must be a number greater than"):
            run(tau=0.0)
        assert obj.data.shape_keys is None

    def test_no_faces(self):
        add_object([[0, 0, 0], [1, 0, 0]], []).select_set(True)
        with pytest.raises(RuntimeError, match="Thing: the mesh has no triangles"):
            run()

    def test_coordinates_that_are_no_numbers(self):
        obj = noisy_sphere()
        obj.data.vertices[7].co.x = float("nan")
        with pytest.raises(RuntimeError, match=r"Thing: 1 vertices .* not finite numbers: 7"):
            run()
        assert obj.data.shape_keys is None

    def test_a_solver_that_does_not_converge(self):
        obj = noisy_sphere()
        with pytest.raises(RuntimeError, match=r"step 1 did not converge.*smaller"):
            run(cg_max_iterations=1, cg_tolerance=1e-12)
        assert obj.data.shape_keys is None

    def test_no_such_vertex_group(self):
        noisy_sphere()
        with pytest.raises(RuntimeError, match="Thing: there is no vertex group 'Ears'"):
            run(vertex_group="Ears")

    def test_scipy_is_missing(self, monkeypatch):
        from adaptive_fairing.blender.operators import fair

        monkeypatch.setattr(fair, "scipy_problem", lambda: "scipy is missing: get it")
        noisy_sphere()
        with pytest.raises(RuntimeError, match="scipy is missing: get it"):
            run()

    def test_a_run_is_going_on(self, monkeypatch):
        from adaptive_fairing.blender.operators import polls

        monkeypatch.setattr(polls, "progress", object)
        noisy_sphere()
        with pytest.raises(RuntimeError, match="A run is going on"):
            run()
