"""Display of a result: which of the three kinds an object has."""

import pytest

from adaptive_fairing.blender.data import modifier
from adaptive_fairing.blender.data.display import (
    KeysDisplay,
    LiveDisplay,
    ModifierDisplay,
    RelativeKeysDisplay,
    display_of,
    new_display,
)
from adaptive_fairing.blender.data.display_base import Display
from adaptive_fairing.blender.data.mesh_arrays import read_mesh_coordinates
from adaptive_fairing.blender.data.stored_path import StoredPath

pytestmark = pytest.mark.usefixtures("addon")

KINDS = {
    "LIVE": LiveDisplay,
    "MODIFIER": ModifierDisplay,
    "ABSOLUTE_KEYS": KeysDisplay,
    "RELATIVE_KEYS": RelativeKeysDisplay,
}


def write(obj, name):
    """Store a result of two knots as the setting of this name asks for."""
    start = read_mesh_coordinates(obj.data)
    path = StoredPath.through(start, (1.0, 2.0), [1.1 * start, 1.2 * start])
    new_display(obj, name).write(path, 1.0)


@pytest.mark.parametrize("name", KINDS)
def test_it_is_of_the_kind_that_was_written(obj, name):
    write(obj, name)
    assert type(display_of(obj)) is KINDS[name]
    assert display_of(obj).is_whole


def test_without_a_result_it_shows_the_mesh(obj):
    display = display_of(obj)
    assert type(display) is Display
    assert (display.is_whole, display.has_original, display.has_strokes) == (False, False, False)
    assert display.original() is None
    assert (display.shown() == read_mesh_coordinates(obj.data)).all()


def test_a_modifier_that_was_applied_by_blender_leaves_a_live_result(obj):
    write(obj, "MODIFIER")
    modifier.remove(obj)
    assert type(display_of(obj)) is LiveDisplay


def test_keys_that_were_made_relative_are_relative(obj):
    write(obj, "ABSOLUTE_KEYS")
    obj.data.shape_keys.use_relative = True
    assert type(display_of(obj)) is RelativeKeysDisplay
