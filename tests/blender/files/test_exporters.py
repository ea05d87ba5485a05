"""Blender's own exporters, as they are set at first, write the shape that is shown."""

import bpy
import numpy as np
import pytest
from scipy.spatial import cKDTree
from support.meshes import noisy_ball
from support.objects import add_object, shown_positions

from adaptive_fairing.blender.data import results
from adaptive_fairing.blender.files.mesh_files import empty_scene

pytestmark = pytest.mark.usefixtures("addon")

EXPORTERS = {
    ".glb": lambda path: bpy.ops.export_scene.gltf(filepath=path),
    ".fbx": lambda path: bpy.ops.export_scene.fbx(filepath=path),
    ".obj": lambda path: bpy.ops.wm.obj_export(filepath=path),
    ".ply": lambda path: bpy.ops.wm.ply_export(filepath=path),
    ".stl": lambda path: bpy.ops.wm.stl_export(filepath=path),
    ".usdc": lambda path: bpy.ops.wm.usd_export(filepath=path),
    ".abc": lambda path: bpy.ops.wm.alembic_export(filepath=path),
    "raw.stl": lambda path: bpy.ops.wm.stl_export(filepath=path, apply_modifiers=False),
    "raw.obj": lambda path: bpy.ops.wm.obj_export(filepath=path, apply_modifiers=False),
    "raw.ply": lambda path: bpy.ops.wm.ply_export(filepath=path, apply_modifiers=False),
}
IMPORTERS = {
    ".glb": lambda path: bpy.ops.import_scene.gltf(filepath=path),
    ".fbx": lambda path: bpy.ops.import_scene.fbx(filepath=path),
    ".obj": lambda path: bpy.ops.wm.obj_import(filepath=path),
    ".ply": lambda path: bpy.ops.wm.ply_import(filepath=path),
    ".stl": lambda path: bpy.ops.wm.stl_import(filepath=path),
    ".usdc": lambda path: bpy.ops.wm.usd_import(filepath=path),
    ".abc": lambda path: bpy.ops.wm.alembic_import(filepath=path, as_background_job=False),
}


@pytest.fixture
def noisy():
    obj = add_object(*noisy_ball(3, 0.02))
    obj.data.shade_smooth()  # glTF splits vertices at flat faces
    obj.select_set(True)
    return obj


def written(kind, folder):
    """Export the scene and read the file again: positions in the world, (n, 3)."""
    path = str(folder / f"out{kind.removeprefix('raw')}")
    EXPORTERS[kind](path)
    empty_scene()
    IMPORTERS[kind.removeprefix("raw")](path)
    bpy.context.view_layer.update()
    (obj,) = [each for each in bpy.data.objects if each.type == "MESH"]
    matrix = np.array(obj.matrix_world)
    return shown_positions(obj) @ matrix[:3, :3].T + matrix[:3, 3]


def same_points(found, expected):
    """Largest distance from a point of one set to the nearest of the other, both ways."""
    pairs = ((found, expected), (expected, found))
    return max(cKDTree(one).query(other)[0].max() for one, other in pairs)


@pytest.mark.parametrize("kind", EXPORTERS)
@pytest.mark.parametrize("way", ["LIVE", "KEYS"])
@pytest.mark.parametrize("at", [0.25, 0.8, 1.0])
def test_the_file_has_the_shape_that_the_slider_shows(noisy, tmp_path, kind, way, at):
    if kind.startswith("raw") and way == "KEYS" and at < 0.5:
        return  # the coordinates are those of the Basis there, see `show_time`
    before = shown_positions(noisy)
    if way == "LIVE":
        bpy.ops.object.adaptive_fairing()
        noisy.adaptive_fairing.strength = at
    else:
        bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=2, tau=0.01)
        noisy.adaptive_fairing.evolution = at
    shown = shown_positions(noisy)
    assert same_points(before, shown) > 1e-3, "no test"
    assert same_points(written(kind, tmp_path), shown) < 1e-5


@pytest.mark.parametrize("kind", [kind for kind in EXPORTERS if not kind.startswith("raw")])
def test_a_modifier_is_written_where_modifiers_are_applied(noisy, tmp_path, kind, monkeypatch):
    bpy.ops.object.adaptive_fairing(result="MODIFIER")
    shown = shown_positions(noisy)
    if kind == ".glb":
        path = str(tmp_path / "out.glb")
        monkeypatch.setitem(
            EXPORTERS, kind, lambda _: bpy.ops.export_scene.gltf(filepath=path, export_apply=True)
        )
    assert same_points(written(kind, tmp_path), shown) < 1e-5


