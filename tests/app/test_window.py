"""The extension in Blender's own window, operated by mouse and keyboard."""

from __future__ import annotations

import numpy as np
import pytest

pytestmark = pytest.mark.app

EVOLUTION = ["Basis", "Fairing 1", "Fairing 2", "Fairing 3", "Fairing 4"]
N_COLOURS_OF_AN_INTERFACE = 100  # a region that is blank or has only its background: below 10
FLOAT32_STEP = 2.0**-23  # of the coordinates, which are below 1 + noise


class TestFullRun:
    """Button, wait, Evolution slider, save, reopen."""

    @pytest.fixture
    def seen(self, app) -> dict:
        return app.play("full_run")

    def test_the_button_makes_one_absolute_key_per_step(self, seen):
        assert seen["keys"] == EVOLUTION

    def test_the_basis_is_the_mesh_as_it_was(self, seen):
        assert seen["basis kept"]

    def test_the_result_is_the_cores_to_float32(self, seen):
        assert seen["equal to core"]

    def test_the_evolution_slider_moves_the_shown_shape(self, seen):
        """Between two keys the shape is their mix, as it is at the ends."""
        assert seen["slider at the start"]["value"] == 0.0
        assert 0.1 < seen["slider dragged"]["value"] < 0.9
        assert seen["slider at the end"]["value"] == 1.0
        for place in ("at the start", "dragged", "at the end"):
            assert seen[f"slider {place}"]["error"] <= 4 * FLOAT32_STEP, place

    def test_a_saved_file_brings_every_key_back(self, seen):
        assert seen["same after reopening"] == dict.fromkeys(EVOLUTION, True)

    def test_the_pictures_show_the_interface(self, seen):
        for name, parts in seen["pictures"].items():
            for part, picture in parts.items():
                assert picture["colours"] > N_COLOURS_OF_AN_INTERFACE, f"{name}: {part} is blank"

    def test_the_window_shows_that_something_has_happened(self, seen):
        pictures = seen["pictures"]
        for earlier, later, part in (
            ("before", "after", "UI"),
            ("before", "after", "WINDOW"),
            ("slider-at-the-start", "slider-dragged", "WINDOW"),
            ("slider-dragged", "slider-at-the-end", "WINDOW"),
        ):
            assert pictures[earlier][part]["checksum"] != pictures[later][part]["checksum"]


def test_one_undo_takes_the_run_back_and_redo_brings_it_again(app):
    seen = app.play("undo")
    assert seen["after run"] == EVOLUTION
    assert seen["after undo"] == []
    assert seen["vertices back"]
    assert seen["after redo"] == EVOLUTION


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT", "SCULPT"])
def test_one_undo_restores_what_was_there_in_every_mode(app, mode):
    seen = app.play("undo_in_modes")[mode]
    assert seen["after run"]["moved"] > 0.0
    assert seen["after run"]["mode"] == mode
    mask = 0.5 if mode == "SCULPT" else None
    assert seen["after undo"] == {"mode": mode, "moved": 0.0, "mask": mask, "result": ""}


def test_escape_keeps_the_finished_steps_and_undo_removes_them(app):
    seen = app.play("escape")
    kept = len(seen["after escape"]) - 1
    assert 1 <= kept < seen["steps asked for"]
    assert seen["after escape"] == ["Basis", *(f"Fairing {i}" for i in range(1, kept + 1))]
    assert seen["after undo"] == []


def test_progress_is_shown_during_the_run(app):
    """The panel and the status bar change while nobody touches them."""
    pictures = app.play("escape")["pictures"]
    assert pictures["running"]["UI"]["checksum"] != pictures["running-later"]["UI"]["checksum"]
    assert pictures["running"]["UI"]["colours"] > N_COLOURS_OF_AN_INTERFACE


def test_in_edit_mode_the_slider_moves_the_selection_and_is_undone_by_itself(app):
    seen = app.play("edit_slider")
    assert seen["moved"] > seen["moved at half"] > seen["moved when dragged"] > 0.0
    assert seen["undone to half"] == seen["moved at half"]
    assert seen["undone to whole"] == seen["moved"]
    assert (seen["strength"], seen["mode"], seen["mode after"]) == (1.0, "EDIT", "EDIT")


