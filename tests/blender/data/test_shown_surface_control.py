"""The control mesh behind a refined result."""

import numpy as np
import pytest
from support.meshes import icosphere
from support.objects import add_object, everything

from adaptive_fairing.blender.data import results, shown_surface
from adaptive_fairing.blender.data.display import display_of
from adaptive_fairing.blender.data.mesh_arrays import read_mesh_coordinates
from adaptive_fairing.blender.data.shown_surface import control_read, net_fingerprint
from adaptive_fairing.blender.data.stored_path import StoredPath

pytestmark = pytest.mark.usefixtures("addon")


@pytest.fixture
def obj():
    """A ball with a result that is shown on a refined mesh."""
    obj = add_object(*icosphere(1))
    start = read_mesh_coordinates(obj.data)
    results.store(obj, StoredPath.through(start, [1.0], [0.8 * start]), 1.0, "LIVE")
    obj.adaptive_fairing.surface = "REFINED_1"
    shown_surface.refine_result(display_of(obj))
    return obj


def test_inside_the_object_has_its_control_mesh_at_the_strength_of_now(obj):
    vertices, _ = icosphere(1)
    obj.adaptive_fairing.strength = 0.5
    before, refined = everything(obj), obj.data
    assert display_of(obj).is_refined
    with control_read(display_of(obj)):
        assert obj.data != refined
        np.testing.assert_allclose(read_mesh_coordinates(obj.data), 0.9 * vertices, atol=1e-6)
    assert obj.data == refined
    assert everything(obj) == before
    assert display_of(obj).is_refined
    assert display_of(obj).is_whole


def test_an_error_inside_brings_the_refined_mesh_back_too(obj):
    refined = obj.data
    with pytest.raises(RuntimeError, match="inside"), control_read(display_of(obj)):
        raise RuntimeError("inside")
    assert obj.data == refined and display_of(obj).is_refined


def test_without_a_refined_mesh_nothing_changes():
    obj = add_object(*icosphere(0))
    mesh = obj.data
    with control_read(display_of(obj)):
        assert obj.data == mesh
    assert not display_of(obj).is_refined


def test_nets_of_other_sizes_have_other_prints(obj):
    meshes = [add_object(*icosphere(levels)).data for levels in (0, 1, 2)]
    assert len({net_fingerprint(mesh) for mesh in meshes}) == 3
    assert net_fingerprint(meshes[2]) == net_fingerprint(obj.data)  # icosphere(1), refined once
