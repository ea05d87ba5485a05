"""Results that are stored, shown, refined by a second run, kept and undone."""

import bpy
import numpy as np
import pytest
from support.objects import everything, key_positions
from support.objects import shown_positions as evaluated

from adaptive_fairing.blender.data import results
from adaptive_fairing.blender.data.display import display_of
from adaptive_fairing.blender.data.mesh_arrays import read_mesh_coordinates
from adaptive_fairing.blender.data.stored_path import StoredPath, stored_names
from adaptive_fairing.core import InputError

pytestmark = pytest.mark.usefixtures("addon")

STRENGTHS = [0.5, 1.0, 2.0]
ROUNDING = 1e-6


def moves(obj, seed=0):
    """Random displacements at the strengths, (k, n, 3)."""
    shape = (len(STRENGTHS), len(obj.data.vertices), 3)
    return np.random.default_rng(seed).normal(scale=0.1, size=shape).astype(np.float32)


def store(obj, way, strength=1.0, seed=0, **options):
    """Store displacements of what the object shows; give the start and the shapes."""
    start = display_of(obj).shown()
    shapes = list(start + moves(obj, seed))
    results.store(obj, StoredPath.through(start, STRENGTHS, shapes), strength, way, **options)
    return start, shapes


def store_steps(obj, start, shapes, way):
    """Store the steps of `fair`, and show the last one."""
    steps = range(1, len(shapes) + 1)
    results.store(obj, StoredPath.through(start, steps, shapes), steps[-1], way)


@pytest.mark.parametrize("way", ["LIVE", "MODIFIER"])
class TestStrengths:
    def test_each_is_shown_and_the_original_is_known(self, obj, way):
        start, shapes = store(obj, way)
        for strength, shape in zip(STRENGTHS, shapes, strict=True):
            obj.adaptive_fairing.strength = strength
            np.testing.assert_allclose(display_of(obj).shown(), shape, atol=ROUNDING)
            np.testing.assert_allclose(evaluated(obj), shape, atol=ROUNDING)
        np.testing.assert_array_equal(display_of(obj).original(), start)

    def test_a_second_run_adds_to_the_first_and_0_stays_the_first_original(self, obj, way):
        start, first = store(obj, way)
        second_start, second = store(obj, way, seed=1)
        np.testing.assert_allclose(second_start, first[1], atol=ROUNDING)
        np.testing.assert_allclose(display_of(obj).shown(), second[1], atol=ROUNDING)
        obj.adaptive_fairing.strength = 0.0
        np.testing.assert_allclose(display_of(obj).shown(), start, atol=ROUNDING)
        obj.adaptive_fairing.strength = 0.5  # half of each run
        expected = first[0] + (second[0] - second_start)
        np.testing.assert_allclose(display_of(obj).shown(), expected, atol=ROUNDING)

    def test_a_region_has_its_strength_for_itself(self, obj, way):
        start, _ = store(obj, way)
        obj.adaptive_fairing.strength = 0.5
        weights = np.linspace(0, 1, len(start), dtype=np.float32)[:, None]
        weights[:10], weights[-10:] = 0, 1
        second_start = display_of(obj).shown()
        shapes = list(second_start + weights * moves(obj, 1))
        results.store(
            obj,
            StoredPath.through(second_start, STRENGTHS, shapes),
            1.0,
            way,
            weights=weights[:, 0],
        )
        np.testing.assert_allclose(evaluated(obj), shapes[1], atol=ROUNDING)
        obj.adaptive_fairing.strength = 0.0
        expected = weights * start + (1 - weights) * second_start
        np.testing.assert_allclose(display_of(obj).shown(), expected, atol=ROUNDING)
        np.testing.assert_allclose(evaluated(obj), expected, atol=ROUNDING)
        for strength in (0.3, 2.0):
            obj.adaptive_fairing.strength = strength
            np.testing.assert_allclose(evaluated(obj)[:10], second_start[:10], atol=ROUNDING)
        np.testing.assert_array_equal(display_of(obj).original(), start)
        # A run on all takes both along.
        shown = display_of(obj).shown()
        results.store(obj, StoredPath.through(shown, [1.0], [1.1 * shown]), 1.0, way)
        np.testing.assert_allclose(evaluated(obj), 1.1 * shown, atol=2 * ROUNDING)
        obj.adaptive_fairing.strength = 0.0
        np.testing.assert_allclose(evaluated(obj), start, atol=ROUNDING)
        results.discard(obj)
        np.testing.assert_array_equal(read_mesh_coordinates(obj.data), start)

    def test_from_the_original_an_earlier_run_does_not_count(self, obj, way):
        start, _ = store(obj, way)
        shapes = list(start + moves(obj, 1))
        results.store(
            obj, StoredPath.through(start, STRENGTHS, shapes), 1.0, way, from_original=True
        )
        np.testing.assert_allclose(display_of(obj).shown(), shapes[1], atol=ROUNDING)

    def test_kept_only_the_shape_is_left(self, obj, way):
        plain = everything(obj)
        _, shapes = store(obj, way)
        results.apply(obj)
        assert not display_of(obj).is_whole
        np.testing.assert_allclose(read_mesh_coordinates(obj.data), shapes[1], atol=ROUNDING)
        assert {**everything(obj), "coordinates": plain["coordinates"]} == plain
        assert len(obj.modifiers) == len(bpy.data.node_groups) == 0

    def test_discarded_all_is_as_before(self, obj, way):
        before = everything(obj)
        store(obj, way)
        store(obj, way, seed=1)
        results.discard(obj)
        assert everything(obj) == before
        assert obj.adaptive_fairing.result == ""

    def test_where_its_shapes_are_lost_it_can_only_be_forgotten(self, obj, way):
        before = everything(obj)
        store(obj, way)
        for name in stored_names(obj.data):
            obj.data.attributes.remove(obj.data.attributes[name])
        with pytest.raises(InputError, match="no result"):
            results.apply(obj)
        shown = read_mesh_coordinates(obj.data)
        results.forget(obj)
        assert {**everything(obj), "coordinates": None} == {**before, "coordinates": None}
        np.testing.assert_array_equal(read_mesh_coordinates(obj.data), shown)
        assert (obj.adaptive_fairing.result, len(obj.modifiers)) == ("", 0)

    def test_a_plane_shows_the_original_behind_it(self, obj, way):
        start, shapes = store(obj, way)
        results.show_split(obj, (0.0, 0.0, 1.0), (0.0, 0.0, 0.05))
        expected = np.where(start[:, 2:] < np.float32(0.05), start, shapes[1])
        np.testing.assert_allclose(evaluated(obj), expected, atol=ROUNDING)