class TestAutomatic:
    """The method without parameters."""

    @pytest.fixture
    def seen(self, app) -> dict:
        return app.play("automatic")

    def test_escape_ends_the_run_at_once_without_a_result(self, seen):
        assert seen["running before escape"]
        assert seen["unchanged after escape"]

    def test_the_slider_is_the_mesh(self, seen):
        assert seen["moved"] > seen["moved at half"] > 0.0
        assert seen["slider back"]

    def test_a_held_key_shows_the_original(self, seen):
        assert seen["held"]
        assert seen["released"]

    def test_the_split_shows_half_of_the_original(self, seen):
        assert 0.3 < seen["original in the split"] < 0.7

    def test_the_colours_are_the_active_ones_until_the_result_is_discarded(self, seen):
        assert seen["active colour"] == "fairing_removed_color"
        assert seen["active colour left"] == ""
        assert seen["shading left"] == ["SOLID", "MATERIAL", "STUDIO"]

    def test_discard_leaves_the_original_and_nothing_else(self, seen):
        assert seen["discarded"]
        assert seen["attributes left"] == []

    def test_the_window_shows_progress_result_and_colours(self, seen):
        pictures = seen["pictures"]
        for name, parts in pictures.items():
            assert parts["UI"]["colours"] > N_COLOURS_OF_AN_INTERFACE, name
        for earlier, later, part in (
            ("auto-running", "auto-running-later", "UI"),
            ("auto-before", "auto-after", "WINDOW"),
            ("auto-after", "auto-held", "WINDOW"),
            ("auto-after", "auto-split", "WINDOW"),
            ("auto-after", "auto-removed", "WINDOW"),
            ("auto-after", "auto-removed", "UI"),
        ):
            assert pictures[earlier][part]["checksum"] != pictures[later][part]["checksum"]


class TestWalk:
    """From the scan to the print, as a new user would go."""

    @pytest.fixture
    def seen(self, app) -> dict:
        return app.play("walk")

    def test_one_press_removes_the_noise(self, seen):
        assert seen["moved"] > 0.01

    def test_the_brush_brings_the_nose_back_and_nothing_else(self, seen):
        assert (seen["mode"], seen["mode after"]) == ("WEIGHT_PAINT", "OBJECT")
        assert seen["nose back"]
        assert 0.001 < seen["painted"] < 0.3
        assert seen["rest faired"]

    def test_apply_keeps_the_shape_and_nothing_else(self, seen):
        assert seen["shape kept"]
        assert seen["result left"] == ""

    def test_the_exported_files_have_the_shape_that_was_seen(self, seen):
        assert seen["stl"] <= 4 * FLOAT32_STEP
        assert seen["glb"] <= 4 * FLOAT32_STEP

    def test_the_window_shows_every_step(self, seen):
        checksums = {parts["WINDOW"]["checksum"] for parts in seen["pictures"].values()}
        assert len(checksums) == len(seen["pictures"])


def test_the_result_as_a_modifier(app):
    seen = app.play("modifier")
    assert seen["mesh stays"]
    assert seen["moved"] > seen["moved at half"] > 0.0
    assert 0.3 < seen["original in the split"] < 0.7
    assert seen["modifiers in the split"] == ["Adaptive Fairing", "Adaptive Fairing Split"]
    assert seen["modifiers after undo"] == ["Adaptive Fairing"]
    assert seen["discarded"]
    assert seen["modifiers left"] == []
    pictures = seen["pictures"]
    after, split = pictures["modifier-after"]["WINDOW"], pictures["modifier-split"]["WINDOW"]
    assert after["checksum"] != split["checksum"]


def test_the_mask_brings_the_original_back_in_one_undo_step(app):
    seen = app.play("mask_back")
    assert seen["moved"] > seen["moved at half"] > 0.0
    assert seen["mode"] == "SCULPT"
    assert seen["masked"]
    assert seen["rest"]
    assert seen["after undo"] == {"mode": "SCULPT", "same": True, "mask": 1.0}


def test_in_sculpt_mode_stroke_slider_and_before_are_steps_of_the_history(app):
    seen = app.play("sculpt_history")
    assert seen["forward"] == [1, 2, 3, 4]
    assert seen["back"] == [3, 2, 1]
    assert seen["again"] == [2, 3, 4]
    assert seen["mode"] == "SCULPT"


def test_without_undo_a_run_is_asked_for(app):
    seen = app.play("question")
    assert not seen["running without an answer"]
    assert not seen["running after Esc"]
    assert seen["result"] == "LIVE"
    pictures = seen["pictures"]
    before, asked = pictures["question-before"]["UI"], pictures["question-asked"]["UI"]
    assert before["checksum"] != asked["checksum"]


