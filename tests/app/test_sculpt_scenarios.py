"""Sculpting and painting on a result in Blender's own window, by mouse and keyboard."""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.app


def test_the_mask_brings_the_original_back_in_one_undo_step(app):
    seen = app.play("mask_back")
    assert seen["moved"] > seen["moved at half"] > 0.0
    assert seen["mode"] == "SCULPT"
    assert seen["masked"]
    assert seen["rest"]
    assert seen["after undo"] == {"mode": "SCULPT", "same": True, "mask": 1.0}


def test_in_sculpt_mode_stroke_slider_and_before_are_steps_of_the_history(app):
    seen = app.play("sculpt_history")
    assert seen["forward"] == [1, 2, 3, 4, 5, 4], "stroke, typed, dragged slowly, Before, its end"
    # Between a stroke and another change Blender needs a step that changes nothing.
    assert seen["back"] == [5, 4, 3, 2, 2, 1]
    assert seen["again"] == [2, 2, 3, 4, 5, 4]
    assert seen["mode"] == "SCULPT"


def test_painting_back_shows_the_surface_and_a_key_swaps_the_weights(app):
    seen = app.play("painting")
    before, painting, after = seen["opacities"]
    assert painting < 0.5 < before == after
    assert seen["weights"] == [0.0, 1.0, 0.0]
    assert seen["typed"] == ["WEIGHT_PAINT", 0.5, False]
    assert seen["undone"] == ["WEIGHT_PAINT", 1.0, True], "the slider is a step of the history"
    assert seen["mask back"] == [False, True], "only with a mask"


def test_a_key_denoises_what_is_under_the_brush_in_sculpt_mode(app):
    seen = app.play("brush")
    assert seen["mode"] == "SCULPT"
    assert 0.001 < seen["moved"] < 0.2
    assert seen["in front"] > 0.5, "around the pointer, in the middle of the ball of radius 1"
    assert seen["after undo"] == ["SCULPT", True]
