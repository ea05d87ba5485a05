"""The surface that shows a result, and the way back to the control mesh."""

import bpy
import numpy as np
import pytest
from support.meshes import icosphere
from support.objects import add_object, everything

from adaptive_fairing.blender.data import results
from adaptive_fairing.blender.data.coloring import color_by_field
from adaptive_fairing.blender.data.display import display_of
from adaptive_fairing.blender.data.mesh_arrays import read_mesh_coordinates, read_values
from adaptive_fairing.blender.data.shown_surface import (
    show_control,
)
from adaptive_fairing.blender.data.stored_path import StoredPath
from adaptive_fairing.core import FairingSettings, LimitSurface, TriangleTopology
from adaptive_fairing.core.surface import memory_estimate

pytestmark = pytest.mark.usefixtures("addon")


@pytest.fixture
def obj():
    obj = add_object(*icosphere(1))
    start = read_mesh_coordinates(obj.data)
    shape = start * np.float32([0.8, 0.9, 1.1])
    results.store(obj, StoredPath.through(start, [1.0], [shape]), 1.0, "LIVE")
    return obj


def show_surface(obj, name):
    """Show the result on a surface."""
    with results.on_control(obj):
        obj.adaptive_fairing.surface = name


@pytest.mark.parametrize(("name", "levels"), [("LIMIT", 0), ("REFINED_1", 1), ("REFINED_2", 2)])
def test_the_result_is_on_the_limit_surface_at_every_strength(obj, name, levels):
    vertices, triangles = icosphere(1)
    show_surface(obj, name)
    for strength in (0.0, 0.5, 1.0):
        obj.adaptive_fairing.strength = strength
        shape = vertices * (1 + strength * np.array([-0.2, -0.1, 0.1]))
        limit = LimitSurface(TriangleTopology(triangles, len(vertices)), shape).refined(levels)
        np.testing.assert_allclose(read_mesh_coordinates(obj.data), limit.vertices, atol=2e-6)


def test_the_control_mesh_comes_back_bit_by_bit_and_the_other_goes(obj):
    before = everything(obj)
    show_surface(obj, "REFINED_2")
    assert show_control(display_of(obj)) is None
    assert everything(obj) == before
    assert list(bpy.data.meshes) == [obj.data]


def test_a_refined_mesh_that_somebody_changed_stays_in_the_file(obj):
    show_surface(obj, "REFINED_1")
    obj.data.attributes.new("mine", "FLOAT", "POINT").data[0].value = 1.0
    kept = show_control(display_of(obj))
    assert bpy.data.meshes[kept].use_fake_user
    assert "mine" in bpy.data.meshes[kept].attributes
    assert len(obj.data.vertices) == len(icosphere(1)[0])


def test_another_result_is_refined_after_it_was_written(obj):
    show_surface(obj, "REFINED_1")
    n = len(obj.data.vertices)
    with results.on_control(obj, for_run=True) as shown:
        start = display_of(obj).shown()
        assert len(start) == len(icosphere(1)[0])
        results.store(obj, StoredPath.through(start, [1.0], [0.5 * start]), 1.0, "LIVE")
    assert shown.kept is None
    assert len(obj.data.vertices) == n
    obj.adaptive_fairing.strength = 1.0
    assert np.abs(read_mesh_coordinates(obj.data)).max() < 0.6


def test_colours_rest_meanwhile_and_are_those_of_the_new_shape(obj):
    show_surface(obj, "REFINED_1")
    color_by_field(obj, "DISPLACEMENT", FairingSettings())
    with results.on_control(obj, for_run=True):
        assert list(obj.data.color_attributes) == []
        start = display_of(obj).original()
        path = StoredPath.through(start, [1.0], [2 * start])
        results.store(obj, path, 1.0, "LIVE", from_original=True)
    assert obj.adaptive_fairing.view == "DISPLACEMENT"
    shown = read_values(obj.data.attributes["fairing_displacement"])
    assert shown.max() == pytest.approx(1.0, rel=0.1)
    assert len(shown) == len(obj.data.vertices) > len(start)


def test_colours_that_compare_end_with_the_original(obj):
    color_by_field(obj, "DISPLACEMENT", FairingSettings())
    with results.on_control(obj, for_run=True):
        results.clear(obj)
    assert (obj.adaptive_fairing.view, list(obj.data.color_attributes)) == ("", [])


def test_what_does_not_fit_into_memory_leaves_the_control_mesh(obj, monkeypatch):
    before = everything(obj)
    monkeypatch.setattr(memory_estimate, "available_bytes", lambda: 1000)
    with pytest.raises(memory_estimate.MemoryNeededError):
        show_surface(obj, "REFINED_1")
    assert everything(obj) == before
    assert obj.adaptive_fairing.surface == "CONTROL"
