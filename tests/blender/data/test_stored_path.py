"""The stored path of a result: linear between its knots, read as it was written."""

import numpy as np
import pytest
from support.meshes import icosphere
from support.objects import add_object

from adaptive_fairing.blender.data.mesh_arrays import (
    read_mesh_coordinates,
    read_values,
    remove_attributes,
)
from adaptive_fairing.blender.data.stored_path import (
    ORIGINAL,
    StoredPath,
    has_offsets,
    offset_name,
    read_path,
    stored_names,
    write_path,
)

KNOTS = (0.5, 1.0, 2.0)


@pytest.fixture
def mesh():
    return add_object(*icosphere(1)).data


@pytest.fixture
def shapes(mesh):
    """Random shapes in eighths, of which sums and differences in single precision are exact."""
    rng = np.random.default_rng(5)
    n = len(mesh.vertices)
    return [(rng.integers(-8, 9, (n, 3)) / 8).astype(np.float32) for _ in (0.0, *KNOTS)]


@pytest.fixture
def path(shapes):
    return StoredPath.through(shapes[0], KNOTS, shapes[1:])


@pytest.mark.parametrize("place", [0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 5.0])
def test_it_is_linear_between_knots_and_stays_beyond_the_last(path, shapes, place):
    flat = np.reshape(shapes, (len(shapes), -1))
    expected = [np.interp(place, (0.0, *KNOTS), column) for column in flat.T]
    np.testing.assert_array_equal((shapes[0] + path.offset(place)).ravel(), expected)


@pytest.mark.parametrize("place", [0.0, 0.25, 0.5, 2.0])
def test_a_first_knot_at_0_is_where_it_begins(shapes, place):
    path = StoredPath.through(shapes[0], (0.0, *KNOTS[1:]), shapes[1:])
    flat = np.reshape(shapes[1:], (len(KNOTS), -1))
    expected = [np.interp(place, (0.0, *KNOTS[1:]), column) for column in flat.T]
    np.testing.assert_array_equal((shapes[0] + path.offset(place)).ravel(), expected)


def test_the_offset_may_be_changed(path):
    for place in (0.25, 0.5, 1.5, 2.0):
        before = path.offset(place)
        path.offset(place)[:] = 7.0
        np.testing.assert_array_equal(path.offset(place), before)


def test_the_way_through_shapes_of_any_size_is_exact():
    rng = np.random.default_rng(1)
    start, shape = (rng.normal(size=(50, 3)).astype(np.float32) for _ in range(2))
    path = StoredPath.through(1000 * start, (1.0,), [shape])
    np.testing.assert_array_equal((1000 * start + path.offset_at(0)).astype(np.float32), shape)


def test_what_was_written_is_read_again(mesh, path):
    write_path(mesh, path)
    found = read_path(mesh, read_values(mesh.attributes[ORIGINAL]), KNOTS)
    np.testing.assert_array_equal(found.original, path.original)
    for index in range(len(KNOTS)):
        np.testing.assert_array_equal(found.offset_at(index), path.offset_at(index))


def test_a_missing_offset_is_seen(mesh, path):
    assert not has_offsets(mesh, len(KNOTS))
    write_path(mesh, path)
    assert has_offsets(mesh, len(KNOTS))
    assert not has_offsets(mesh, 0)
    mesh.attributes.remove(mesh.attributes[offset_name(2)])
    assert not has_offsets(mesh, len(KNOTS))


def test_removed_it_leaves_no_attribute_and_the_coordinates(mesh, path):
    before, names = read_mesh_coordinates(mesh), mesh.attributes.keys()
    write_path(mesh, path, with_original=False)
    assert stored_names(mesh) == [offset_name(1), offset_name(2), offset_name(3)]
    remove_attributes(mesh, stored_names(mesh))
    assert mesh.attributes.keys() == names
    np.testing.assert_array_equal(read_mesh_coordinates(mesh), before)