class TestRefinedSurface:
    """The result of Denoise on a refined mesh, chosen in the panel."""

    @pytest.fixture
    def seen(self, app) -> dict:
        return app.play("refined_surface")

    def test_the_menu_refines_the_result(self, seen):
        assert seen["surface"] == "REFINED_2"
        assert seen["triangles"] == 1280 * 4**2

    def test_the_slider_works_on_it(self, seen):
        assert 0.05 < seen["strength dragged"] < 1.0
        assert seen["moved when dragged"] > 0.0
        assert seen["slider back"]

    def test_there_is_a_way_back(self, seen):
        assert seen["back"]
        assert seen["refined after undo"]
        assert seen["discarded"]

    def test_the_window_shows_each(self, seen):
        pictures = seen["pictures"]
        for earlier, later in (
            ("surface-control", "surface-refined"),
            ("surface-refined", "surface-original"),
            ("surface-refined", "surface-curvature"),
            ("surface-refined", "surface-discarded"),
        ):
            assert pictures[earlier]["WINDOW"]["checksum"] != pictures[later]["WINDOW"]["checksum"]


class TestEvolution:
    """What the panel offers for the paper, in three clicks."""

    @pytest.fixture
    def seen(self, app) -> dict:
        return app.play("evolution")

    def test_three_clicks_lead_to_an_evolution_that_plays_in_colours(self, seen):
        assert seen["algorithm"] == "FAIR"
        assert seen["view"] == "DENSITY"
        assert seen["shading"] == ["SOLID", "VERTEX", "STUDIO"]
        assert seen["range"] == [1, 100, True]

    def test_a_fourth_stops_it(self, seen):
        assert not seen["playing after stop"]
        assert not seen["preview after stop"]

    def test_one_undo_takes_the_animation_and_the_colours_back(self, seen):
        assert seen["keys after undo"] == EVOLUTION
        assert not seen["animated after undo"]
        assert seen["view after undo"] == ""
        assert seen["shading after undo"] == ["SOLID", "MATERIAL", "STUDIO"]

    def test_the_window_shows_each(self, seen):
        pictures = seen["pictures"].values()
        assert len({parts["WINDOW"]["checksum"] for parts in pictures}) >= 5


class TestColors:
    """Fields in colours, their material, and an attribute that is faired."""

    BEFORE = ("Scan", "", ["Mine"], ["SOLID", "MATERIAL", "STUDIO"])
    SHOWN = ("fairing_mean_curvature_color", "CURVATURE", ["Mine"], ["SOLID", "VERTEX", "STUDIO"])
    RENDERED = (*SHOWN[:2], ["Fairing Colors"], SHOWN[3])

    @pytest.fixture
    def seen(self, app) -> dict:
        return app.play("colors")

    def test_a_click_shows_them_lit_and_another_renders_them(self, seen):
        assert tuple(seen["before"]) == self.BEFORE
        assert tuple(seen["shown"]) == self.SHOWN
        assert tuple(seen["rendered"]) == self.RENDERED

    def test_undo_and_redo_bring_each_state_back(self, seen):
        assert list(map(tuple, seen["history"])) == [
            self.SHOWN,
            self.BEFORE,
            self.SHOWN,
            self.RENDERED,
        ]

    def test_a_click_on_the_lit_button_leaves_nothing(self, seen):
        assert tuple(seen["ended"]) == self.BEFORE

    def test_a_noisy_colour_is_faired_by_a_click_and_undone_in_one_step(self, seen):
        noise = 12**-0.5  # of numbers that are even in [0, 1]
        assert seen["spread"] < 0.8 * noise
        assert seen["spread after undo"] == pytest.approx(noise, rel=0.02)

    def test_the_window_shows_each(self, seen):
        pictures = seen["pictures"]
        for earlier, later in (("before", "shown"), ("shown", "ended"), ("noisy", "faired")):
            parts = [pictures[f"colors-{each}"]["WINDOW"] for each in (earlier, later)]
            assert parts[0]["checksum"] != parts[1]["checksum"]


def test_one_of_three_is_deleted_during_the_run_and_undo_goes_on(app):
    seen = app.play("delete_one_of_three")
    assert seen["results"] == {"Icosphere": "LIVE", "Third": "LIVE"}
    assert seen["after one undo"] == {"Icosphere": "", "Third": ""}
    assert seen["after two"] == {"Icosphere": "", "Second": "", "Third": ""}


def test_deleting_the_object_during_a_run_is_survived(app):
    assert app.play("delete_object")["second run"] == ["Basis", "Fairing 1", "Fairing 2"]


def test_loading_a_file_during_a_run_is_survived(app):
    seen = app.play("load_file")
    assert not seen["running after load"]
    assert seen["objects after load"] == ["Camera", "Cube", "Light"]
    assert seen["keys in the loaded file"] == 0
    assert seen["second run"] == ["Basis", "Fairing 1", "Fairing 2"]


def test_quitting_during_a_run_ends_the_program_in_order(app):
    assert app.play("quit_program")["running at the end"]


