"""`denoise` in Blender: strengths as keys, what was found, progress, what is offered."""

import functools

import bpy
import numpy as np
import pytest
from support.layouts import draw
from support.meshes import icosphere, noisy_ball
from support.objects import add_object, key_positions

from adaptive_fairing.blender.data.mesh_arrays import read_positions
from adaptive_fairing.blender.jobs.frame_sequence import run_frames
from adaptive_fairing.blender.jobs.solve import Solve, run_solves
from adaptive_fairing.blender.operators import modal_run
from adaptive_fairing.blender.ui import results_panel, sequence_panel, settings_panel
from adaptive_fairing.core import DenoiseSettings, FairingSettings, denoise

pytestmark = pytest.mark.usefixtures("addon")

FIELDS = ("vertices", "triangles", "settings")
STRENGTHS = [0.5, 0.75, 1.0, 1.5, 2.0]


@pytest.fixture
def noisy():
    obj = add_object(*noisy_ball(3, 0.02))
    obj.select_set(True)
    return obj


def run(**options):
    return bpy.ops.object.adaptive_fairing(**options)


@functools.cache
def expected(**options):
    """Result of the core for what `noisy` has."""
    vertices, faces = noisy_ball(3, 0.02)
    return denoise(np.float32(vertices), faces, DenoiseSettings(**options))


class TestResult:
    def test_every_key_is_a_strength_of_the_core_and_the_chosen_one_is_shown(self, noisy):
        result = expected()
        assert run() == {"FINISHED"}
        keys = noisy.data.shape_keys
        assert keys.key_blocks.keys() == ["Basis", *(f"Fairing {i}" for i in range(1, 6))]
        for number, shape in enumerate(result.shapes, start=1):
            found = key_positions(noisy, f"Fairing {number}")
            assert np.array_equal(found, shape.astype(np.float32))
        assert not keys.use_relative
        assert keys.eval_time == keys.key_blocks["Fairing 3"].frame
        assert noisy.active_shape_key.name == "Fairing 3"

    def test_of_relative_keys_only_the_chosen_one_is_on(self, noisy):
        run(output="RELATIVE_KEYS")
        on = [key.name for key in noisy.data.shape_keys.key_blocks if key.value]
        assert on == ["Fairing 3"]

    def test_without_keys_the_object_gets_the_chosen_strength(self, noisy):
        result = expected()
        run(output="FINAL_SHAPE")
        assert np.array_equal(read_positions(noisy.data), result.positions.astype(np.float32))

    @pytest.mark.parametrize("features", ["sharp", "smooth"])
    def test_strength_and_edges_reach_the_core(self, noisy, features):
        result = expected(strength=1.7, features=features)
        run(strength=1.7, features=features, output="FINAL_SHAPE")
        assert np.array_equal(read_positions(noisy.data), result.positions.astype(np.float32))
        assert noisy.adaptive_fairing.is_sharp == (features == "sharp")

    def test_the_record_has_what_was_found(self, noisy):
        result = expected()
        run()
        record = noisy.adaptive_fairing
        assert result.noise_level > 0.05
        found = (record.noise, record.noise_length, record.radius)
        assert found == pytest.approx(
            (result.noise_level, result.noise_length, result.radius), rel=1e-6
        )
        assert record.shown == 3
        assert [shape.strength for shape in record.shapes] == [0.0, *STRENGTHS]

    def test_a_clean_mesh_stays_as_it_is_and_that_is_said(self):
        obj = add_object(*icosphere(3))
        obj.select_set(True)
        run()
        assert np.array_equal(key_positions(obj, "Fairing 5"), key_positions(obj, "Basis"))
        assert "no noise found" in obj.adaptive_fairing.notes
        drawn = draw(results_panel.VIEW3D_PT_adaptive_fairing_results)
        assert "no noise found" in " ".join(drawn.texts)

    def test_the_comparison_has_an_automatic_copy(self, noisy):
        result = expected()
        bpy.ops.object.adaptive_fairing_compare()
        copy = bpy.data.objects["Thing automatic"]
        found = key_positions(copy, "Fairing 3")
        assert np.array_equal(found, result.positions.astype(np.float32))
        uniform = bpy.data.objects["Thing uniform"].adaptive_fairing
        assert (uniform.method, len(uniform.shapes) - 1) == ("uniform", 4)
        labels = [each.data.body for each in bpy.data.objects if each.type == "FONT"]
        assert any(f"Noise {result.noise_level:.2g}" in label for label in labels)

    def test_frames_get_the_chosen_strength(self, noisy):
        result = expected()
        bpy.ops.object.adaptive_fairing_sequence(frame_start=1, frame_end=2)
        found = key_positions(bpy.context.object, "Frame 1")
        assert np.abs(found - result.positions).max() < 1e-6


