"""`denoise` in Blender: strengths as keys, what was found, progress, what is offered."""

import functools

import bpy
import numpy as np
import pytest
from support.layouts import draw
from support.meshes import noisy_ball
from support.objects import key_positions
from support.results import run

from adaptive_fairing.blender.data.mesh_arrays import read_positions
from adaptive_fairing.blender.jobs.frame_sequence import run_frames
from adaptive_fairing.blender.jobs.solve import Solve, run_solves
from adaptive_fairing.blender.operators import modal_run
from adaptive_fairing.blender.operators.questions import hints
from adaptive_fairing.blender.ui import finished_run_panels, sequence_panel, settings_panel
from adaptive_fairing.core import DenoiseProgress, DenoiseSettings, FairingSettings, denoise

pytestmark = pytest.mark.usefixtures("addon")

FIELDS = ("vertices", "triangles", "settings")
STRENGTHS = [0.5, 0.75, 1.0, 1.5, 2.0]


@functools.cache
def expected(**options):
    """Result of the core for what `noisy` has."""
    vertices, faces = noisy_ball(3, 0.02)
    return denoise(np.float32(vertices), faces, DenoiseSettings(**options))


class TestResult:
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

    @pytest.mark.parametrize("features", ["sharp", "smooth"])
    def test_how_it_was_treated_is_recorded(self, noisy, features):
        run(features=features)
        assert noisy.adaptive_fairing.is_sharp == (features == "sharp")

    def test_the_comparison_has_a_denoised_copy(self, noisy):
        result = expected()
        bpy.ops.object.adaptive_fairing_compare()
        copy = bpy.data.objects["Thing denoised"]
        assert np.abs(read_positions(copy.data) - result.positions).max() < 1e-6
        uniform = bpy.data.objects["Thing uniform"].adaptive_fairing
        assert len(uniform.shapes) - 1 == 4
        labels = [each.data.body for each in bpy.data.objects if each.type == "FONT"]
        assert any(f"Noise {result.noise_level:.2g}" in label for label in labels)

    def test_frames_get_the_chosen_strength(self, noisy):
        result = expected()
        bpy.ops.object.adaptive_fairing_sequence(frame_start=1, frame_end=2)
        found = key_positions(bpy.context.object, "Frame 1")
        assert np.abs(found - result.positions).max() < 1e-6


