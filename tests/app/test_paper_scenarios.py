"""The paper's method in Blender's own window, operated by mouse and keyboard."""

from __future__ import annotations

import numpy as np
import pytest
from support.window import FLOAT32_STEP, N_COLOURS_OF_AN_INTERFACE

pytestmark = pytest.mark.app

EVOLUTION = ["Basis", "Fairing 1", "Fairing 2", "Fairing 3", "Fairing 4"]


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


def test_a_comparison_lies_side_by_side_in_the_default_view(app):
    seen = app.play("comparison")
    boxes, labels = np.array(seen["boxes"]), np.array(seen["labels"])
    assert (boxes[1:, 0, 0] > boxes[:-1, 1, 0]).all(), "no copy covers its neighbour"
    assert (labels[1:, 0, 0] > labels[:-1, 1, 0]).all()
    assert (labels[:, 1, 1] < boxes[:, 0, 1]).all(), "the labels are below"
    everything = np.concatenate([boxes, labels])
    assert (everything >= 0).all()
    assert (everything <= seen["size"]).all()
