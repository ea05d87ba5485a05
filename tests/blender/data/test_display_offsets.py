"""Results as offsets: vertices that were moved by hand stay, all others follow the strength."""

import numpy as np
import pytest
from support.objects import edit_net, shown_positions

from adaptive_fairing.blender.data.display import N_STRENGTHS, display_of, new_display
from adaptive_fairing.blender.data.mesh_arrays import read_mesh_coordinates
from adaptive_fairing.blender.data.stored_path import StoredPath
from adaptive_fairing.blender.data.vertex_groups import forget_weights
from adaptive_fairing.core.denoising.plan import STRENGTHS

pytestmark = pytest.mark.usefixtures("addon")

STROKE = 5
ATOL = 1e-6
ULP = 2.0**-23  # spacing of single precision at 1, the size of the sphere


@pytest.fixture
def shapes(obj):
    start = read_mesh_coordinates(obj.data)
    generator = np.random.default_rng(0)
    moves = generator.normal(scale=0.1, size=(2, *start.shape)).astype(np.float32)
    return [start, start + moves[0], start + moves[1]]


def write(obj, shapes, way):
    new_display(obj, way).write(StoredPath.through(shapes[0], (1.0, 2.0), shapes[1:]), 1.0)
    return display_of(obj)


@pytest.fixture
def live(obj, shapes):
    return write(obj, shapes, "LIVE")


def stroke(obj, move=0.3):
    obj.data.vertices[STROKE].co.x += move
    obj.data.update()


def test_a_stroke_stays_while_all_others_follow(obj, live, shapes):
    stroke(obj)
    assert live.has_strokes
    assert live.is_whole
    assert not live.goes_on
    moved = read_mesh_coordinates(obj.data)[STROKE]
    for place, shape in ((2.0, shapes[2]), (0.0, shapes[0]), (1.0, shapes[1])):
        live.show(place)
        expected = shape.copy()
        expected[STROKE] = moved
        np.testing.assert_allclose(read_mesh_coordinates(obj.data), expected, atol=ATOL)


def test_rounding_is_no_stroke_and_hardly_more_is_one(obj, live):
    stroke(obj, 2 * ULP)
    assert not live.has_strokes
    stroke(obj, 32 * ULP)
    assert live.has_strokes


def test_a_vertex_that_slid_along_its_way_is_untouched(obj, live, shapes):
    points = read_mesh_coordinates(obj.data)
    points[STROKE] = (shapes[0][STROKE] + shapes[1][STROKE]) / 2
    obj.data.vertices.foreach_set("co", points.ravel())
    assert not live.has_strokes


def test_a_further_run_begins_with_the_stroke(obj, live, shapes):
    stroke(obj)
    start = read_mesh_coordinates(obj.data)
    original, (half, whole) = live.so_far(start, [0.5, 1.0])
    assert np.array_equal(original[STROKE], start[STROKE])
    assert not half[STROKE].any()
    others = np.arange(len(start)) != STROKE
    assert np.array_equal(original[others], shapes[0][others])
    np.testing.assert_allclose((original + whole)[others], start[others], atol=ATOL)
    np.testing.assert_allclose(2 * half[others], whole[others], atol=ATOL)


@pytest.mark.parametrize("change", ["subdivide", "delete"])
def test_with_other_vertices_it_is_no_longer_whole(obj, live, change):
    edit_net(obj, change)
    assert not live.is_whole
    assert not live.goes_on


def test_where_every_vertex_was_moved_nothing_is_left(obj, live):
    obj.data.vertices.foreach_set("co", (read_mesh_coordinates(obj.data) * 3).ravel())
    assert not live.is_whole


@pytest.mark.parametrize("way", ["LIVE", "MODIFIER"])
def test_weights_scale_the_result(obj, shapes, way):
    display = write(obj, shapes, way)
    group = display.paint_group()
    weights = np.linspace(0, 1, len(shapes[0]), dtype=np.float32)
    for index, weight in enumerate(weights.tolist()):
        group.add([index], weight, "REPLACE")
    forget_weights()
    display.show(1.0)
    expected = shapes[0] + weights[:, None] * (shapes[1] - shapes[0])
    np.testing.assert_allclose(display.shown(), expected, atol=ATOL)
    np.testing.assert_allclose(shown_positions(obj), expected, atol=ATOL)


def test_the_modifier_leaves_the_coordinates(obj, shapes):
    display = write(obj, shapes, "MODIFIER")
    for place, shape in ((0.0, shapes[0]), (1.0, shapes[1]), (2.0, shapes[2])):
        display.show(place)
        assert np.array_equal(read_mesh_coordinates(obj.data), shapes[0])
        np.testing.assert_allclose(display.shown(), shape, atol=ATOL)
        np.testing.assert_allclose(shown_positions(obj), shape, atol=ATOL)


def test_a_record_has_room_for_the_strengths_of_a_run(obj):
    """A region that starts within an earlier result has one more, at 0."""
    assert len(STRENGTHS) + 1 <= N_STRENGTHS == len(obj.adaptive_fairing.strengths)
