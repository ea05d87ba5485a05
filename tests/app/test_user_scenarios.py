"""A user's way through Blender's own window: every panel, export, the manual's pictures."""

from __future__ import annotations

import pytest
from support.window import FLOAT32_STEP, N_COLOURS_OF_AN_INTERFACE

pytestmark = pytest.mark.app


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
