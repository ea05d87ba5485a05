"""What all displays have in common: the side of a split, sharing, and an end."""

import numpy as np
import pytest
from support.objects import everything

from adaptive_fairing.blender.data.display import display_of, new_display
from adaptive_fairing.blender.data.display_base import is_behind
from adaptive_fairing.blender.data.mesh_arrays import read_mesh_coordinates
from adaptive_fairing.blender.data.stored_path import StoredPath

pytestmark = pytest.mark.usefixtures("addon")

WAYS = ["LIVE", "MODIFIER", "ABSOLUTE_KEYS"]


def write(obj, way):
    start = read_mesh_coordinates(obj.data)
    new_display(obj, way).write(StoredPath.through(start, (1.0,), [1.1 * start]), 1.0)


def test_a_plane_has_the_original_on_the_side_against_its_normal(obj):
    record = obj.adaptive_fairing
    points = read_mesh_coordinates(obj.data)
    record.split_point, record.split_normal = (0.1, 0.2, 0.3), (0.0, 0.6, 0.8)
    distance = (points.astype(float) - [0.1, 0.2, 0.3]) @ [0.0, 0.6, 0.8]
    assert np.array_equal(is_behind(points, record), distance < 0)
    record.is_before = True
    assert is_behind(points, record).all()


@pytest.mark.parametrize("way", WAYS)
def test_another_object_of_the_same_mesh_shows_the_same_result(obj, way):
    other = obj.copy()
    write(obj, way)
    display_of(obj).share(other)
    assert other.data == obj.data
    assert type(display_of(other)) is type(display_of(obj))
    assert display_of(other).is_whole
    assert display_of(other).place == display_of(obj).place
    assert np.array_equal(display_of(other).shown(), display_of(obj).shown())


@pytest.mark.parametrize("way", WAYS)
def test_an_end_leaves_the_shape_or_the_original_and_nothing_else(obj, way):
    before = everything(obj)
    for end in ("apply", "clear"):
        write(obj, way)
        shown, original = display_of(obj).shown(), display_of(obj).original()
        expected = shown if end == "apply" or way == "LIVE" else original
        getattr(display_of(obj), end)()
        assert np.array_equal(read_mesh_coordinates(obj.data), expected)
        assert {**everything(obj), "coordinates": before["coordinates"]} == before
        obj.data.vertices.foreach_set("co", original.ravel())
