"""Selecting problem vertices: exactly those that the core names, and nothing else changes."""

import bpy
import numpy as np
import pytest
from support.bad_meshes import bow_tie, collapsed, three_sheets
from support.meshes import icosphere
from support.objects import add_object

from adaptive_fairing.blender.data.mesh_arrays import read_mesh, read_positions
from adaptive_fairing.core.problem.diagnosis import find_problems

pytestmark = pytest.mark.usefixtures("addon")


def select_problems():
    return bpy.ops.object.adaptive_fairing_select_problems()


def selected(obj):
    bpy.ops.object.mode_set(mode="OBJECT")
    flags = np.zeros(len(obj.data.vertices), dtype=bool)
    obj.data.vertices.foreach_get("select", flags)
    return np.flatnonzero(flags)


@pytest.mark.parametrize("mesh", [bow_tie, collapsed, three_sheets])
@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_the_culprits_are_selected_and_no_other(mesh, mode):
    obj = add_object(*mesh())
    data = read_mesh(obj.data)
    expected = find_problems(data.vertices, data.triangles).vertices
    assert 0 < len(expected) < len(data.vertices)
    bpy.ops.object.mode_set(mode=mode)
    assert select_problems() == {"FINISHED"}
    assert obj.mode == "EDIT"
    np.testing.assert_array_equal(selected(obj), expected)
    np.testing.assert_array_equal(read_positions(obj.data), data.vertices)


def test_coordinates_that_are_no_numbers():
    vertices, faces = icosphere(1)
    obj = add_object(vertices, faces)
    obj.data.vertices[7].co.x = np.nan
    assert select_problems() == {"FINISHED"}
    np.testing.assert_array_equal(selected(obj), [7])


def test_hidden_culprits_are_shown():
    obj = add_object(*bow_tie())
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.hide()
    select_problems()
    np.testing.assert_array_equal(selected(obj), [0])
    assert not obj.data.vertices[0].hide


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
def test_without_problems_mode_and_selection_stay(mode):
    obj = add_object(*icosphere(1))
    obj.data.vertices[3].select = True
    before = selected(obj)
    bpy.ops.object.mode_set(mode=mode)
    assert select_problems() == {"FINISHED"}
    assert obj.mode == mode
    np.testing.assert_array_equal(selected(obj), before)


def test_what_is_refused_is_said():
    with pytest.raises(RuntimeError, match="Make a mesh object active"):
        select_problems()
    add_object(*icosphere(1))
    bpy.ops.object.mode_set(mode="SCULPT")
    with pytest.raises(RuntimeError, match="Change to Object Mode or Edit Mode"):
        select_problems()
    bpy.ops.object.mode_set(mode="OBJECT")
