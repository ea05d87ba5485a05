"""The stored offsets of `denoise`: linear between strengths, and known to be stale."""

import numpy as np
import pytest
from support.meshes import icosphere
from support.objects import add_object

from adaptive_fairing.blender.data import stored_offsets
from adaptive_fairing.blender.data.mesh_arrays import read_mesh_coordinates
from adaptive_fairing.blender.data.record_functions import set_strengths
from adaptive_fairing.blender.data.stored_offsets import (
    PAINT_GROUP,
    StoredResult,
    checksum,
    is_current,
    paint_group,
    read_stored,
    remove_stored,
    shown_by,
    update_shown,
    write_shown,
    write_stored,
)
from adaptive_fairing.blender.data.vertex_groups import add_weights

pytestmark = pytest.mark.usefixtures("addon")

STRENGTHS = (0.5, 1.0, 2.0)


@pytest.fixture
def obj():
    """A ball with a stored result, shown at strength 1."""
    obj = add_object(*icosphere(1))
    write_stored(obj.data, stored(obj), with_original=True)
    record = obj.adaptive_fairing
    record.result = "LIVE"
    set_strengths(record, STRENGTHS, 1.0)
    write_shown(obj, shown_by_hand(obj, 1.0))
    return obj


def stored(obj):
    """Random offsets in eighths, so that sums in single precision are exact."""
    rng = np.random.default_rng(5)
    n = len(obj.data.vertices)
    offsets = [(rng.integers(-8, 9, (n, 3)) / 8).astype(np.float32) for _ in STRENGTHS]
    return StoredResult(
        np.round(8 * read_mesh_coordinates(obj.data)) / 8, STRENGTHS, tuple(offsets)
    )


def shown_by_hand(obj, strength):
    """Interpolate linearly with numpy, one coordinate after the other."""
    result = read_stored_unchecked(obj)
    shapes = np.stack([np.zeros_like(result.original), *result.offsets])
    flat = shapes.reshape(len(shapes), -1)
    moved = [np.interp(strength, (0.0, *STRENGTHS), column) for column in flat.T]
    return (result.original.ravel() + moved).reshape(-1, 3).astype(np.float32)


def read_stored_unchecked(obj):
    offsets = [
        stored_offsets.read_vectors(obj.data, stored_offsets.offset_name(i + 1))
        for i in range(len(STRENGTHS))
    ]
    original = stored_offsets.read_vectors(obj.data, stored_offsets.ORIGINAL)
    return StoredResult(original, STRENGTHS, tuple(offsets))


def test_what_was_stored_is_read_again(obj):
    found, expected = read_stored(obj), read_stored_unchecked(obj)
    assert found.strengths == STRENGTHS
    np.testing.assert_array_equal(found.original, expected.original)
    for offset, other in zip(found.offsets, expected.offsets, strict=True):
        np.testing.assert_array_equal(offset, other)


@pytest.mark.parametrize("strength", [0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 5.0])
def test_the_shape_is_linear_between_strengths_and_stays_beyond_the_last(obj, strength):
    obj.adaptive_fairing.stored_strength = strength
    np.testing.assert_array_equal(shown_by(obj), shown_by_hand(obj, strength))


def test_painted_weights_scale_the_offset(obj):
    group = paint_group(obj)
    assert group.name == PAINT_GROUP
    np.testing.assert_array_equal(shown_by(obj), shown_by_hand(obj, 1.0))  # a new one shows all
    n = len(obj.data.vertices)
    add_weights(group, range(n), np.full(n, 0.25, dtype=np.float32))
    stored_offsets.forget_weights()
    original = read_stored(obj).original
    expected = original + 0.25 * (shown_by_hand(obj, 1.0) - original)
    np.testing.assert_allclose(shown_by(obj), expected, atol=1e-6)


def test_a_plane_parts_original_and_result(obj):
    record = obj.adaptive_fairing
    record.is_split, record.split_normal, record.split_point = True, (0, 0, 1), (0, 0, 0.25)
    original = read_stored(obj).original
    is_behind = original[:, 2] < 0.25
    assert 0 < is_behind.sum() < len(is_behind)
    expected = np.where(is_behind[:, None], original, shown_by_hand(obj, 1.0))
    np.testing.assert_array_equal(shown_by(obj), expected)


def test_a_vertex_that_somebody_moved_makes_it_stale_and_is_not_written_over(obj):
    assert is_current(obj)
    obj.data.vertices[3].co.x += 0.5
    before = read_mesh_coordinates(obj.data)
    assert not is_current(obj)
    assert read_stored(obj) is None
    assert not update_shown(obj)
    np.testing.assert_array_equal(read_mesh_coordinates(obj.data), before)


@pytest.mark.parametrize("name", [stored_offsets.ORIGINAL, stored_offsets.offset_name(2)])
def test_a_missing_attribute_makes_it_stale(obj, name):
    obj.data.attributes.remove(obj.data.attributes[name])
    assert not is_current(obj)


def test_the_checksum_tells_the_order_and_the_number_of_points():
    points = np.arange(12, dtype=np.float32).reshape(-1, 3)
    known = {checksum(points), checksum(points[::-1]), checksum(points[:-1]), checksum(points + 1)}
    assert len(known) == 4
    assert checksum(points.copy()) == checksum(points)


def test_removed_it_leaves_no_attribute_and_the_coordinates(obj):
    before = read_mesh_coordinates(obj.data)
    remove_stored(obj.data)
    assert not [name for name in obj.data.attributes.keys() if "fairing" in name]
    np.testing.assert_array_equal(read_mesh_coordinates(obj.data), before)
