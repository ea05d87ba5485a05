"""The panels: what they offer before, during and after a run, and when something is missing."""

import math

import bpy
import numpy as np
import pytest
from support.layouts import PANELS, FakeContext, FakeLayout, draw
from support.meshes import graded_sphere, icosphere, open_cylinder
from support.objects import add_object

from adaptive_fairing.blender.jobs.solve import Solve, run_solves
from adaptive_fairing.blender.operators import mesh_scale, modal_run, settings_layout
from adaptive_fairing.blender.properties import DENOISE_NAMES, FAIRING_NAMES, OUTPUT_NAMES
from adaptive_fairing.blender.ui import (
    finished_run_panels,
    sequence_panel,
    settings_panel,
)
from adaptive_fairing.core import FairingSettings

pytestmark = pytest.mark.usefixtures("addon")


@pytest.fixture
def sphere():
    vertices, faces = graded_sphere(2)
    obj = add_object(vertices, faces)
    obj.select_set(True)
    return obj


def button(drawn, name):
    """Find the one button for an operator."""
    (found,) = [each for each in drawn.operators if each["name"] == name]
    return found


@pytest.mark.parametrize("panel", PANELS, ids=lambda panel: panel.__name__)
class TestEveryPanel:
    def test_it_is_in_the_tab(self, panel):
        assert (panel.bl_space_type, panel.bl_region_type) == ("VIEW_3D", "UI")
        assert panel.bl_category == "Fairing"

    def test_it_can_be_drawn_with_nothing_selected(self, panel):
        draw(panel)

    def test_it_can_be_drawn_with_a_light(self, panel):
        light = bpy.data.objects.new("Light", bpy.data.lights.new("Light", "POINT"))
        bpy.context.scene.collection.objects.link(light)
        bpy.context.view_layer.objects.active = light
        draw(panel)

    @pytest.mark.parametrize("output", ["ABSOLUTE_KEYS", "RELATIVE_KEYS", "FINAL_SHAPE"])
    def test_it_can_be_drawn_after_a_run(self, panel, sphere, output):
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=2, output=output)
        bpy.ops.object.adaptive_fairing_view(field="CURVATURE")
        bpy.context.scene.adaptive_fairing.algorithm = "FAIR"
        has_evolution = output == "ABSOLUTE_KEYS"
        assert (draw(panel) is not None) == (has_evolution or "animation" not in panel.__name__)

    @pytest.mark.parametrize("mode", ["EDIT", "SCULPT", "VERTEX_PAINT"])
    def test_it_can_be_drawn_in_other_modes(self, panel, sphere, mode):
        bpy.ops.object.mode_set(mode=mode)
        draw(panel)


def test_labels_fit_beside_their_fields():
    """Blender cuts longer ones in a sidebar of the usual width; check boxes have more room."""
    settings = bpy.context.scene.adaptive_fairing.bl_rna.properties
    fields = [each.name for each in settings if each.type != "BOOLEAN"]
    assert "Max Deviation" in fields
    assert [name for name in fields if len(name) > 15] == []


