"""The line of a split: where it lies, and what the original is shown of when it is dragged."""

import bpy
import numpy as np
import pytest
from mathutils import Euler, Matrix, Vector
from support.meshes import noisy_ball
from support.objects import add_object
from support.results import coordinates

from adaptive_fairing.blender.ui.split_line import (
    OVERHANG,
    SplitPlane,
    VIEW3D_GGT_adaptive_fairing_split,
    split_at,
)

pytestmark = pytest.mark.usefixtures("addon")

SIGHT = Vector((0.3, 0.9, -0.2))


@pytest.fixture
def split():
    """A denoised ball that is turned, stretched and split, and its original."""
    obj = add_object(*noisy_ball(3, 0.02))
    obj.select_set(True)
    obj.location, obj.scale = (5.0, -3.0, 2.0), (1.0, 2.0, 3.0)
    obj.rotation_euler = Euler((0.3, 0.5, 0.7))
    bpy.context.view_layer.update()
    original = coordinates(obj)
    bpy.ops.object.adaptive_fairing()
    bpy.ops.object.adaptive_fairing_split()
    return obj, original


def world(obj, positions):
    matrix = np.array(obj.matrix_world)
    return positions @ matrix[:3, :3].T + matrix[:3, 3]


def test_the_plane_is_that_which_the_object_is_split_by(split):
    obj, original = split
    plane = SplitPlane.of(obj)
    heights = (world(obj, original) - plane.point) @ np.array(plane.normal)
    is_original = (coordinates(obj) == original).all(axis=1)
    clear = np.abs(heights) > 1e-4
    assert np.array_equal(is_original[clear], heights[clear] < 0)
    assert 0.4 < is_original.mean() < 0.6


def test_the_line_is_in_the_plane_across_the_sight_and_beyond_the_box(split):
    obj, _ = split
    plane = SplitPlane.of(obj)
    start, end = plane.line(SIGHT)
    for each in (start, end):
        assert (each - plane.point).dot(plane.normal) == pytest.approx(0.0, abs=1e-5)
    along = (end - start).normalized()
    assert along.dot(SIGHT) == pytest.approx(0.0, abs=1e-5)
    heights = [(corner - start).dot(along) for corner in plane.corners]
    margin = OVERHANG * (max(heights) - min(heights))
    assert min(heights) == pytest.approx(margin, rel=1e-4)
    assert (end - start).length - max(heights) == pytest.approx(margin, rel=1e-4)


def test_there_is_no_line_for_who_looks_at_the_plane(split):
    plane = SplitPlane.of(split[0])
    assert plane.line(plane.normal) is None
    assert plane.line(-3 * plane.normal) is None


def test_it_moves_along_its_normal_and_stays_in_the_box(split):
    plane = SplitPlane.of(split[0])
    across = plane.along(SIGHT)
    moved = plane.moved(0.2 * plane.normal + 0.7 * across)
    assert (moved.point - plane.point - 0.2 * plane.normal).length < 1e-5
    heights = [(corner - plane.point).dot(plane.normal) for corner in plane.corners]
    for way, most in ((1000.0, max(heights)), (-1000.0, min(heights))):
        far = plane.moved(way * plane.normal).point
        assert (far - plane.point).dot(plane.normal) == pytest.approx(most, rel=1e-4)


def test_after_a_drag_the_eye_looks_along_the_plane(split):
    obj, original = split
    plane, eye = SplitPlane.of(obj), Vector((5.0, -20.0, 6.0))
    along = plane.along(plane.point - eye)
    moved = plane.moved(0.5 * plane.normal)
    turned = moved.turned(along, moved.point - eye)
    assert turned.normal.dot(plane.normal) > 0.5, "left stays left"
    assert turned.normal.dot(eye - turned.point) == pytest.approx(0.0, abs=1e-4)
    assert turned.normal.dot(along) == pytest.approx(0.0, abs=1e-5)
    split_at(obj, turned)
    now = SplitPlane.of(obj)
    assert (now.point - turned.point).length < 1e-5
    assert now.normal.dot(turned.normal) == pytest.approx(1.0, abs=1e-5)
    heights = (world(obj, original) - turned.point) @ np.array(turned.normal)
    clear = np.abs(heights) > 1e-4
    is_original = (coordinates(obj) == original).all(axis=1)
    assert np.array_equal(is_original[clear], heights[clear] < 0)


def test_it_is_there_as_long_as_the_split_is(split):
    poll = VIEW3D_GGT_adaptive_fairing_split.poll
    assert poll(bpy.context)
    bpy.ops.object.adaptive_fairing_split()
    assert not poll(bpy.context)
    bpy.ops.object.adaptive_fairing_split()
    bpy.ops.object.mode_set(mode="WEIGHT_PAINT")
    assert not poll(bpy.context)
    bpy.ops.object.mode_set(mode="OBJECT")
    split[0].data.transform(Matrix.Translation((1.0, 0.0, 0.0)))  # as by hand
    assert not poll(bpy.context)
    bpy.context.view_layer.objects.active = None
    assert not poll(bpy.context)
