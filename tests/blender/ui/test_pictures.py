"""The pictures in the panel: shape, colours, and what they show."""

import numpy as np
import pytest

from adaptive_fairing.blender.data.color_map import ANCHORS, DIVERGING_ANCHORS
from adaptive_fairing.blender.ui import pictures


def line_height(image, x):
    """Height of the line in a column: the middle of its opaque pixels."""
    opaque = np.flatnonzero(image[:, x, 3] > 0.99)
    return opaque.mean()


class TestPlot:
    def test_it_is_premultiplied_rgba(self):
        image = pictures.draw_plot([3.0, 1.0, 2.0])
        assert image.shape == (pictures.PLOT_SIZE, pictures.PLOT_SIZE, 4)
        assert image.min() >= 0.0
        assert image.max() <= 1.0 + 1e-12
        assert (image[:, :, :3] <= image[:, :, 3:] + 1e-12).all()

    def test_heights_are_proportional_to_the_values(self):
        image = pictures.draw_plot([4.0, 2.0, 1.0])
        left, middle, right = (line_height(image, x) for x in (10, 96, 181))
        bottom = 10.0
        assert (middle - bottom) / (left - bottom) == pytest.approx(0.5, abs=0.03)
        assert (right - bottom) / (left - bottom) == pytest.approx(0.25, abs=0.03)

    @pytest.mark.parametrize(
        "values", [[1.0], [0.0, 0.0], [float("nan"), 1.0], list(range(1, 300)), [1e-300, 1e300]]
    )
    def test_any_course_can_be_drawn(self, values):
        assert np.isfinite(pictures.draw_plot(values)).all()


def test_the_colour_scale_runs_from_dark_at_the_bottom_to_bright_at_the_top():
    image = pictures.draw_scale()
    bar = image[:, pictures.SCALE_BAR]
    assert bar[0, 0, :3] == pytest.approx(ANCHORS[0])
    assert bar[-1, 0, :3] == pytest.approx(ANCHORS[-1])
    brightness = bar[:, 0, :3] @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(brightness) > 0).all()


def test_the_signed_colour_scale_runs_from_blue_over_white_to_red():
    bar = pictures.draw_scale(DIVERGING_ANCHORS)[:, pictures.SCALE_BAR]
    assert bar[0, 0, :3] == pytest.approx(DIVERGING_ANCHORS[0])
    assert bar[-1, 0, :3] == pytest.approx(DIVERGING_ANCHORS[-1])
    assert bar[len(bar) // 2, 0, :3].min() > 0.9


@pytest.mark.usefixtures("addon")
class TestIcons:
    def test_a_picture_is_drawn_once(self, monkeypatch):
        drawn = []
        draw = pictures.draw_plot
        monkeypatch.setattr(pictures, "draw_plot", lambda v: drawn.append(v) or draw(v))
        for _ in range(3):
            pictures.plot_icon([5.0, 4.0, 3.5])
        assert drawn == [(5.0, 4.0, 3.5)]

    def test_pictures_do_not_pile_up(self):
        for value in range(3 * pictures.REMEMBERED):
            pictures.plot_icon([100.0 + value, 1.0])
        pictures.scale_icon()
        assert len(pictures._collections[0]) <= pictures.REMEMBERED
