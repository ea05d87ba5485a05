"""Results as earlier states of the add-on have saved them go on working."""

import numpy as np
import pytest
from support.meshes import icosphere
from support.objects import add_object, shown_positions

from adaptive_fairing.blender.data import earlier_files, results, shown_surface
from adaptive_fairing.blender.data.display import display_of
from adaptive_fairing.blender.data.mesh_arrays import read_mesh_coordinates
from adaptive_fairing.blender.data.stored_path import stored_names

pytestmark = pytest.mark.usefixtures("addon")


def make_earlier(obj):
    """Note on the object what the mesh shows, and name the attributes without a dot."""
    record, shown = obj.adaptive_fairing, obj.data.adaptive_fairing
    record.checksum, record.stored_strength = shown.checksum, shown.strength
    for mesh in {obj.data, record.control} - {None}:
        mesh.property_unset("adaptive_fairing")
        for name in stored_names(mesh):
            mesh.attributes[name].name = name.removeprefix(".")


@pytest.mark.parametrize("surface", ["CONTROL", "REFINED_1"])
def test_strength_and_discard_work_as_if_nothing_had_been(surface):
    obj = add_object(*icosphere(1))
    start = read_mesh_coordinates(obj.data)
    results.store_strengths(obj, start, [0.8 * start], [1.0], 1.0, "LIVE")
    shown_surface.show_surface(obj, surface)
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
    shown_surface.show_control(obj)
    results.discard(obj)
    np.testing.assert_array_equal(read_mesh_coordinates(obj.data), start)