class TestBeforeTheRun:
    def test_the_button_has_the_settings_of_the_panel(self, sphere):
        settings = bpy.context.scene.adaptive_fairing
        settings.algorithm, settings.scheme = "FAIR", "TENSOR"
        settings.steps, settings.output = 7, "RELATIVE_KEYS"
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        fair = button(drawn, "object.adaptive_fairing")
        assert (fair["algorithm"], fair["scheme"], fair["steps"]) == ("FAIR", "TENSOR", 7)
        assert fair["output"] == "RELATIVE_KEYS"
        for name in (*FAIRING_NAMES, *OUTPUT_NAMES):
            assert fair[name] == getattr(settings, name)
        assert not {"strength", "features", "clean"} & set(fair)

    def test_the_button_counts_the_objects(self, sphere):
        add_object(*icosphere(1), name="Second").select_set(True)
        sphere.select_set(True)
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        assert button(drawn, "object.adaptive_fairing")["text"] == "Denoise 2 Objects"

    def test_apply_and_discard_count_the_objects_too(self, sphere):
        add_object(*graded_sphere(2), name="Second").select_set(True)
        sphere.select_set(True)
        ends = ("object.adaptive_fairing_apply", "object.adaptive_fairing_discard")
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=1)
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        texts = [button(drawn, name)["text"] for name in ends]
        assert texts == ["Apply 2 Objects", "Discard 2 Objects"]
        bpy.data.objects["Second"].select_set(False)
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        bpy.context.view_layer.objects.active = sphere
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        assert [button(drawn, name)["text"] for name in ends] == ["Apply", "Discard"]

    @pytest.mark.parametrize("is_shared", [False, True])
    def test_a_slider_of_one_mesh_needs_no_key_for_all_objects(self, sphere, is_shared):
        second = add_object(*graded_sphere(2), name="Second")
        second.select_set(True)
        sphere.select_set(True)
        if is_shared:
            second.data = sphere.data
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=1)
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        assert ("Hold Alt" in " ".join(drawn.texts)) != is_shared

    def test_no_result_is_shown(self, sphere):
        assert draw(finished_run_panels.VIEW3D_PT_adaptive_fairing_statistics) is None

    def test_the_radii_are_those_of_tau_and_the_steps(self, sphere):
        settings = bpy.context.scene.adaptive_fairing
        scale = mesh_scale.measure(sphere, settings)
        settings.algorithm = "FAIR"
        settings.use_tau = True
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing_advanced)
        radii = [*scale.radii(0.016), *scale.radii(4 * 0.016)]
        assert [f"{radius:.2f}" for radius in radii] == [
            text for text in drawn.texts if text[:1].isdigit()
        ]
        assert "τ = 0.016" in drawn.texts
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        assert f"Radius on this mesh: {radii[4]:.2f} edges" in drawn.texts
        settings.use_tau, settings.radius = False, 0.75
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        assert not any("Radius on" in text for text in drawn.texts)
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing_advanced)
        table = [text for text in drawn.texts if text[:1].isdigit()]
        assert [table[1], table[4]] == [f"{0.75 / 2:.2f}", "0.75"]

    def test_why_a_mesh_has_no_radius_is_shown(self):
        wire = add_object([[0, 0, 0], [1, 0, 0]], [])
        bpy.context.scene.adaptive_fairing.algorithm = "FAIR"
        mesh_scale.measure(wire, bpy.context.scene.adaptive_fairing)
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing_advanced)
        assert "the mesh has no triangles" in " ".join(drawn.texts)

    def test_scipy_missing_is_shown_with_what_to_do(self, sphere, monkeypatch):
        monkeypatch.setattr(settings_panel, "scipy_problem", lambda: "scipy is missing: get it")
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        assert "scipy is missing: get it" in " ".join(drawn.texts)


def test_the_button_for_frames_has_the_scenes_range_and_the_panels_settings(sphere):
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 11, 20
    scene.adaptive_fairing.algorithm, scene.adaptive_fairing.tau = "FAIR", 0.25
    scene.adaptive_fairing.same_strength = False
    drawn = draw(sequence_panel.VIEW3D_PT_adaptive_fairing_sequence)
    found = button(drawn, "object.adaptive_fairing_sequence")
    assert found["text"] == "Fair 10 Frames"
    scene.adaptive_fairing.algorithm = "DENOISE"
    drawn = draw(sequence_panel.VIEW3D_PT_adaptive_fairing_sequence)
    denoise = button(drawn, "object.adaptive_fairing_sequence")
    assert (denoise["text"], denoise["algorithm"]) == ("Denoise 10 Frames", "DENOISE")
    assert (found["frame_start"], found["frame_end"]) == (11, 20)
    assert found["tau"] == 0.25
    assert found["same_strength"] is False