@pytest.mark.parametrize("kind", EXPORTERS)
@pytest.mark.parametrize("way", ["LIVE", "MODIFIER"])
def test_nothing_internal_is_written(noisy, tmp_path, kind, way):
    bpy.ops.object.adaptive_fairing(result=way)
    written(kind, tmp_path)
    names = [name for mesh in bpy.data.meshes for name in mesh.attributes.keys()]
    assert [name for name in names if "fairing" in name] == []


@pytest.mark.parametrize("way", ["LIVE", "MODIFIER"])
def test_a_file_with_the_old_names_of_attributes_works_on(noisy, tmp_path, way):
    bpy.ops.object.adaptive_fairing(result=way)
    hidden = [name for name in noisy.data.attributes.keys() if name.startswith(".fairing")]
    assert hidden
    for name in hidden:
        noisy.data.attributes[name].name = name[1:]
    for tree in bpy.data.node_groups:
        for node in tree.nodes:
            if node.bl_idname == "GeometryNodeInputNamedAttribute":
                node.inputs["Name"].default_value = node.inputs["Name"].default_value[1:]
    name, expected = noisy.name, {}
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "old.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "old.blend"))
    obj = bpy.data.objects[name]
    assert hidden == [name for name in obj.data.attributes.keys() if "fairing" in name]
    expected[1.0] = shown_positions(obj)
    for strength in (0.0, 0.5, 1.0):
        obj.adaptive_fairing.strength = strength
        expected[strength] = shown_positions(obj)
    assert np.abs(expected[1.0] - expected[0.0]).max() > 1e-3
    middle = (expected[0.0] + expected[1.0]) / 2
    assert np.abs(expected[0.5] - middle).max() < np.abs(expected[1.0] - middle).max()


def test_ply_writes_the_colors_of_the_scan(noisy, tmp_path):
    """Once no field is shown, whose colours are the active ones as long as it is."""
    paint = noisy.data.color_attributes.new("Scan", "FLOAT_COLOR", "POINT")
    paint.data.foreach_set("color", np.tile([1.0, 0.0, 0.0, 1.0], len(noisy.data.vertices)))
    bpy.ops.object.adaptive_fairing(algorithm="FAIR", steps=1)
    for field in ("DENSITY", "REMOVED"):
        bpy.ops.object.adaptive_fairing_view(field=field)
    bpy.ops.object.adaptive_fairing_view_end()
    names = noisy.data.attributes.active_color_name, noisy.data.attributes.default_color_name
    assert names == ("Scan", "Scan")
    path = str(tmp_path / "out.ply")
    bpy.ops.wm.ply_export(filepath=path, export_colors="LINEAR")
    empty_scene()
    bpy.ops.wm.ply_import(filepath=path, import_colors="LINEAR")
    mesh = bpy.data.objects["out"].data
    found = np.empty(4 * len(mesh.vertices), dtype=np.float32)
    mesh.color_attributes[0].data.foreach_get("color", found)
    assert np.abs(found.reshape(-1, 4) - [1, 0, 0, 1]).max() < 0.01


@pytest.mark.parametrize("kind", [".stl", ".glb"])
def test_a_walk_from_the_scan_to_the_export(noisy, tmp_path, kind):
    """One press, slide, paint the nose back, apply, export, import: what was seen comes back."""
    before = shown_positions(noisy)
    bpy.ops.object.adaptive_fairing()
    noisy.adaptive_fairing.strength = 0.8
    denoised = shown_positions(noisy)
    bpy.ops.object.adaptive_fairing_paint()
    nose = before[:, 2] > 0.7
    noisy.vertex_groups["Fairing"].add(np.flatnonzero(nose).tolist(), 0.0, "REPLACE")
    results.follow_weights(noisy)
    bpy.ops.object.adaptive_fairing_paint()
    assert noisy.mode == "OBJECT"
    bpy.ops.object.adaptive_fairing_apply()
    shown = shown_positions(noisy)
    assert np.array_equal(shown[nose], before[nose])
    assert np.array_equal(shown[~nose], denoised[~nose])
    assert same_points(written(kind, tmp_path), shown) < 1e-5