class TestPanel:
    def test_it_asks_for_the_strength_and_for_nothing_that_is_not_used(self, noisy):
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        assert drawn.properties == ["algorithm", "strength", "width"]
        assert draw(settings_panel.VIEW3D_PT_adaptive_fairing_advanced) is None
        options = draw(settings_panel.VIEW3D_PT_adaptive_fairing_options)
        assert {"features", "boundary", "result"} <= set(options.properties)

    def test_for_diffusion_the_radius_comes_first(self, noisy):
        bpy.context.scene.adaptive_fairing.algorithm = "FAIR"
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        assert drawn.properties == [
            "algorithm",
            "scheme",
            "radius",
            "use_tau",
            "steps",
            "keep_volume",
        ]
        bpy.context.scene.adaptive_fairing.use_tau = True
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        assert drawn.properties[2:4] == ["tau", "use_tau"]

    def test_the_result_is_one_line_a_slider_and_the_buttons(self, noisy):
        noisy.scale = (2.0, 2.0, 2.0)
        bpy.context.view_layer.update()
        bpy.context.scene.unit_settings.system = "METRIC"
        run()
        record = noisy.adaptive_fairing
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        assert drawn.properties == ["algorithm", "strength", "width"]
        noise = f"{float(f'{2 * 100 * record.noise_length:.3g}'):g} cm"
        first, last = record.shapes[0], record.shapes[record.shown]
        volume = 100 * (last.volume / first.volume - 1)
        parts = (
            f"Noise {noise}",
            f"smoothed {record.radius:.2g} edges",
            f"volume {volume:+.2f} %",
        )
        text = " ".join(drawn.texts).replace("\N{NO-BREAK SPACE}", " ")
        assert " ".join(parts) in text.replace(" · ", " ")
        record.strength = 0.0
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        assert any(text.endswith("+0.00\N{NO-BREAK SPACE}%") for text in drawn.texts)
        names = [each["name"].removeprefix("object.adaptive_fairing") for each in drawn.operators]
        assert names == ["", "_before", "_split", "_paint", "_surface", "_apply", "_discard"]

    def test_a_radius_of_hundreds_of_edges_is_not_shown(self, noisy):
        run()
        noisy.adaptive_fairing.radius = 371.3
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        assert "smoothed" not in " ".join(drawn.texts)

    def test_the_surface_that_is_shown(self, noisy):
        run()
        for surface, text in (("REFINED_2", "Refined 2"), ("CONTROL", "Control Mesh")):
            bpy.ops.object.adaptive_fairing_surface(surface=surface)
            drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
            (button,) = [each for each in drawn.operators if each["name"].endswith("_surface")]
            assert button["text"] == text

    @pytest.mark.parametrize("algorithm", ["DENOISE", "FAIR"])
    def test_in_edit_mode_its_slider_is_there_too(self, noisy, algorithm):
        run()
        bpy.context.scene.adaptive_fairing.algorithm = algorithm
        bpy.ops.object.mode_set(mode="EDIT")
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        assert drawn.properties.count("strength") == 1
        assert drawn.disabled == []

    def test_of_a_mesh_that_was_changed_the_slider_is_told_to_move_the_rest(self, noisy):
        run()
        noisy.data.vertices[0].co.x += 1.0
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        assert "The slider moves what was not touched" in " ".join(drawn.texts)
        assert "object.adaptive_fairing_forget" not in [each["name"] for each in drawn.operators]

    def test_a_result_that_is_lost_has_no_slider_and_can_be_forgotten(self, noisy):
        run()
        noisy.data.attributes.remove(noisy.data.attributes[".fairing_offset_1"])
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        assert "The next one starts from what is shown" in " ".join(drawn.texts)
        assert drawn.properties == ["algorithm", "strength", "width"]
        ends = [each["name"] for each in drawn.operators][-2:]
        assert ends == ["object.adaptive_fairing_forget", "object.adaptive_fairing_discard"]

    def test_statistics_of_denoise_and_of_the_paper(self, noisy):
        run()
        drawn = draw(finished_run_panels.VIEW3D_PT_adaptive_fairing_statistics)
        assert [text.split("   ")[0] for _, text in drawn.progress][1:] == [
            f"Strength {strength:.2f}" for strength in STRENGTHS
        ]
        assert f"{noisy.adaptive_fairing.radius:.2f} edges" in drawn.texts
        assert not any("τ" in text for text in drawn.texts)
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", scheme="UNIFORM", steps=2, tau=0.001)
        drawn = draw(finished_run_panels.VIEW3D_PT_adaptive_fairing_statistics)
        assert "Treated as" not in drawn.texts
        assert "2  ·  τ = 0.001" in drawn.texts

    def test_why_no_run_can_start_is_said_below_the_button(self, noisy):
        bpy.ops.object.mode_set(mode="VERTEX_PAINT")
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        assert "Change to Object Mode, Edit Mode or Sculpt Mode" in " ".join(drawn.texts)

    def test_what_is_changed_beyond_the_mesh_is_said_before(self, noisy):
        twin = bpy.data.objects.new("Twin", noisy.data)
        settings = bpy.context.scene.adaptive_fairing
        noisy.scale = (1.0, 1.0, 2.0)
        found = hints([noisy], settings)
        assert found == [
            "Other objects share this mesh: they keep the old one",
            "The scale is not uniform: apply it first",
        ]
        third = bpy.data.objects.new("Third", noisy.data)
        assert hints([noisy, twin], settings) == found, "each is said once"
        assert hints([noisy, twin, third], settings) == found[1:], "all have the same result"
        third.data = bpy.data.meshes.new("Another")
        twin.data = bpy.data.meshes.new("Other")
        noisy.modifiers.new("Bevel", "BEVEL")
        noisy.shape_key_add(name="Basis")
        noisy.shape_key_add(name="Smile")
        found = hints([noisy], settings)
        assert found[0] == "The result goes to a copy; this object is hidden"
        assert found[1].startswith("Modifiers stay above")
        settings.result = "MODIFIER"
        assert found[0] not in hints([noisy], settings)


