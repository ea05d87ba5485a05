"""Multiresolution sculptures: the level that is shown is denoised, the others follow or stay."""

import bpy
import numpy as np
import pytest
from support.objects import add_object
from support.results import coordinates

from adaptive_fairing.blender.data.mesh_arrays import read_mesh
from adaptive_fairing.blender.data.multires import read_level, shown_level, write_level
from adaptive_fairing.blender.operators.questions import hints
from adaptive_fairing.core import FairingError, denoise

pytestmark = pytest.mark.usefixtures("addon")

N_LEVELS = 4
ROUNDING = 1e-6  # single precision, of a cube of size 2
CUBE = (
    [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)],
    [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]],
)


@pytest.fixture
def sculpture():
    """A cube of four levels with noise on the last one."""
    obj = add_object(*CUBE)
    obj.select_set(True)
    levels = obj.modifiers.new("Levels", "MULTIRES")
    for _ in range(N_LEVELS):
        bpy.ops.object.multires_subdivide(modifier=levels.name)
    start = read_level(obj).vertices
    noise = np.random.default_rng(0).normal(scale=0.02, size=start.shape)
    write_level(obj, start, start + noise)
    return obj


def level(obj, number):
    """Positions that a level shows."""
    modifier = obj.modifiers["Levels"]
    shown, modifier.levels = modifier.levels, number
    try:
        return read_level(obj).vertices
    finally:
        modifier.levels = shown


def test_a_level_that_is_written_is_read_again(sculpture):
    start = read_level(sculpture).vertices
    wanted = start * [1.0, 1.1, 0.9]
    write_level(sculpture, start, wanted)
    assert np.abs(read_level(sculpture).vertices - wanted).max() < ROUNDING


def test_other_modifiers_and_simplifying_change_nothing_that_is_read(sculpture):
    start = read_level(sculpture).vertices
    sculpture.modifiers.new("Bend", "SIMPLE_DEFORM").angle = 1.0
    render = bpy.context.scene.render
    render.use_simplify, render.simplify_subdivision = True, 0
    assert np.array_equal(read_level(sculpture).vertices, start)
    assert sculpture.modifiers["Bend"].show_viewport
    assert render.use_simplify


def test_a_run_gives_the_shown_level_what_the_core_makes_of_it(sculpture):
    base, seen = coordinates(sculpture), read_level(sculpture)
    coarser = level(sculpture, 2)
    expected = denoise(seen.vertices, seen.triangles).positions
    assert np.abs(expected - seen.vertices).max() > 0.02, "there is noise to remove"
    assert bpy.ops.object.adaptive_fairing() == {"FINISHED"}
    assert np.abs(read_level(sculpture).vertices - expected).max() < ROUNDING
    assert np.array_equal(coordinates(sculpture), base)
    assert np.isfinite(coarser).all()
    assert not sculpture.adaptive_fairing.result
    assert [each.name for each in bpy.data.objects] == [sculpture.name]
    assert len(bpy.data.meshes) == 1


def test_finer_levels_keep_their_detail_on_a_denoised_coarser_one(sculpture):
    modifier = sculpture.modifiers["Levels"]
    modifier.levels = N_LEVELS - 1
    coarse, fine = read_level(sculpture).vertices, level(sculpture, N_LEVELS)
    bpy.ops.object.adaptive_fairing(clean="denoise")
    n = len(coarse)
    assert np.abs(read_level(sculpture).vertices - coarse).max() > 0
    moved, detail = (
        level(sculpture, N_LEVELS)[:n] - read_level(sculpture).vertices,
        fine[:n] - coarse,
    )
    lengths, before = (np.linalg.norm(each, axis=1) for each in (moved, detail))
    assert np.allclose(lengths, before, atol=0.1 * before.max())


def test_the_base_is_denoised_where_it_is_what_is_shown(sculpture):
    sculpture.modifiers["Levels"].levels = 0
    assert shown_level(sculpture) is None
    assert not any("Multiresolution" in each for each in all_hints(sculpture))


def test_it_is_said_before_and_after(sculpture, capfd):
    assert any("the level that is shown is denoised" in each for each in all_hints(sculpture))
    bpy.ops.object.adaptive_fairing()
    assert "Thing: denoised the level that is shown" in capfd.readouterr().out


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda obj: {"algorithm": "FAIR"}, "cannot hold steps as shape keys"),
        (lambda obj: {"vertex_group": obj.vertex_groups.new(name="g").name}, "no vertex group"),
        (lambda obj: {"hold_sharp": True}, "no vertex groups or sharp edges"),
        (lambda obj: bpy.data.objects.new("Twin", obj.data) and {}, "single-user first"),
        (lambda obj: obj.shape_key_add(name="Basis") and {}, "has shape keys"),
    ],
)
def test_what_cannot_be_done_is_said_and_changes_nothing(sculpture, change, message):
    options = change(sculpture)
    base, shown = coordinates(sculpture), shown_positions(sculpture)
    with pytest.raises(RuntimeError, match=message):
        bpy.ops.object.adaptive_fairing(**options)
    assert np.array_equal(coordinates(sculpture), base)
    assert np.array_equal(shown_positions(sculpture), shown)


def test_a_level_that_was_changed_during_the_run_is_not_written(sculpture):
    start = read_level(sculpture).vertices
    sculpture.modifiers["Levels"].levels = 2
    with pytest.raises(FairingError, match="changed during the run"):
        write_level(sculpture, start, start)


def all_hints(obj):
    return hints([obj], bpy.context.scene.adaptive_fairing)


def shown_positions(obj):
    graph = bpy.context.evaluated_depsgraph_get()
    mesh = bpy.data.meshes.new_from_object(obj.evaluated_get(graph))
    try:
        return read_mesh(mesh).vertices
    finally:
        bpy.data.meshes.remove(mesh)
