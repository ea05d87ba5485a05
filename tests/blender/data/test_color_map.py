"""The colour map against the published one, and its behaviour at the ends."""

import numpy as np
import pytest

from adaptive_fairing.blender.data.color_map import (
    DIVERGING_ANCHORS,
    NO_VALUE,
    colors_srgb,
    normalized,
    srgb_to_linear,
    symmetric_range,
)

# Entries of the published table of 256 colours (viridis, CC0), away from the anchors in use.
PUBLISHED = [
    (6, (0.275, 0.038, 0.365)),
    (33, (0.278, 0.18, 0.487)),
    (60, (0.237, 0.305, 0.542)),
    (87, (0.187, 0.415, 0.557)),
    (114, (0.146, 0.515, 0.557)),
    (141, (0.119, 0.615, 0.538)),
    (168, (0.197, 0.712, 0.479)),
    (195, (0.395, 0.797, 0.368)),
    (222, (0.658, 0.86, 0.203)),
    (249, (0.936, 0.899, 0.108)),
]


def test_is_the_published_map_within_its_tolerance():
    entries = [entry for entry, _ in PUBLISHED]
    colors = colors_srgb(entries, low=0, high=255)
    assert np.abs(colors - [color for _, color in PUBLISHED]).max() < 0.014


def test_lightness_rises_with_the_value():
    luminance = srgb_to_linear(colors_srgb(np.linspace(0, 1, 1000))) @ [0.2126, 0.7152, 0.0722]
    assert np.all(np.diff(luminance) > 0)


def test_range_defaults_to_that_of_the_finite_values():
    values = [3.0, np.nan, 5.0, 4.0]
    np.testing.assert_array_equal(normalized(values), [0, np.nan, 1, 0.5])


def test_values_outside_a_given_range_take_its_ends():
    np.testing.assert_array_equal(normalized([-9, 1, 9, np.inf, -np.inf], 0, 2), [0, 0.5, 1, 1, 0])


@pytest.mark.parametrize("value", [0.0, -2.5, 1e300])
def test_a_single_value_has_the_middle_colour(value):
    np.testing.assert_array_equal(normalized([value] * 3), [0.5] * 3)


def test_huge_values_do_not_overflow():
    np.testing.assert_array_equal(normalized([-1.7e308, 0, 1.7e308]), [0, 0.5, 1])


def test_no_value_is_grey_and_nothing_at_all_too():
    np.testing.assert_array_equal(colors_srgb([1, np.nan, 2])[1], NO_VALUE)
    np.testing.assert_array_equal(colors_srgb([np.nan, np.nan]), [NO_VALUE] * 2)
    assert colors_srgb([]).shape == (0, 3)


def test_srgb_decoding_at_known_points():
    # 0.5 encodes about 21.4 % of the light; the two branches of the curve meet at 0.04045.
    np.testing.assert_allclose(srgb_to_linear([0, 0.5, 1]), [0, 0.21404114, 1], rtol=1e-7)
    below, above = srgb_to_linear([0.04045, 0.0404500001])
    assert above == pytest.approx(below, rel=1e-4)


class TestBothSidesOfZero:
    def colors(self, values):
        return colors_srgb(values, -2.0, 2.0, DIVERGING_ANCHORS)

    def luminance(self, values):
        return srgb_to_linear(self.colors(values)) @ [0.2126, 0.7152, 0.0722]

    def test_zero_is_bright_without_a_hue_and_brightness_falls_to_both_sides(self):
        red, green, blue = self.colors([0.0])[0]
        assert red == green == blue > 0.9
        assert np.all(np.diff(self.luminance(np.linspace(0, 2, 1000))) < 0)
        assert np.all(np.diff(self.luminance(np.linspace(-2, 0, 1000))) > 0)

    def test_both_sides_are_as_bright(self):
        values = np.linspace(0, 2, 100)
        ratio = self.luminance(values) / self.luminance(-values)
        assert np.abs(np.log(ratio)).max() < np.log(1.6)

    def test_positive_is_red_and_negative_is_blue(self):
        (positive, negative) = self.colors([1.0, -1.0])
        assert positive[0] > positive[2] + 0.3
        assert negative[2] > negative[0] + 0.3

    def test_the_range_is_symmetric_and_spares_a_few_extremes(self):
        values = np.append(np.linspace(-1.0, 3.0, 1000), [np.nan, 1e6])
        low, high = symmetric_range(values)
        assert low == -high
        assert 2.8 < high < 3.1
        assert symmetric_range([np.nan]) == (0.0, 0.0)