class TestRun:
    class Recording(Solve):
        """Keeps what it is told, and is cancelled at a part of the work."""

        until = 2.0

        def note_progress(self, progress):
            self.parts = [*getattr(self, "parts", []), progress.fraction_done]
            self.is_cancelled = progress.fraction_done >= self.until
            super().note_progress(progress)

    @pytest.fixture
    def solve(self):
        return self.Recording(*noisy_ball(3, 0.02), DenoiseSettings())

    def test_it_tells_its_progress_and_comes_in_one_piece(self, solve):
        assert len(list(run_solves([solve]))) == 1
        assert len(solve.parts) > 20
        assert solve.progress.fraction_done == 1.0
        assert solve.denoised.strengths.tolist() == STRENGTHS

    def test_cancelling_ends_it_in_the_middle_without_a_result(self, solve):
        solve.until = 0.3
        other = Solve(solve.vertices, solve.triangles, solve.settings)
        assert list(run_solves([solve, other])) == []
        assert 0.3 <= solve.progress.fraction_done < 0.5
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

    @pytest.fixture
    def current(self, solve, monkeypatch):
        class Worker:
            is_stopping = False

            def stop(self):
                self.is_stopping = True

            def join(self, timeout):
                pass

        monkeypatch.setattr(modal_run.time, "perf_counter", lambda: self.now)
        self.now = 100.0
        current = modal_run.Progress([solve], Worker(), last_news=self.now)
        modal_run._progress[:] = [current]
        yield current
        modal_run.forget_run()

    @staticmethod
    def bar():
        ((factor, text),) = draw(settings_panel.VIEW3D_PT_adaptive_fairing).progress
        return factor, text

    def test_the_bar_moves_within_the_first_second_and_on_in_every_phase(self, solve, current):
        assert self.bar() == (0.0, "Measuring the noise")
        solve.progress = DenoiseProgress("noise", fraction_done=0.0, fraction_at_end=0.25)
        self.bar()
        self.now += 1
        first, _ = self.bar()
        assert 0.01 < first < 0.25
        solve.progress = DenoiseProgress("filter", 3, 5, fraction_done=0.5, fraction_at_end=0.75)
        self.now += 1
        assert self.bar() == (0.5, "Filtering 3 of 5, 2 s left")
        self.now += 1  # half of what this phase takes if it is as fast as those before it
        factor, text = self.bar()
        assert 0.6 < factor < 0.75
        assert text == f"Filtering 3 of 5, {3 * (1 - factor) / factor:.0f} s left"
        self.now += 1000
        assert 0.7 < self.bar()[0] <= 0.75
        for phase, name in (("mix", "Mixing the filters"), ("measure", "Measuring the result")):
            solve.progress = DenoiseProgress(phase, fraction_done=0.9, fraction_at_end=1.0)
            assert self.bar()[1].startswith(name)

    def test_a_busy_machine_may_ask_late_for_the_first_time(self, current):
        self.now += 5
        assert self.bar() == (0.0, "Measuring the noise")

    def test_the_other_panel_shows_it_too_and_a_stop_reaches_the_solve(self, solve, current):
        draw(sequence_panel.VIEW3D_PT_adaptive_fairing_sequence)
        modal_run.stop_run()
        assert solve.is_cancelled


@pytest.mark.parametrize("algorithm", ["DENOISE", "FAIR"])
def test_who_waits_for_a_run_sees_its_progress_at_the_pointer(noisy, monkeypatch, algorithm):
    """In the redo panel, which blocks the window."""
    parts = []
    factor = modal_run.Progress.factor.fget
    watched = property(lambda progress: parts.append(factor(progress)) or parts[-1])
    monkeypatch.setattr(modal_run.Progress, "factor", watched)
    run(algorithm=algorithm)
    assert parts == sorted(parts)
    assert len(parts) >= 4
    assert parts[-1] == 1.0
