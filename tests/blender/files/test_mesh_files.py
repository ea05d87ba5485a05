"""Every format out and in again: what survives, and that files are whole or absent."""

import bpy
import numpy as np
import pytest
from support.meshes import icosphere
from support.objects import (
    add_object,
    add_rich_object,
    colors_by_vertex,
    materials_by_polygon,
    numbers,
    polygons_of,
    uvs_by_corner,
)

from adaptive_fairing.blender.data.mesh_arrays import read_mesh, read_positions
from adaptive_fairing.blender.files.mesh_files import export_mesh, import_mesh, save_blend
from adaptive_fairing.core import FairingError
from adaptive_fairing.files.errors import FileError
from adaptive_fairing.files.formats import MESH_FORMATS

KEEP_POLYGONS = [".obj", ".ply", ".fbx", ".usda", ".usdc", ".usdz", ".abc"]
RAW = [".obj", ".ply"]


def there_and_back(obj, path, **options):
    export_mesh(obj, path, alone=True, keep_axes=True, **options)
    return import_mesh(path, keep_axes=True)


@pytest.mark.parametrize("suffix", KEEP_POLYGONS)
def test_vertices_come_back_bit_by_bit_and_in_order(tmp_path, suffix):
    obj = add_rich_object()
    positions, polygons = read_positions(obj.data), sorted(polygons_of(obj.data))
    back = there_and_back(obj, tmp_path / f"a{suffix}")
    np.testing.assert_array_equal(read_positions(back.data), positions)
    # Formats may sort polygons by material and start them at another corner.
    assert sorted(map(from_smallest, polygons_of(back.data))) == sorted(
        map(from_smallest, polygons)
    )


def from_smallest(polygon):
    start = polygon.index(min(polygon))
    return polygon[start:] + polygon[:start]


@pytest.mark.parametrize("suffix", RAW)
@pytest.mark.parametrize("size", [1e-7, 1.0, 1e7])
def test_no_digit_is_lost_at_any_scale(tmp_path, suffix, size):
    rng = np.random.default_rng(0)
    vertices, faces = icosphere(2)
    vertices = size * (vertices + rng.normal(scale=0.01, size=vertices.shape))
    back = there_and_back(add_object(vertices, faces), tmp_path / f"a{suffix}")
    np.testing.assert_array_equal(read_positions(back.data), vertices.astype(np.float32))


def test_stl_keeps_every_corner_bit_by_bit(tmp_path):
    vertices, faces = icosphere(2)
    back = read_mesh(there_and_back(add_object(vertices, faces), tmp_path / "a.stl").data)
    expected = vertices.astype(np.float32)[faces]
    np.testing.assert_array_equal(back.vertices[back.triangles], expected)


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
def test_gltf_keeps_coordinates_though_it_splits_vertices(tmp_path, suffix):
    obj = add_rich_object()
    positions = read_positions(obj.data)
    back = there_and_back(obj, tmp_path / f"a{suffix}")
    np.testing.assert_array_equal(
        np.unique(read_positions(back.data), axis=0), np.unique(positions, axis=0)
    )


@pytest.mark.parametrize("suffix", KEEP_POLYGONS)
def test_uvs_survive(tmp_path, suffix):
    obj = add_rich_object()
    expected = uvs_by_corner(obj.data)
    found = uvs_by_corner(there_and_back(obj, tmp_path / f"a{suffix}").data)
    # .obj has six decimals.
    assert_same_at_corners(found, expected, 1e-6 if suffix == ".obj" else 0)


