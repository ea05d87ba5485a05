"""The operator that fairs: its result is the core's, its errors say what to do."""

from dataclasses import fields

import bpy
import numpy as np
import pytest
from support.meshes import graded_sphere, icosphere
from support.objects import add_object, key_positions, numbers

from adaptive_fairing.blender.data.display import display_of
from adaptive_fairing.blender.data.mesh_arrays import read_mesh, read_positions
from adaptive_fairing.blender.jobs.solve import run_solves
from adaptive_fairing.blender.operators.modal_run import ModalRun
from adaptive_fairing.blender.properties import (
    DENOISE_NAMES,
    FAIRING_NAMES,
    SOLVER_NAMES,
    fairing_settings,
    solver_settings,
)
from adaptive_fairing.cli.arguments import parse, settings_of
from adaptive_fairing.core import DenoiseSettings, FairingSettings, fair
from adaptive_fairing.core.diffusion.settings import DENSITIES, SCHEMES

pytestmark = pytest.mark.usefixtures("addon")


def run(**options):
    """Run the paper on the selected objects."""
    return bpy.ops.object.adaptive_fairing(**{"algorithm": "FAIR", **options})


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
        words = {"scheme": "method"}
        of_fair = [words.get(name, name) for name in FAIRING_NAMES if name != "use_tau"]
        assert sorted(of_fair) == sorted(FairingSettings.names())
        of_denoise = {field.name for field in fields(DenoiseSettings)}
        assert set(DENOISE_NAMES) == of_denoise
        assert set(SOLVER_NAMES) == {"algorithm", *of_denoise, *FAIRING_NAMES}

    @pytest.mark.parametrize(("name", "words"), [("scheme", SCHEMES), ("density", DENSITIES)])
    def test_the_words_are_the_cores_in_capitals(self, name, words):
        items = bpy.context.scene.adaptive_fairing.bl_rna.properties[name].enum_items
        assert items.keys() == [word.upper() for word in words]

    def test_panel_command_line_and_python_start_with_denoise(self):
        assert solver_settings(bpy.context.scene.adaptive_fairing) == DenoiseSettings()
        assert settings_of(parse(["denoise", "in.ply"])) == DenoiseSettings()

    def test_the_papers_defaults_are_the_cores(self):
        bpy.context.scene.adaptive_fairing.algorithm = "FAIR"
        assert solver_settings(bpy.context.scene.adaptive_fairing) == FairingSettings()
        assert settings_of(parse(["fair", "in.ply"])) == FairingSettings()

    def test_numbers_come_through_as_they_were_typed(self):
        settings = bpy.context.scene.adaptive_fairing
        settings.algorithm, settings.use_tau = "FAIR", True
        settings.tau, settings.cg_tolerance, settings.stop_rate = 0.0107, 3e-8, 0.7
        made = solver_settings(settings)
        assert (made.tau, made.cg_tolerance, made.stop_rate) == (0.0107, 3e-8, 0.7)

    def test_zero_turns_a_stopping_rule_and_a_limit_off(self):
        made = fairing_settings(bpy.context.scene.adaptive_fairing)
        assert made.stop_curvature is None
        assert made.stop_rate is None
        assert made.max_deviation is None

    @pytest.mark.parametrize(
        ("frame", "expected"), [("BOX", "box"), ("SPHERE", "sphere"), ("NONE", False)]
    )
    def test_the_frame(self, frame, expected):
        bpy.context.scene.adaptive_fairing.normalize = frame
        assert fairing_settings(bpy.context.scene.adaptive_fairing).normalize == expected

    def test_tau_counts_where_it_is_chosen_or_is_all_that_a_script_gives(self):
        obj = noisy_sphere()
        settings = bpy.context.scene.adaptive_fairing
        settings.tau = 0.02
        assert fairing_settings(settings).tau is None
        settings.use_tau = True
        assert fairing_settings(settings).tau == 0.02
        for options, is_tau in (({}, True), ({"use_tau": False}, False), ({"use_tau": True}, True)):
            run(steps=1, tau=0.02, radius=0.3, **options)
            assert (obj.adaptive_fairing.tau == np.float32(0.02)) == is_tau
            bpy.ops.object.adaptive_fairing_discard()

    @pytest.mark.parametrize(
        ("options", "message"),
        [
            ({"steps": 4}, "steps belongs to algorithm='FAIR', not to 'DENOISE'"),
            ({"scheme": "UNIFORM"}, "scheme belongs to algorithm='FAIR', not to 'DENOISE'"),
            (
                {"algorithm": "FAIR", "strength": 2.0},
                "strength belongs to algorithm='DENOISE', not to 'FAIR'",
            ),
        ],
    )
    def test_a_script_cannot_mix_the_two_algorithms(self, options, message):
        noisy_sphere()
        with pytest.raises(RuntimeError, match=message):
            bpy.ops.object.adaptive_fairing(**options)


