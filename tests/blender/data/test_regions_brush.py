"""Region under a brush: soft in a ball, within a face set, and where nothing is hidden."""

import bpy
import numpy as np
import pytest
from support.meshes import flat_grid, noisy_ball
from support.objects import add_object
from support.results import coordinates

from adaptive_fairing.blender.data.regions import FACE_SET, FULL_PART, BrushRegion

pytestmark = pytest.mark.usefixtures("addon")

CENTRE, RADIUS = (0.0, 0.0, 1.0), 0.6


@pytest.fixture
def ball():
    obj = add_object(*noisy_ball(4, 0.02))
    obj.select_set(True)
    return obj


def from_centre(obj):
    return np.linalg.norm(coordinates(obj) - CENTRE, axis=1)


def with_faces(obj, name, values):
    """Give every face a value of an attribute."""
    attribute = obj.data.attributes.new(name, "INT", "FACE")
    attribute.data.foreach_set("value", np.asarray(values, dtype=np.int32))


def test_it_is_whole_in_the_middle_and_falls_to_0_at_the_border(ball):
    weights = BrushRegion(CENTRE, RADIUS, 0).weights(ball.data)
    away = from_centre(ball) / RADIUS
    assert (weights[away < FULL_PART - 1e-5] == 1).all()
    assert (weights[away > 1 + 1e-5] == 0).all()
    between = np.flatnonzero((away > FULL_PART) & (away < 1))
    ordered = weights[between[np.argsort(away[between])]]
    assert len(between) > 20
    assert (np.diff(ordered) < 1e-6).all()
    halfway = (1 + FULL_PART) / 2
    assert np.interp(halfway, np.sort(away[between]), ordered) == pytest.approx(0.5, abs=0.05)


def test_a_face_set_ends_it_at_its_border():
    vertices, faces = flat_grid(9, 9)
    obj = add_object(vertices, faces)
    is_right = vertices[faces].mean(axis=1)[:, 0] > vertices[:, 0].mean()
    with_faces(obj, FACE_SET, np.where(is_right, 7, 3))
    middle = tuple(vertices.mean(axis=0).tolist())
    for side in (False, True):
        pointed = int(np.flatnonzero(is_right == side)[0])
        weights = BrushRegion(middle, 1e3, pointed).weights(obj.data)
        of_others = np.zeros(len(vertices), dtype=bool)
        of_others[faces[is_right != side]] = True
        assert np.array_equal(weights > 0, ~of_others)


def test_hidden_vertices_are_left_out(ball):
    hidden = ball.data.attributes.new(".hide_vert", "BOOLEAN", "POINT")
    is_hidden = coordinates(ball)[:, 0] > 0
    hidden.data.foreach_set("value", is_hidden)
    weights = BrushRegion(CENTRE, RADIUS, 0).weights(ball.data)
    assert (weights[is_hidden] == 0).all()
    assert (weights[~is_hidden] > 0).any()


def test_a_run_moves_what_is_under_the_brush_alone_and_not_the_mask(ball):
    before = coordinates(ball)
    mask = (before[:, 0] > 0).astype(np.float32)
    ball.data.attributes.new(".sculpt_mask", "FLOAT", "POINT").data.foreach_set("value", mask)
    bpy.ops.object.mode_set(mode="SCULPT")
    brush = {"brush_centre": CENTRE, "brush_radius": RADIUS, "clean": "denoise"}
    assert bpy.ops.object.adaptive_fairing(**brush) == {"FINISHED"}
    assert ball.mode == "SCULPT"
    bpy.ops.object.mode_set(mode="OBJECT")
    after = coordinates(ball)
    has_moved = (after != before).any(axis=1)
    is_inside = (np.linalg.norm(before - CENTRE, axis=1) < RADIUS) & (mask == 0)
    assert not has_moved[~is_inside].any()
    middle = np.linalg.norm(before - CENTRE, axis=1) < FULL_PART * RADIUS
    rough, smooth = (
        np.abs(np.linalg.norm(each[middle & (mask == 0)], axis=1) - 1).std()
        for each in (before, after)
    )
    assert smooth < 0.5 * rough


def test_the_next_run_has_no_brush(ball):
    bpy.ops.object.adaptive_fairing(brush_centre=CENTRE, brush_radius=RADIUS, clean="denoise")
    bpy.ops.object.adaptive_fairing_discard()
    before = coordinates(ball)
    bpy.ops.object.adaptive_fairing()
    assert (coordinates(ball) != before).any(axis=1).mean() > 0.9


def test_it_is_for_sculpt_mode(ball):
    with pytest.raises(RuntimeError, match="Change to Sculpt Mode"):
        bpy.ops.object.adaptive_fairing_brush("INVOKE_DEFAULT")
