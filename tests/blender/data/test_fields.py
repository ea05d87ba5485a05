"""Fields of the shown shape, against what is known of balls."""

import numpy as np
import pytest
from support.meshes import icosphere
from support.objects import add_object

from adaptive_fairing.blender.data import results, shown_surface
from adaptive_fairing.blender.data.display import display_of
from adaptive_fairing.blender.data.fields import measure_field
from adaptive_fairing.blender.data.mesh_arrays import read_mesh_coordinates
from adaptive_fairing.blender.data.stored_path import StoredPath
from adaptive_fairing.core import FairingSettings, InputError

pytestmark = pytest.mark.usefixtures("addon")

SETTINGS = FairingSettings()
RADIUS = 2.0


@pytest.fixture
def obj():
    """A ball of which a result has taken a tenth of the radius off the upper half."""
    vertices, faces = icosphere(3)
    obj = add_object(RADIUS * vertices, faces)
    start = read_mesh_coordinates(obj.data)
    shape = np.where(start[:, 2:] > 0, 0.9 * start, start)
    results.store(obj, StoredPath.through(start, [1.0], [shape]), 1.0, "LIVE")
    return obj


def test_displacement_is_the_way_from_the_original(obj):
    is_upper = display_of(obj).original()[:, 2] > 0
    found = measure_field(obj, "DISPLACEMENT", SETTINGS).values
    np.testing.assert_allclose(found, np.where(is_upper, 0.1 * RADIUS, 0.0), atol=1e-6)


def test_removed_is_positive_where_a_bump_was_taken_off(obj):
    height = display_of(obj).original()[:, 2]
    found = measure_field(obj, "REMOVED", SETTINGS).values
    inner = np.abs(height) > 0.3 * RADIUS  # where the normals are those of a ball
    expected = np.where(height > 0, 0.1 * RADIUS, 0.0)
    np.testing.assert_allclose(found[inner], expected[inner], rtol=1e-2, atol=1e-3)


def test_curvatures_of_a_ball_are_those_of_its_radius():
    vertices, faces = icosphere(4)
    obj = add_object(RADIUS * vertices, faces)
    np.testing.assert_allclose(
        measure_field(obj, "CURVATURE", SETTINGS).values, 1 / RADIUS, rtol=0.02
    )
    np.testing.assert_allclose(
        measure_field(obj, "GAUSSIAN", SETTINGS).values, 1 / RADIUS**2, rtol=0.04
    )


def test_density_has_no_unit_and_loose_vertices_have_none():
    vertices, faces = icosphere(2)
    loose = np.concatenate([vertices, [[0.1, 0.2, 0.3]]])
    small = measure_field(add_object(loose, faces), "DENSITY", SETTINGS).values
    large = measure_field(add_object(7 * loose, faces), "DENSITY", SETTINGS).values
    assert np.isnan(small[-1]) and np.isfinite(small[:-1]).all()
    np.testing.assert_allclose(small, large, rtol=1e-5)


def test_on_a_refined_mesh_the_curvature_is_that_of_the_same_surface(obj):
    """The control vertices are the first of the refined mesh."""
    expected = measure_field(obj, "CURVATURE", SETTINGS).values
    obj.adaptive_fairing.surface = "REFINED_1"
    shown_surface.refine_result(display_of(obj))
    found = measure_field(obj, "CURVATURE", SETTINGS).values
    assert len(found) == len(obj.data.vertices) > len(expected)
    np.testing.assert_allclose(found[: len(expected)], expected, atol=1e-4 * np.ptp(expected))


def test_without_faces_only_the_displacement_has_values():
    obj = add_object(icosphere(0)[0], [])
    assert not measure_field(obj, "DISPLACEMENT", SETTINGS).values.any()
    for field in ("DENSITY", "REMOVED", "CURVATURE", "GAUSSIAN"):
        with pytest.raises(InputError, match="no faces"):
            measure_field(obj, field, SETTINGS)
