"""Changes of exporters of their own accord: undone, or told."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from support.meshes import icosphere
from support.objects import add_object, add_rich_object, bumpy_box

from adaptive_fairing.blender.data.mesh_arrays import read_triangles
from adaptive_fairing.blender.files.mesh_files import empty_scene, export_mesh, import_mesh
from adaptive_fairing.cli import main as cli


def with_materials(n_materials, seed=3):
    """Make a box of quads whose materials alternate, with one vertex group on a part of it."""
    obj = add_object(*bumpy_box())
    for number in range(n_materials):
        obj.data.materials.append(bpy.data.materials.new(f"material {number}"))
    rng = np.random.default_rng(seed)
    slots = rng.integers(0, n_materials, len(obj.data.polygons)).astype(np.int32)
    obj.data.polygons.foreach_set("material_index", slots)
    return obj


def faces_with_materials(obj):
    slots = obj.material_slots
    return [
        (tuple(face.vertices), slots[face.material_index].name if slots else None)
        for face in obj.data.polygons
    ]


@pytest.mark.parametrize("n_materials", [1, 2, 5])
@pytest.mark.parametrize("keep_axes", [False, True])
def test_faces_of_several_materials_keep_their_order_in_obj(tmp_path, n_materials, keep_axes):
    obj, path = with_materials(n_materials), tmp_path / "box.obj"
    expected = faces_with_materials(obj)
    expected = [(face, material.replace(" ", "_")) for face, material in expected]
    assert export_mesh(obj, path, alone=True, keep_axes=keep_axes) == []
    found = faces_with_materials(import_mesh(path, keep_axes=keep_axes))
    assert [(cycle(face), material) for face, material in found] == [
        (cycle(face), material) for face, material in expected
    ]


def cycle(face):
    first = face.index(min(face))
    return face[first:] + face[:first]


def test_of_two_objects_each_keeps_its_order(tmp_path):
    path = tmp_path / "two.obj"
    expected = {}
    for name in ("One", "Two"):
        obj = with_materials(3, seed=len(expected))
        obj.name = name
        expected[name] = [cycle(face) for face, _ in faces_with_materials(obj)]
    export_mesh(bpy.data.objects["One"], path, alone=False)
    for name, faces in expected.items():
        obj = import_mesh(path, name)
        assert [cycle(face) for face, _ in faces_with_materials(obj)] == faces


def test_a_faired_obj_has_its_faces_in_order(tmp_path):
    given, out = tmp_path / "in.obj", tmp_path / "out.obj"
    export_mesh(with_materials(4), given, alone=True, keep_axes=True)
    assert cli.main(["denoise", str(given), "-o", str(out), "--quiet"]) == 0
    lines = [
        [line for line in path.read_text().splitlines() if line.startswith(("f ", "usemtl"))]
        for path in (given, out)
    ]
    assert lines[0] == lines[1]


def test_faces_that_have_got_a_group_are_told(tmp_path):
    obj = add_object(*bumpy_box())
    group = obj.vertex_groups.new(name="part")
    group.add(list(obj.data.polygons[0].vertices), 1.0, "REPLACE")
    assert export_mesh(obj, tmp_path / "box.obj", alone=True) == [
        "faces without a group are written as group 'off'"
    ]


@pytest.mark.parametrize("suffix", [".usda", ".usdc", ".usdz"])
def test_uv_maps_keep_their_names_in_usd(tmp_path, suffix):
    obj, path = add_object(*bumpy_box()), tmp_path / f"box{suffix}"
    for name in ("first", "second"):
        obj.data.uv_layers.new(name=name)
    export_mesh(obj, path, alone=True)
    assert [layer.name for layer in import_mesh(path).data.uv_layers] == ["first", "second"]


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
def test_split_vertices_are_told(tmp_path, suffix):
    obj = add_object(*icosphere(1))
    (note,) = export_mesh(obj, tmp_path / f"flat{suffix}", alone=True)
    assert note.startswith("42 vertices are stored as 240: ")
    empty_scene()
    obj = add_object(*icosphere(1))
    obj.data.shade_smooth()
    assert export_mesh(obj, tmp_path / f"smooth{suffix}", alone=True) == []
    assert len(read_triangles(import_mesh(tmp_path / f"smooth{suffix}").data)) == 80


def test_a_rich_object_stays_rich(tmp_path):
    """With every kind of data at once."""
    obj, path = add_rich_object(), tmp_path / "rich.obj"
    expected = [cycle(face) for face, _ in faces_with_materials(obj)]
    export_mesh(obj, path, alone=True)
    found = import_mesh(path)
    assert [cycle(face) for face, _ in faces_with_materials(found)] == expected