class TestDuringTheRun:
    class StandingWorker:
        is_stopping = False

        def stop(self):
            self.is_stopping = True

        def join(self, timeout):
            pass

    @pytest.fixture
    def current(self, sphere):
        vertices, faces = icosphere(1)
        solve = Solve(vertices, faces, FairingSettings(steps=4), name="Thing")
        current = modal_run.Progress([solve], self.StandingWorker())
        modal_run._progress[:] = [current]
        yield current
        modal_run.forget_run()

    def test_it_starts_with_the_first_step(self, current):
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        assert drawn.progress == [(0.0, "Step 1 of 4")]
        assert not [each for each in drawn.operators if each["name"] == "object.adaptive_fairing"]

    def test_step_iterations_and_h_are_shown(self, current):
        steps = run_solves(current.solves)
        for _ in range(2):
            next(steps)
            current.step_done()
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        ((factor, text),) = drawn.progress
        assert text == "Step 3 of 4"
        assert 0.5 <= factor < 0.75
        last = current.solves[0].steps[-1]
        expected = (
            f"{last.solve.iterations} solver iterations  ·  H at {100 * last.curvature_ratio:.1f} %"
        )
        assert expected in drawn.texts

    def test_progress_never_leaves_its_range(self, current):
        for _ in run_solves(current.solves):
            current.step_done()
            assert 0.0 < current.factor <= 1.0
        assert current.factor == 1.0

    def test_within_a_step_progress_is_guessed_from_the_last_one(self, current):
        current.step_done()
        current.step_seconds = 1e9
        assert current.factor == pytest.approx(0.25, abs=1e-6)
        current.step_seconds = 1e-9
        assert current.factor == pytest.approx((1 + 0.95) / 4)

    def test_stop_asks_the_worker_and_says_so(self, current):
        assert bpy.ops.object.adaptive_fairing_stop() == {"FINISHED"}
        assert current.worker.is_stopping
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        assert button(drawn, "object.adaptive_fairing_stop")["text"] == "Stopping…"

    def test_the_panel_for_frames_offers_to_stop_in_place_of_its_button(self, current):
        drawn = draw(sequence_panel.VIEW3D_PT_adaptive_fairing_sequence)
        assert [each["name"] for each in drawn.operators] == ["object.adaptive_fairing_stop"]

    def test_a_second_run_is_refused(self, current):
        for run in (bpy.ops.object.adaptive_fairing, bpy.ops.object.adaptive_fairing_sequence):
            with pytest.raises(RuntimeError, match="A run is going on"):
                run()

    def test_several_objects_are_named(self, current):
        current.solves.append(current.solves[0])
        assert current.describe_step() == "Thing: Step 1 of 4"