class TestSteps:
    @pytest.mark.parametrize("output", ["ABSOLUTE_KEYS", "RELATIVE_KEYS"])
    def test_they_are_keys_and_go_again(self, obj, output):
        before = everything(obj)
        start = read_mesh_coordinates(obj.data)
        shapes = list(start + moves(obj))
        store_steps(obj, start, shapes, output)
        for number, shape in enumerate(shapes, start=1):
            np.testing.assert_array_equal(key_positions(obj, f"Fairing {number}"), shape)
        np.testing.assert_array_equal(display_of(obj).original(), start)
        np.testing.assert_allclose(display_of(obj).shown(), shapes[-1], atol=ROUNDING)
        results.discard(obj)
        assert everything(obj) == before

    def test_the_final_shape_alone_is_no_result_and_leaves_no_keys(self, obj):
        start = read_mesh_coordinates(obj.data)
        shapes = list(start + moves(obj))
        store_steps(obj, start, [2 * start], "ABSOLUTE_KEYS")
        store_steps(obj, start, shapes, "FINAL_SHAPE")
        assert obj.data.shape_keys is None
        np.testing.assert_array_equal(read_mesh_coordinates(obj.data), shapes[-1])
        assert not display_of(obj).is_whole
        assert display_of(obj).original() is None

    def test_of_a_shape_that_was_denoised_before_the_first_original_is_kept(self, obj):
        original = read_mesh_coordinates(obj.data)
        _, denoised = store(obj, "LIVE")
        store_steps(obj, denoised[1], list(denoised[1] + moves(obj, 2)), "ABSOLUTE_KEYS")
        np.testing.assert_array_equal(display_of(obj).original(), original)
        results.discard(obj)
        np.testing.assert_array_equal(read_mesh_coordinates(obj.data), original)


def test_all_keys_of_the_user_move_along_when_a_modifier_s_result_is_kept(obj):
    obj.shape_key_add(name="Basis", from_mix=False)
    obj.shape_key_add(name="Smile", from_mix=False).points[2].co.z += 1.0
    obj.data.shape_keys.key_blocks["Smile"].value = 0.0
    before = {name: key_positions(obj, name) for name in ("Basis", "Smile")}
    start, shapes = store(obj, "MODIFIER")
    results.apply(obj)
    for name, positions in before.items():
        expected = positions + (shapes[1] - start)
        np.testing.assert_allclose(key_positions(obj, name), expected, atol=ROUNDING)