class TestPanel:
    def test_it_asks_for_strength_and_edges_and_for_nothing_that_is_not_used(self, noisy):
        bpy.context.scene.adaptive_fairing.method = "auto"
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        assert drawn.properties == ["method", "strength", "features"]
        assert draw(settings_panel.VIEW3D_PT_adaptive_fairing_density) is None

    def test_the_other_methods_do_not_ask_for_them(self, noisy):
        bpy.context.scene.adaptive_fairing.method = "uniform"
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        assert not {"strength", "features"} & set(drawn.properties)
        assert draw(settings_panel.VIEW3D_PT_adaptive_fairing_density) is not None

    def test_it_marks_the_chosen_strength_and_tells_what_was_found(self, noisy):
        noisy.scale = (2.0, 2.0, 2.0)
        bpy.context.view_layer.update()
        bpy.context.scene.unit_settings.system = "METRIC"
        run(strength=2.0, features="sharp")
        record = noisy.adaptive_fairing
        texts = draw(results_panel.VIEW3D_PT_adaptive_fairing_results).texts
        assert "3 of 5, strength 2" in texts

        def in_scene(length):
            return f"{float(f'{2 * 100 * length:.3g}'):g} cm"

        assert f"{record.noise:.3g} edges  ·  {in_scene(record.noise_length)}" in texts
        assert f"{record.radius:.2f} edges" in texts
        assert "Sharp" in texts
        assert f"After  {record.shapes[3].curvature_energy:.4g}" in texts
        assert in_scene(record.shapes[3].displacement) in texts
        assert not any("τ" in text for text in texts)

    def test_the_slider_tells_the_strength_and_marks_the_chosen_one(self, noisy):
        run()
        for evolution, strength in ((0, 0), (0.1, 0.25), (0.2, 0.5), (0.6, 1), (0.7, 1.25), (1, 2)):
            noisy.adaptive_fairing.evolution = evolution
            drawn = draw(results_panel.VIEW3D_PT_adaptive_fairing_results)
            text = f"Strength {strength:.2f}"
            assert text in drawn.texts
            assert drawn.marked == ([text] if strength == 1 else [])

    def test_a_record_of_the_papers_methods_has_no_estimate(self, noisy):
        run()
        bpy.ops.object.adaptive_fairing(method="uniform", steps=2, tau=0.001)
        texts = draw(results_panel.VIEW3D_PT_adaptive_fairing_results).texts
        assert "Noise found" not in texts
        assert "Step 2.0 of 2" in texts


class TestRun:
    class Recording(Solve):
        """Keeps what it is told, and is cancelled at a part of the work."""

        until = 2.0

        def note_progress(self, part):
            self.parts = [*getattr(self, "parts", []), part]
            self.is_cancelled = part >= self.until
            super().note_progress(part)

    @pytest.fixture
    def solve(self):
        return self.Recording(*noisy_ball(3, 0.02), DenoiseSettings())

    def test_it_tells_its_progress_and_comes_in_one_piece(self, solve):
        assert len(list(run_solves([solve]))) == 1
        assert len(solve.parts) > 20
        assert solve.progress == 1.0
        assert solve.denoised.strengths.tolist() == STRENGTHS

    def test_cancelling_ends_it_in_the_middle_without_a_result(self, solve):
        solve.until = 0.3
        other = Solve(solve.vertices, solve.triangles, solve.settings)
        assert list(run_solves([solve, other])) == []
        assert 0.3 <= solve.progress < 0.5
        assert not (solve.has_result or solve.error or other.has_result)

    def test_cancelling_a_sequence_ends_it_and_starts_no_other_frame(self, solve):
        frames = [self.Recording(*(getattr(solve, name) for name in FIELDS)) for _ in range(3)]
        for frame in frames[1:]:
            frame.until = 0.3
        list(run_frames(frames, one_strength=False))
        assert [frame.has_result for frame in frames] == [True, False, False]
        assert not hasattr(frames[2], "parts")

    def test_cancelling_leaves_the_papers_methods_their_finished_step(self, solve):
        solve.settings, solve.until = FairingSettings(steps=2), 0.0
        next(run_solves([solve]))
        assert len(solve.steps) == 1

    def test_bar_and_text_follow_the_progress(self, solve):
        class Worker:
            is_stopping = False

            def stop(self):
                self.is_stopping = True

            def join(self, timeout):
                pass

        current = modal_run.Progress([solve], Worker())
        modal_run._progress[:] = [current]
        try:
            solve.progress = 0.45
            drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
            assert drawn.progress == [(0.45, "Removing noise: 45 %")]
            draw(sequence_panel.VIEW3D_PT_adaptive_fairing_sequence)
            modal_run.stop_run()
            assert solve.is_cancelled
        finally:
            modal_run.forget_run()


def test_numbers_in_files_keep_their_meaning():
    items = bpy.context.scene.adaptive_fairing.bl_rna.properties["method"].enum_items
    assert {item.identifier: item.value for item in items} == {
        "adaptive_timestep": 0,
        "adaptive_tensor": 1,
        "uniform": 2,
        "auto": 3,
    }
