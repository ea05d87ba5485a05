"""The steps of `fair` as shape keys: what is shown, what was changed, what is the original."""

import numpy as np
import pytest
from support.objects import key_positions, shown_positions

from adaptive_fairing.blender.data.display import display_of, new_display
from adaptive_fairing.blender.data.mesh_arrays import read_mesh_coordinates
from adaptive_fairing.blender.data.stored_path import ORIGINAL, StoredPath, write_vectors

pytestmark = pytest.mark.usefixtures("addon")

STEPS = (1.0, 2.0, 3.0)


@pytest.fixture
def shapes(obj):
    start = read_mesh_coordinates(obj.data)
    return [np.float32(1 + step / 8) * start for step in (0.0, *STEPS)]


@pytest.fixture(params=["ABSOLUTE_KEYS", "RELATIVE_KEYS"])
def display(request, obj, shapes):
    path = StoredPath.through(shapes[0], STEPS, shapes[1:])
    new_display(obj, request.param).write(path, 3.0)
    return display_of(obj)


@pytest.mark.parametrize("display", ["ABSOLUTE_KEYS"], indirect=True)
@pytest.mark.parametrize("place", [0.0, 0.4, 1.0, 1.6, 3.0])
def test_between_two_steps_it_is_between_their_shapes(obj, shapes, display, place):
    display.show(place)
    assert display.place == pytest.approx(place)
    flat = np.reshape(shapes, (len(shapes), -1))
    expected = np.reshape([np.interp(place, (0.0, *STEPS), each) for each in flat.T], (-1, 3))
    for found in (display.shown(), shown_positions(obj)):
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6)
    # Strokes go to the nearest step.
    assert obj.active_shape_key_index == round(place)


def test_a_stroke_is_known_until_it_is_noted(obj, display):
    assert not display.has_strokes
    obj.data.shape_keys.key_blocks["Fairing 2"].points[4].co.x += 0.01
    assert display.has_strokes
    display.note_written()
    assert not display.has_strokes


def test_the_original_is_the_basis_or_what_came_before_it(obj, shapes, display):
    assert np.array_equal(display.original(), shapes[0])
    write_vectors(obj.data, ORIGINAL, 2 * shapes[0])
    assert np.array_equal(display.original(), 2 * shapes[0])


def test_a_first_knot_at_0_is_the_basis(obj, shapes):
    path = StoredPath.through(2 * shapes[0], (0.0, *STEPS), shapes)
    display = new_display(obj, "ABSOLUTE_KEYS")
    display.write(path, 2.0)
    assert display.place == 2.0
    assert np.array_equal(display.original(), 2 * shapes[0])
    for name, shape in zip(obj.data.shape_keys.key_blocks.keys(), shapes, strict=True):
        assert np.array_equal(key_positions(obj, name), shape)


def test_a_further_run_adds_to_the_way_from_the_original(display, shapes):
    original, offsets = display.so_far(shapes[2], [0.0, 0.5, 1.0, 2.0])
    assert np.array_equal(original, shapes[0])
    way = shapes[2] - shapes[0]
    for part, offset in zip((0.0, 0.5, 1.0, 1.0), offsets, strict=True):
        assert np.array_equal(offset, np.float32(part) * way)


def test_the_end_leaves_the_keys_of_the_user(obj, display):
    smile = obj.shape_key_add(name="Smile", from_mix=False)
    smile.points[0].co.z += 1
    expected = key_positions(obj, "Smile")
    display.clear()
    assert [block.name for block in obj.data.shape_keys.key_blocks] == ["Basis", "Smile"]
    assert np.array_equal(key_positions(obj, "Smile"), expected)