def assert_same_at_corners(found, expected, tolerance):
    by_corner = {
        (from_smallest(polygon), vertex): value
        for polygon, values in expected.items()
        for vertex, value in zip(polygon, values, strict=True)
    }
    count = 0
    for polygon, values in found.items():
        for vertex, value in zip(polygon, values, strict=True):
            difference = np.abs(value - by_corner[from_smallest(polygon), vertex]).max()
            assert difference <= tolerance
            count += 1
    assert count == len(by_corner)


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".fbx", ".usda"])
def test_vertex_colours_survive(tmp_path, suffix):
    obj = add_rich_object()
    expected = colors_by_vertex(obj.data, "Paint")
    back = there_and_back(obj, tmp_path / f"a{suffix}")
    found = colors_by_vertex(back.data, back.data.color_attributes[0].name)
    # Within half a step of an eight-bit colour, and so the same once more and ever after.
    np.testing.assert_allclose(found, expected, atol=0.4 / 255)


@pytest.mark.parametrize("suffix", [".obj", ".fbx", ".usda"])
def test_materials_survive_on_their_polygons(tmp_path, suffix):
    obj = add_rich_object()
    expected = materials_by_polygon(obj.data)
    found = materials_by_polygon(there_and_back(obj, tmp_path / f"a{suffix}").data)
    assert {from_smallest(p): m for p, m in found.items()} == {
        from_smallest(p): m for p, m in expected.items()
    }


@pytest.mark.parametrize("suffix", [".ply", ".usda"])
def test_own_attributes_survive(tmp_path, suffix):
    obj = add_rich_object()
    heat = numbers(obj.data, "heat")
    back = there_and_back(obj, tmp_path / f"a{suffix}")
    np.testing.assert_array_equal(numbers(back.data, "heat"), heat)


def test_ply_with_uv_seams_stays_one_surface(tmp_path):
    obj = add_rich_object()
    obj.data.uv_layers.active.uv[0].vector = (5, 5)
    path = tmp_path / "a.ply"
    notes = export_mesh(obj, path, alone=True)
    assert notes == ["UVs are left out: .ply has one UV per vertex, but the mesh has seams"]
    positions = read_positions(obj.data)
    np.testing.assert_array_equal(read_positions(import_mesh(path).data), positions)


def test_meshes_without_normals_of_their_own_get_none(tmp_path):
    export_mesh(add_rich_object(), tmp_path / "a.obj", alone=True)
    assert "\nvn " not in (tmp_path / "a.obj").read_text()


def test_obj_groups_survive(tmp_path):
    source = tmp_path / "a.obj"
    source.write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\no One\ng left\nf 1 2 3\no Two\ng right\nf 2 4 3\n"
    )
    obj = import_mesh(source)
    assert {group.name for group in obj.vertex_groups} == {"left", "right"}
    export_mesh(obj, tmp_path / "b.obj", alone=False)
    lines = (tmp_path / "b.obj").read_text().splitlines()
    assert {"g left", "g right"} <= set(lines)


def test_objects_of_an_obj_stay_one_surface_unless_one_is_named(tmp_path):
    source = tmp_path / "a.obj"
    source.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\no One\nf 1 2 3\no Two\nf 2 4 3\n")
    assert len(import_mesh(source).data.vertices) == 4
    assert len(import_mesh(source, "Two").data.vertices) == 3


def test_a_whole_scene_goes_out_if_it_came_in(tmp_path):
    one = add_object(*icosphere(0), name="One")
    add_object(2 * icosphere(1)[0], icosphere(1)[1], name="Two and a half")
    export_mesh(one, tmp_path / "all.obj", alone=False, keep_axes=True)
    export_mesh(one, tmp_path / "alone.obj", alone=True, keep_axes=True)
    import_mesh(tmp_path / "all.obj", "One")
    assert {obj.name for obj in bpy.data.objects} == {"One", "Two_and_a_half"}
    found = read_positions(bpy.data.objects["Two_and_a_half"].data)
    np.testing.assert_array_equal(found, (2 * icosphere(1)[0]).astype(np.float32))
    import_mesh(tmp_path / "alone.obj", "One")
    assert {obj.name for obj in bpy.data.objects} == {"One"}