def test_the_window_keeps_drawing_while_200000_triangles_are_faired(app):
    """The view is drawn all through the run, also while a step is being computed.

    The solver's thread and Blender's software renderer share the machine, so the rate may fall to
    a fifth of the idle one. A solver in the window's own thread would let no drawing through for
    as long as a step takes.
    """
    seen = app.play("large_mesh")
    assert seen["triangles"] >= 200_000
    assert seen["keys"] == EVOLUTION
    idle, run = seen["idle"], seen["run"]
    mean_step = run["seconds"] / (len(EVOLUTION) - 1)
    assert run["draws"] / run["seconds"] > 0.2 * idle["draws"] / idle["seconds"]
    assert run["longest gap"] < mean_step


def test_the_button_for_frames_makes_an_object_that_plays_them(app):
    seen = app.play("sequence")
    assert seen["keys"] == [f"Frame {frame}" for frame in range(1, 6)]
    assert seen["result"].endswith(" faired")
    assert seen["hidden"]
    assert seen["eval_time"] == seen["frames of the keys"]
    assert len(seen["after undo"]) == 1
    kept = seen["kept after escape"]
    assert 1 <= len(kept) < 200
    assert kept == [f"Frame {frame}" for frame in range(1, len(kept) + 1)]
    pictures = seen["pictures"]
    for name, parts in pictures.items():
        assert parts["UI"]["colours"] > N_COLOURS_OF_AN_INTERFACE, name
    assert (
        pictures["sequence-before"]["WINDOW"]["checksum"]
        != pictures["sequence-after"]["WINDOW"]["checksum"]
    )


def test_every_panel_is_drawn_in_every_language(app):
    """The texts are Blender's for labels and for operators, and each picture is another."""
    seen = app.play("languages")
    assert seen["de_DE"] == ["Zurückmalen"] * 2
    assert seen["es"] == ["Recuperar"] * 2
    sidebars = [parts["UI"] for parts in seen["pictures"].values()]
    assert all(picture["colours"] > N_COLOURS_OF_AN_INTERFACE for picture in sidebars)
    assert len({picture["checksum"] for picture in sidebars}) == len(sidebars) == 12


def test_the_pictures_of_the_manual_can_be_taken_again(app):
    """With APP_ARTEFACTS they stay; those that begin with "manual" belong into assets."""
    seen = app.play("manual")
    assert seen["shows"] == "REMOVED"
    different = ("before", "after", "split", "removed", "paint")
    checksums = {seen["pictures"][name]["WINDOW"]["checksum"] for name in different}
    assert len(checksums) == len(different)
    for name in seen["pictures"]:
        assert (app.directory / "manual" / f"manual-{name}.png").is_file()


def test_a_comparison_lies_side_by_side_in_the_default_view(app):
    seen = app.play("comparison")
    boxes, labels = np.array(seen["boxes"]), np.array(seen["labels"])
    assert (boxes[1:, 0, 0] > boxes[:-1, 1, 0]).all(), "no copy covers its neighbour"
    assert (labels[1:, 0, 0] > labels[:-1, 1, 0]).all()
    assert (labels[:, 1, 1] < boxes[:, 0, 1]).all(), "the labels are below"
    everything = np.concatenate([boxes, labels])
    assert (everything >= 0).all()
    assert (everything <= seen["size"]).all()


def test_a_check_changes_nothing_and_shows_what_it_finds(app):
    seen = app.play("check")
    assert seen["unchanged"] == [True, True]
    pictures = [seen["pictures"][f"check-{name}"]["UI"] for name in ("running", "ended", "found")]
    assert len({each["checksum"] for each in pictures}) == 3


def test_the_line_of_a_split_can_be_seen_and_dragged(app):
    seen = app.play("split_line")
    assert seen["half"] == pytest.approx(0.5, abs=0.1)
    assert seen["dragged"] > seen["half"] + 0.1
    assert seen["dragged"] < 1
    assert seen["selected"], "the drag has not selected anything else"
    assert seen["after undo"] == pytest.approx(seen["half"], abs=0.001)


def test_painting_back_shows_the_surface_and_a_key_swaps_the_weights(app):
    seen = app.play("painting")
    before, painting, after = seen["opacities"]
    assert painting < 0.5 < before == after
    assert seen["weights"] == [0.0, 1.0, 0.0]
    assert seen["mask back"] == [False, True], "only with a mask"


def test_a_key_denoises_what_is_under_the_brush_in_sculpt_mode(app):
    seen = app.play("brush")
    assert seen["mode"] == "SCULPT"
    assert 0.001 < seen["moved"] < 0.2
    assert seen["in front"] > 0.5, "around the pointer, in the middle of the ball of radius 1"
    assert seen["after undo"] == ["SCULPT", True]
