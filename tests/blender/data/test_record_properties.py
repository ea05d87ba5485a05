"""The sliders of a record and its legend."""

import numpy as np
import pytest

from adaptive_fairing.blender.data import results
from adaptive_fairing.blender.data.color_map import ANCHORS, colors_srgb
from adaptive_fairing.blender.data.display import display_of
from adaptive_fairing.blender.data.mesh_arrays import read_mesh_coordinates
from adaptive_fairing.blender.data.record_properties import (
    N_SWATCHES,
    swatch_name,
)
from adaptive_fairing.blender.data.stored_path import StoredPath

pytestmark = pytest.mark.usefixtures("addon")


def store(obj, way):
    start = read_mesh_coordinates(obj.data)
    results.store(obj, StoredPath.through(start, [1.0], [0.8 * start]), 1.0, way)
    return start


@pytest.mark.parametrize("way", ["LIVE", "MODIFIER"])
def test_the_strength_is_what_was_set_and_shows_at_once(obj, way):
    start = store(obj, way)
    obj.adaptive_fairing.strength = 0.25
    assert obj.adaptive_fairing.strength == 0.25
    np.testing.assert_allclose(display_of(obj).shown(), 0.95 * start, atol=1e-6)


def test_the_strength_of_a_lost_result_writes_nothing(obj):
    store(obj, "LIVE")
    obj.data.attributes.remove(obj.data.attributes[".fairing_offset_1"])
    before = read_mesh_coordinates(obj.data)
    obj.adaptive_fairing.strength = 0.0
    np.testing.assert_array_equal(read_mesh_coordinates(obj.data), before)


def test_the_evolution_goes_through_the_steps(obj):
    start = read_mesh_coordinates(obj.data)
    shapes = [0.9 * start, 0.7 * start, 0.6 * start]
    results.store(obj, StoredPath.through(start, (1, 2, 3), shapes), 3, "ABSOLUTE_KEYS")
    record = obj.adaptive_fairing
    path = np.stack([start, *shapes])
    for time in (0.0, 1 / 6, 1 / 3, 0.75, 1.0):
        record.evolution = time
        assert record.evolution == pytest.approx(time, abs=1e-6)
        below = min(int(3 * time), 2)
        expected = path[below] + (3 * time - below) * (path[below + 1] - path[below])
        np.testing.assert_allclose(display_of(obj).shown(), expected, atol=1e-5)


def test_the_legend_has_the_colours_of_the_map_and_keeps_them(obj):
    record = obj.adaptive_fairing
    record.view = "DENSITY"
    expected = colors_srgb(np.linspace(0, 1, N_SWATCHES), 0.0, 1.0, ANCHORS)
    for number, color in enumerate(expected):
        setattr(record, swatch_name(number), (0.5, 0.5, 0.5))
        np.testing.assert_allclose(getattr(record, swatch_name(number)), color, atol=1e-6)
