"""Results as earlier states of the add-on have saved them go on working."""

import bpy
import numpy as np
import pytest
from support.layouts import draw
from support.meshes import icosphere
from support.objects import add_object, shown_positions

from adaptive_fairing.blender.data import earlier_files, results
from adaptive_fairing.blender.data.display import display_of
from adaptive_fairing.blender.data.mesh_arrays import checksum, read_mesh_coordinates
from adaptive_fairing.blender.data.results import result_measures
from adaptive_fairing.blender.data.shape_keys import (
    animate_evolution,
    write_absolute_keys,
    write_relative_keys,
)
from adaptive_fairing.blender.data.stored_path import StoredPath, stored_names
from adaptive_fairing.blender.ui import settings_panel

pytestmark = pytest.mark.usefixtures("addon")


def make_earlier(obj):
    """Note on the object what the mesh shows, and name the attributes without a dot."""
    record, shown = obj.adaptive_fairing, obj.data.adaptive_fairing
    record.checksum, record.stored_strength = shown.checksum, shown.strength
    record.refined_print, record.refined_fingerprint = record.refined_fingerprint, ""
    for mesh in {obj.data, record.control} - {None}:
        mesh.property_unset("adaptive_fairing")
        for name in stored_names(mesh):
            mesh.attributes[name].name = name.removeprefix(".")


@pytest.mark.parametrize("surface", ["CONTROL", "REFINED_1"])
def test_strength_and_discard_work_as_if_nothing_had_been(surface):
    obj = add_object(*icosphere(1))
    start = read_mesh_coordinates(obj.data)
    results.store(obj, StoredPath.through(start, [1.0], [0.8 * start]), 1.0, "LIVE")
    with results.on_control(obj):
        obj.adaptive_fairing.surface = surface
    shown = {}
    for strength in (0.0, 0.4, 0.9):
        obj.adaptive_fairing.strength = strength
        shown[strength] = shown_positions(obj)
    make_earlier(obj)
    assert not display_of(obj).is_whole
    earlier_files.adopt()
    assert display_of(obj).goes_on
    assert obj.adaptive_fairing.strength == np.float32(0.9)
    for strength, positions in shown.items():
        obj.adaptive_fairing.strength = strength
        np.testing.assert_array_equal(shown_positions(obj), positions)
    assert results.discard(obj) is None  # no refined mesh that somebody has changed
    np.testing.assert_array_equal(read_mesh_coordinates(obj.data), start)


def test_a_refined_mesh_with_steps_is_not_taken_for_changed():
    """Of strengths before the steps the record has kept the checksum of the coordinates."""
    obj = add_object(*icosphere(1))
    start = read_mesh_coordinates(obj.data)
    results.store(obj, StoredPath.through(start, [1.0], [0.8 * start]), 1.0, "ABSOLUTE_KEYS")
    with results.on_control(obj):
        obj.adaptive_fairing.surface = "REFINED_1"
    make_earlier(obj)
    obj.adaptive_fairing.checksum = checksum(start)
    earlier_files.adopt()
    assert display_of(obj).is_refined
    assert results.discard(obj) is None


@pytest.mark.parametrize("way", ["LIVE", "MODIFIER", "ABSOLUTE_KEYS"])
def test_before_ends_where_the_slider_was_held(way):
    obj = add_object(*icosphere(1))
    start = read_mesh_coordinates(obj.data)
    path = StoredPath.through(start, [1.0, 2.0], [0.8 * start, 0.6 * start])
    results.store(obj, path, 1.0, way)
    record, shown = obj.adaptive_fairing, shown_positions(obj)
    slider = display_of(obj).slider
    held = getattr(record, slider)
    setattr(record, slider, 0.0)
    make_earlier(obj)
    record.held = held
    earlier_files.adopt()
    assert getattr(record, slider) == held
    np.testing.assert_array_equal(shown_positions(obj), shown)
    setattr(record, slider, 0.0)
    earlier_files.adopt()  # when the file is opened again, all of this is done
    assert getattr(record, slider) == 0


STRENGTHS = (0.0, 0.5, 1.0, 2.0)
STEPS = (0.0, 0.0, 0.0, 0.0)