class TestAfterTheRun:
    def test_stop_can_be_pressed_during_a_run_only(self):
        assert not bpy.ops.object.adaptive_fairing_stop.poll()

    def test_numbers_of_the_run(self, sphere):
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=3, tau=0.01)
        drawn = draw(finished_run_panels.VIEW3D_PT_adaptive_fairing_statistics)
        first, *_, last = sphere.adaptive_fairing.shapes
        text = "\n".join(drawn.texts)
        assert "3  ·  τ = 0.01" in text
        assert "All steps done" in text
        assert f"{100 * (last.volume / first.volume - 1):+.2f} %" in text
        shown = [text for _, text in drawn.progress]
        assert shown[0] == f"Before   {first.curvature_energy:.4g}"
        assert shown[-1].startswith(f"Step 3   {last.curvature_energy:.4g}   ")
        assert drawn.progress[0][0] == 1.0

    def test_below_an_evolution_are_play_density_and_h(self, sphere):
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=3)
        settings = bpy.context.scene.adaptive_fairing
        settings.frame_start, settings.frame_end = 7, 19
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        assert {"evolution", "show_energy"} <= set(drawn.properties)
        assert drawn.progress == []
        play = button(drawn, "object.adaptive_fairing_play")
        assert (play["frame_start"], play["frame_end"]) == (7, 19)
        assert button(drawn, "object.adaptive_fairing_view")["field"] == "DENSITY"
        bpy.ops.object.adaptive_fairing_view(field="DENSITY")
        settings.show_energy = True
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        assert button(drawn, "object.adaptive_fairing_view_end")["depress"]
        energies = [shape.curvature_energy for shape in sphere.adaptive_fairing.shapes]
        parts = [energy / max(energies) for energy in energies]
        assert [factor for factor, _ in drawn.progress] == parts

    @pytest.mark.parametrize(("system", "unit"), [("NONE", ""), ("METRIC", " m")])
    def test_the_largest_move_is_a_length_of_the_world(self, sphere, system, unit):
        bpy.context.scene.unit_settings.system = system
        sphere.scale = (1000.0, 1000.0, 1000.0)
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=1)
        bpy.context.view_layer.update()
        drawn = draw(finished_run_panels.VIEW3D_PT_adaptive_fairing_statistics)
        length = 1000.0 * sphere.adaptive_fairing.shapes[-1].displacement
        assert 1.0 < length < 1000.0
        assert f"{float(f'{length:.3g}'):g}{unit}" in drawn.texts

    def test_an_open_surface_has_no_volume(self):
        obj = add_object(*open_cylinder(12, 5))
        obj.select_set(True)
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=1)
        assert math.isnan(obj.adaptive_fairing.shapes[0].volume)
        assert "–" in draw(finished_run_panels.VIEW3D_PT_adaptive_fairing_statistics).texts

    def test_without_keys_there_is_no_slider(self, sphere):
        options = {"algorithm": "FAIR", "steps": 1, "output": "FINAL_SHAPE"}
        bpy.ops.object.adaptive_fairing(**options)
        assert "evolution" not in draw(settings_panel.VIEW3D_PT_adaptive_fairing).properties

    def test_what_was_done_to_the_mesh_is_told(self):
        vertices, faces = icosphere(1)
        vertices = np.concatenate([vertices, [[2.0, 2, 2]]])
        add_object(vertices, [*faces.tolist(), [*faces[0][:2], 42]]).select_set(True)
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=1)
        drawn = draw(finished_run_panels.VIEW3D_PT_adaptive_fairing_statistics)
        assert "more than two triangles" in " ".join(drawn.texts)


def test_the_redo_panel_offers_every_property_that_the_algorithm_uses(sphere):
    settings = bpy.context.scene.adaptive_fairing

    def offered(algorithm):
        settings.algorithm = algorithm
        layout = FakeLayout()
        settings_layout.draw_operator(layout, settings, sphere)
        assert len(layout.drawn.properties) == len(set(layout.drawn.properties))
        return set(layout.drawn.properties)

    of_fair = {*FAIRING_NAMES, *OUTPUT_NAMES} - {"result", "store_density"}
    assert offered("FAIR") == of_fair - {"tau"}
    assert offered("DENOISE") == {*DENOISE_NAMES, *OUTPUT_NAMES} - {"output"}
    settings.use_tau = True
    assert offered("FAIR") == of_fair - {"radius"}


def test_menus_run_with_the_settings_of_the_scene(sphere):
    from adaptive_fairing.blender.ui import menus

    class Stand:
        layout = FakeLayout()

    settings = bpy.context.scene.adaptive_fairing
    settings.steps = 9
    menus.draw_object_menu(Stand(), FakeContext())
    drawn = Stand.layout.drawn
    denoise, fair = [each for each in drawn.operators if each["name"] == "object.adaptive_fairing"]
    assert (denoise["algorithm"], fair["algorithm"], fair["steps"]) == ("DENOISE", "FAIR", 9)
    words = f"{denoise['text']} {fair['text']}".lower()
    assert all(word in words for word in ("noise", "smooth", "fair", "scan"))
    settings.algorithm = "FAIR"
    menus.draw_object_menu(Stand(), FakeContext())
    assert drawn.operators[-2]["name"] == "object.adaptive_fairing_compare"
    assert drawn.operators[-2]["steps"] == 9
