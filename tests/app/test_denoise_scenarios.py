"""Denoise in Blender's own window, operated by mouse and keyboard."""

from __future__ import annotations

import pytest
from support.window import N_COLOURS_OF_AN_INTERFACE

pytestmark = pytest.mark.app


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT", "SCULPT"])
def test_one_undo_restores_what_was_there_in_every_mode(app, mode):
    seen = app.play("undo_in_modes")[mode]
    assert seen["after run"]["moved"] > 0.0
    assert seen["after run"]["mode"] == mode
    mask = 0.5 if mode == "SCULPT" else None
    assert seen["after undo"] == {"mode": mode, "moved": 0.0, "mask": mask, "result": ""}


def test_in_edit_mode_the_slider_moves_the_selection_and_is_undone_by_itself(app):
    seen = app.play("edit_slider")
    assert seen["moved"] > seen["moved at half"] > seen["moved at a quarter"] > 0.0
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


def test_a_check_changes_nothing_and_shows_what_it_finds(app):
    seen = app.play("check")
    assert seen["unchanged"] == [True, True]
    pictures = [seen["pictures"][f"check-{name}"]["UI"] for name in ("running", "ended", "found")]
    assert len({each["checksum"] for each in pictures}) == 3


def test_a_noise_size_that_was_given_is_shown_in_the_view(app):
    pictures = app.play("split_line")["pictures"]
    views = [pictures[f"ring-{name}"]["WINDOW"] for name in ("before", "given", "automatic")]
    assert views[0]["checksum"] == views[2]["checksum"] != views[1]["checksum"]


def test_the_line_of_a_split_can_be_seen_and_dragged(app):
    seen = app.play("split_line")
    assert seen["half"] == pytest.approx(0.5, abs=0.1)
    assert seen["dragged"] > seen["half"] + 0.1
    assert seen["dragged"] < 1
    assert seen["selected"], "the drag has not selected anything else"
    assert seen["after undo"] == pytest.approx(seen["half"], abs=0.001)
