"""The record of a run: which strength is shown, what its measures are, the look at the original."""

import numpy as np
import pytest
from support.meshes import icosphere
from support.objects import add_object

from adaptive_fairing.blender.data import results
from adaptive_fairing.blender.data.display import display_of
from adaptive_fairing.blender.data.mesh_arrays import read_mesh_coordinates
from adaptive_fairing.blender.data.stored_path import StoredPath

pytestmark = pytest.mark.usefixtures("addon")

STRENGTHS = [0.5, 1.0, 2.0]


@pytest.fixture
def record():
    """The record of a ball with a live result of which the volume is twice the strength."""
    obj = add_object(*icosphere(1))
    start = read_mesh_coordinates(obj.data)
    shapes = [start * (1 - strength / 10) for strength in STRENGTHS]
    results.store(obj, StoredPath.through(start, STRENGTHS, shapes), 1.0, "LIVE")
    for strength in (0.0, *STRENGTHS):
        shape = obj.adaptive_fairing.shapes.add()
        shape.strength, shape.volume = strength, 2 * strength
    return obj.adaptive_fairing


@pytest.mark.parametrize("strength", [0.0, 0.3, 1.0, 1.6, 2.0])
def test_measures_are_those_of_the_strength_that_is_shown(record, strength):
    record.strength = strength
    assert results.result_measures(record).volume == pytest.approx(2 * strength, abs=1e-6)


def test_without_a_slider_the_measures_are_those_of_the_result(record):
    record.result, record.shown = "", 2
    assert results.result_measures(record).volume == 2.0


def test_the_original_is_shown_and_the_result_again(record):
    obj = record.id_data
    record.strength = 1.5
    result = read_mesh_coordinates(obj.data)
    results.show_before(record.id_data, True)
    np.testing.assert_array_equal(read_mesh_coordinates(obj.data), display_of(obj).original())
    assert (record.strength, record.is_before) == (1.5, True)
    results.show_before(record.id_data, False)
    np.testing.assert_array_equal(read_mesh_coordinates(obj.data), result)
    assert (record.strength, record.is_before) == (1.5, False)


def test_who_moves_the_slider_ends_the_look_at_the_original(record):
    results.show_before(record.id_data, True)
    record.strength = 0.5
    assert not record.is_before
    results.show_before(record.id_data, False)
    assert record.strength == 0.5


def test_the_end_of_a_comparison_shows_the_whole_result(record):
    obj = record.id_data
    result = read_mesh_coordinates(obj.data)
    results.show_split(obj, (1.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    assert not np.array_equal(read_mesh_coordinates(obj.data), result)
    results.end_comparison(obj)
    assert not record.is_split
    np.testing.assert_array_equal(read_mesh_coordinates(obj.data), result)


def test_forgotten_nothing_is_left(record):
    results.forget(record.id_data)
    assert (record.result, record.notes, len(record.shapes)) == ("", "", 0)