class TestResult:
    @pytest.mark.parametrize("scheme", SCHEMES)
    @pytest.mark.parametrize("density", DENSITIES)
    def test_every_key_is_the_step_of_the_core_to_the_last_bit_of_float32(self, scheme, density):
        vertices, faces = graded_sphere(2)
        obj = add_object(vertices, faces)
        obj.select_set(True)
        words = {"method": SCHEMES[scheme], "density": DENSITIES[density]}
        expected = core_result(obj, **words, tau=0.01, steps=3)
        before = read_positions(obj.data)
        words = {"scheme": scheme.upper(), "density": density.upper()}
        assert run(**words, tau=0.01, steps=3) == {"FINISHED"}
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
        threshold = core_result(obj, steps=2, tau=0.016).steps[-1].curvature_ratio + 1e-4
        run(steps=9, tau=0.016, stop_curvature=threshold)
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

    def test_two_objects_with_one_mesh_get_one_result(self):
        first = noisy_sphere()
        second = bpy.data.objects.new("Second", first.data)
        bpy.context.scene.collection.objects.link(second)
        second.select_set(True)
        run(steps=1)
        assert first.data == second.data
        assert first.data.shape_keys.key_blocks.keys() == ["Basis", "Fairing 1"]
        assert second.active_shape_key_index == 1


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


class TestDeletedDuringTheRun:
    """Objects that are gone when their result arrives, or whose creation was undone."""

    @pytest.fixture
    def delete_meanwhile(self, monkeypatch):
        def delete(doomed):
            def steps(_operator, solves):
                yield from run_solves(solves)
                bpy.data.objects.remove(doomed)

            monkeypatch.setattr(ModalRun, "_generator", steps)

        return delete

    @pytest.mark.parametrize("algorithm", ["DENOISE", "FAIR"])
    def test_the_others_keep_their_results(self, delete_meanwhile, algorithm, capfd):
        first, second, third = (noisy_sphere(3, name=f"Ball {i}", seed=i) for i in (1, 2, 3))
        delete_meanwhile(second)
        assert bpy.ops.object.adaptive_fairing(algorithm=algorithm) == {"FINISHED"}
        assert all(each.adaptive_fairing.result for each in (first, third))
        said = capfd.readouterr().out
        assert "Ball 2: the object was deleted during the run" in said
        assert f" {2 * len(first.data.vertices)} vertices" in said

    @pytest.mark.parametrize("algorithm", ["DENOISE", "FAIR"])
    def test_alone_it_is_an_error_in_one_line(self, delete_meanwhile, algorithm):
        delete_meanwhile(noisy_sphere())
        with pytest.raises(RuntimeError, match="Thing: the object was deleted during the run"):
            bpy.ops.object.adaptive_fairing(algorithm=algorithm)


@pytest.mark.parametrize("algorithm", ["DENOISE", "FAIR"])
def test_the_vertices_that_may_move_are_counted(algorithm, capfd):
    obj = noisy_sphere(3)
    obj.vertex_groups.new(name="Part").add(range(100), 0.5, "REPLACE")
    bpy.ops.object.adaptive_fairing(algorithm=algorithm, vertex_group="Part")
    assert "d 100 vertices" in capfd.readouterr().out


@pytest.mark.parametrize("algorithm", ["FAIR", "DENOISE"])
def test_no_vertex_moves_further_than_it_may_in_the_world(algorithm):
    obj = noisy_sphere(3)
    before = read_positions(obj.data)
    obj.scale = (0.1, 0.1, 0.1)
    bpy.context.view_layer.update()

    def largest_move():
        shown = display_of(obj).shown()
        return 0.1 * np.linalg.norm(shown - before, axis=1).max()

    bpy.ops.object.adaptive_fairing(algorithm=algorithm)
    free = largest_move()
    bpy.ops.object.adaptive_fairing_discard()
    bpy.ops.object.adaptive_fairing(algorithm=algorithm, max_deviation=free / 2)
    assert largest_move() == pytest.approx(free / 2, rel=1e-4)


def test_the_volume_is_kept_on_request():
    obj = noisy_sphere()
    triangles = read_mesh(obj.data).triangles

    def volume():
        a, b, c = np.moveaxis(display_of(obj).shown().astype(float)[triangles], 1, 0)
        return np.einsum("fi,fi->", a, np.cross(b, c)) / 6

    before, changes = volume(), []
    for keep_volume in (False, True):
        run(radius=2.0, keep_volume=keep_volume)
        changes.append(abs(volume() / before - 1))
        bpy.ops.object.adaptive_fairing_discard()
    assert changes[0] > 1e-3
    assert changes[1] < 1e-6