def test_world_positions_go_out_with_y_up(tmp_path):
    vertices, faces = icosphere(1)
    parent = bpy.data.objects.new("Parent", None)
    bpy.context.scene.collection.objects.link(parent)
    parent.location = (10, 0, 0)
    obj = add_object(vertices, faces)
    obj.parent = parent
    obj.scale = (2, 2, 2)
    obj.hide_viewport = True  # hidden, and exported all the same
    bpy.context.view_layer.update()
    export_mesh(obj, tmp_path / "a.obj", alone=True)
    back = import_mesh(tmp_path / "a.obj", keep_axes=True)
    x, y, z = (2 * vertices + (10, 0, 0)).T
    np.testing.assert_allclose(read_positions(back.data), np.stack([x, z, -y], 1), atol=1e-6)


def test_modifiers_are_not_applied(tmp_path):
    obj = add_object(*icosphere(1))
    obj.modifiers.new("Subdivision", "SUBSURF")
    for suffix in (".obj", ".ply", ".glb", ".fbx"):
        path = tmp_path / f"a{suffix}"
        assert len(np.unique(read_positions(there_and_back(obj, path).data), axis=0)) == 42
        obj = add_object(*icosphere(1))
        obj.modifiers.new("Subdivision", "SUBSURF")


def test_coordinates_that_are_no_numbers_are_refused(tmp_path):
    path = tmp_path / "bad.obj"
    path.write_text("v 0 0 0\nv nan 0 0\nv 0 inf 0\nv 1 1 1\nf 1 2 3\nf 1 3 4\n")
    with pytest.raises(FileError, match=r"bad.obj: 2 vertices .* numbers: 1, 2; delete or repair"):
        import_mesh(path)


@pytest.mark.parametrize("suffix", [".blend", *MESH_FORMATS])
def test_files_that_are_something_else_are_refused_in_one_line(tmp_path, suffix):
    path = tmp_path / f"bad{suffix}"
    path.write_bytes(b"this is no mesh\n" * 20)
    with pytest.raises(FairingError) as caught:
        import_mesh(path)
    assert "\n" not in str(caught.value)
    assert path.name in str(caught.value)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(FileError, match=r"no\.obj: there is no such file"):
        import_mesh(tmp_path / "no.obj")


def test_edit_mode_of_the_file_is_left(tmp_path):
    obj = add_object(*icosphere(1))
    bpy.ops.object.mode_set(mode="EDIT")
    save_blend(tmp_path / "a.blend")
    bpy.ops.object.mode_set(mode="OBJECT")
    obj = import_mesh(tmp_path / "a.blend")
    assert obj.mode == "OBJECT"
    assert len(read_mesh(obj.data).triangles) == 80


def test_a_saved_file_finds_its_textures_from_another_folder(tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "out").mkdir()
    image = bpy.data.images.new("Dots", 4, 4)
    image.filepath_raw = str(tmp_path / "in" / "dots.png")
    image.file_format = "PNG"
    image.save()
    add_object(*icosphere(1))
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "in" / "a.blend"))
    image = bpy.data.images["Dots"]
    image.filepath = "//dots.png"
    image.use_fake_user = True
    save_blend(tmp_path / "in" / "b.blend")
    import_mesh(tmp_path / "in" / "b.blend")
    save_blend(tmp_path / "out" / "c.blend")
    import_mesh(tmp_path / "out" / "c.blend")
    found = bpy.path.abspath(bpy.data.images["Dots"].filepath)
    assert (tmp_path / "in" / "dots.png").samefile(found)


@pytest.mark.parametrize("suffix", list(MESH_FORMATS))
def test_a_failed_export_leaves_the_old_file_and_no_draft(tmp_path, suffix, monkeypatch):
    path = tmp_path / f"a{suffix}"
    path.write_text("old")
    obj = add_object(*icosphere(1))

    def fail(*arguments, **options):
        raise FileError("no")

    monkeypatch.setattr("adaptive_fairing.blender.files.mesh_files._call", fail)
    with pytest.raises(FileError, match="no"):
        export_mesh(obj, path, alone=True)
    assert path.read_text() == "old"
    assert [file.name for file in tmp_path.iterdir()] == [path.name]