def make_earlier_keys(strengths, write=write_absolute_keys):
    """Make an object as commit 377f40e left it: shape keys and a record, with no result."""
    obj = add_object(*icosphere(1))
    start = read_mesh_coordinates(obj.data)
    shapes = [np.float32(1 - 0.1 * number) * start for number in range(len(strengths))]
    write(obj, shapes[1:], 1)
    record = obj.adaptive_fairing
    for number, strength in enumerate(strengths):
        step = record.steps.add()
        step.strength, step.area, step.volume = strength, 10.0 - number, 5.0 - number
    record.chosen, record.noise = 2, 0.2
    return obj, shapes


def take_keys():
    assert bpy.ops.object.adaptive_fairing_take_keys() == {"FINISHED"}
    assert not bpy.ops.object.adaptive_fairing_take_keys.poll()


class TestKeys:
    def test_the_panel_has_one_line_and_a_button_until_it_is_pressed(self):
        make_earlier_keys(STRENGTHS)
        name, line = "object.adaptive_fairing_take_keys", "run by an earlier version"
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        assert line in " ".join(drawn.texts)
        assert [each["name"] for each in drawn.operators].count(name) == 1
        take_keys()
        drawn = draw(settings_panel.VIEW3D_PT_adaptive_fairing)
        assert name not in [each["name"] for each in drawn.operators]
        assert "object.adaptive_fairing_discard" in [each["name"] for each in drawn.operators]

    def test_strengths_get_their_slider_and_no_keys(self):
        obj, shapes = make_earlier_keys(STRENGTHS)
        record = obj.adaptive_fairing
        take_keys()
        assert obj.data.shape_keys is None
        assert (record.strength, record.shown, record.noise) == (1.0, 2, np.float32(0.2))
        for strength, shape in zip(STRENGTHS, shapes, strict=True):
            record.strength = strength
            np.testing.assert_array_equal(shown_positions(obj), shape)
        assert result_measures(record).area == 7.0
        bpy.ops.object.adaptive_fairing_discard()
        np.testing.assert_array_equal(read_mesh_coordinates(obj.data), shapes[0])

    def test_the_shape_between_two_strengths_stays(self):
        obj, shapes = make_earlier_keys(STRENGTHS)
        keys = obj.data.shape_keys
        keys.eval_time = 0.5 * (keys.key_blocks[2].frame + keys.key_blocks[3].frame)
        take_keys()
        assert obj.adaptive_fairing.strength == pytest.approx(1.5)
        middle = 0.5 * (shapes[2] + shapes[3])
        np.testing.assert_allclose(shown_positions(obj), middle, rtol=0, atol=1e-6)

    def test_steps_get_the_evolution(self):
        obj, shapes = make_earlier_keys(STEPS)
        record = obj.adaptive_fairing
        take_keys()
        assert display_of(obj).goes_on
        assert record.evolution == pytest.approx(2 / 3)
        assert result_measures(record).area == pytest.approx(8.0)
        record.evolution = 1.0
        np.testing.assert_array_equal(shown_positions(obj), shapes[-1])
        bpy.ops.object.adaptive_fairing_discard()
        np.testing.assert_array_equal(read_mesh_coordinates(obj.data), shapes[0])
        assert obj.data.shape_keys is None

    def test_animated_strengths_go_on_being_played(self):
        obj, _ = make_earlier_keys(STRENGTHS)
        animate_evolution(obj, 1, 31)
        take_keys()
        bpy.context.scene.frame_set(21)
        record = obj.adaptive_fairing
        assert record.evolution == pytest.approx(2 / 3)
        assert result_measures(record).area == pytest.approx(8.0)

    def test_relative_keys_stay(self):
        obj, shapes = make_earlier_keys(STRENGTHS, write_relative_keys)
        take_keys()
        np.testing.assert_array_equal(shown_positions(obj), shapes[2])
        bpy.ops.object.adaptive_fairing_discard()
        np.testing.assert_array_equal(read_mesh_coordinates(obj.data), shapes[0])

    def test_another_object_keeps_the_keys_of_a_shared_mesh(self):
        obj, _ = make_earlier_keys(STRENGTHS)
        other = obj.copy()
        bpy.context.collection.objects.link(other)
        take_keys()
        assert earlier_files.has_earlier_keys(other)

    def test_keys_of_somebody_else_are_not_taken(self):
        obj, _ = make_earlier_keys(STRENGTHS)
        obj.shape_key_add(name="Smile")
        assert not bpy.ops.object.adaptive_fairing_take_keys.poll()
