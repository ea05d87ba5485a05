"""Results refined on their way out: files, batches and sequences."""

import bpy
import numpy as np
import pytest
from scipy.spatial import cKDTree
from support.batches import batch
from support.meshes import bumpy_disc, random_closed
from support.objects import add_object, key_positions, write_ply

from adaptive_fairing.blender.data.mesh_arrays import read_mesh, read_positions, weld
from adaptive_fairing.blender.files.mesh_files import export_mesh, import_mesh
from adaptive_fairing.cli import main as cli
from adaptive_fairing.core import LimitSurface, TriangleTopology

PAPER = ("--steps", "2", "--no-denoised", "--quiet")


def run(*arguments):
    assert batch(*arguments, *PAPER, algorithm="fair") == 0


@pytest.fixture
def noisy(tmp_path):
    return write_ply(tmp_path / "noisy.ply", *random_closed(seed=1))


def surface_of(path):
    data = read_mesh(import_mesh(path).data)
    return LimitSurface(TriangleTopology(data.triangles, len(data.vertices)), data.vertices)


@pytest.mark.parametrize("levels", [1, 2])
def test_a_mesh_file_is_the_limit_surface_of_the_plain_result(noisy, tmp_path, levels):
    run(noisy, "-o", tmp_path / "plain.ply")
    expected = surface_of(tmp_path / "plain.ply").refined(levels)
    run(noisy, "-o", tmp_path / "fine.ply", "--refine", levels)
    found = read_mesh(import_mesh(tmp_path / "fine.ply").data)
    np.testing.assert_allclose(found.vertices, expected.vertices, atol=1e-6)
    assert np.array_equal(found.triangles, expected.triangles)


def test_limit_points_without_new_vertices(tmp_path):
    vertices, faces = bumpy_disc(0)
    source = write_ply(tmp_path / "disc.ply", vertices, faces)
    run(source, "-o", tmp_path / "plain.ply")
    expected = surface_of(tmp_path / "plain.ply").points
    run(source, "-o", tmp_path / "limit.ply", "--limit")
    found = read_mesh(import_mesh(tmp_path / "limit.ply").data)
    np.testing.assert_allclose(found.vertices, expected, atol=1e-6)
    assert len(found.triangles) == len(faces)


def test_every_step_of_a_blend_is_refined_and_plays(noisy, tmp_path):
    run(noisy, "-o", tmp_path / "plain.blend")
    obj = import_mesh(tmp_path / "plain.blend")
    surface = surface_of(noisy)
    obj = import_mesh(tmp_path / "plain.blend")
    names = [block.name for block in obj.data.shape_keys.key_blocks]
    expected = [surface.moved(key_positions(obj, name)).refined(1).vertices for name in names]
    run(noisy, "-o", tmp_path / "fine.blend", "--refine", 1)
    obj = import_mesh(tmp_path / "fine.blend")
    blocks = obj.data.shape_keys.key_blocks
    assert [block.name for block in blocks] == names
    for name, positions in zip(names, expected, strict=True):
        np.testing.assert_allclose(key_positions(obj, name), positions, atol=1e-6)
    for index, frame in enumerate((1, 11, 21)):
        bpy.context.scene.frame_set(frame)
        assert obj.data.shape_keys.eval_time == pytest.approx(blocks[index].frame)


@pytest.mark.parametrize("suffix", [".stl", ".glb"])
def test_files_that_split_vertices_are_refined_in_one_piece(tmp_path, suffix):
    """No crack opens where the file had torn the surface apart."""
    obj = add_object(*random_closed(seed=1))
    for edge in obj.data.edges[:60]:
        edge.use_edge_sharp = True
    export_mesh(obj, tmp_path / f"torn{suffix}", alone=True)
    run(tmp_path / f"torn{suffix}", "-o", tmp_path / "fine.ply", "--refine", 1)
    found = read_mesh(import_mesh(tmp_path / "fine.ply").data)
    assert len(found.triangles) == 4 * 80
    assert TriangleTopology(found.triangles, len(found.vertices)).is_closed


def test_weld_keeps_what_corners_have():
    vertices = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], float)
    obj = add_object(vertices, [(0, 1, 2), (3, 4, 5)])
    uv = obj.data.uv_layers.new(name="UV")
    values = np.arange(12, dtype=np.float32)
    uv.uv.foreach_set("vector", values)
    weld(obj.data)
    assert len(obj.data.vertices) == 4 and len(obj.data.polygons) == 2
    found = np.empty(12, dtype=np.float32)
    obj.data.uv_layers["UV"].uv.foreach_get("vector", found)
    assert np.array_equal(found, values)
    before = read_positions(obj.data)
    weld(obj.data)
    assert np.array_equal(read_positions(obj.data), before)


def test_quads_are_cut_in_the_refined_result_only(tmp_path):
    bpy.ops.mesh.primitive_torus_add(major_segments=12, minor_segments=8)
    export_mesh(bpy.context.active_object, tmp_path / "quads.obj", alone=True)
    run(tmp_path / "quads.obj", "-o", tmp_path / "limit.obj", "--limit")
    polygons = import_mesh(tmp_path / "limit.obj").data.polygons
    assert {len(polygon.vertices) for polygon in polygons} == {4}
    run(tmp_path / "quads.obj", "-o", tmp_path / "fine.obj", "--refine", 1)
    polygons = import_mesh(tmp_path / "fine.obj").data.polygons
    assert {len(polygon.vertices) for polygon in polygons} == {3} and len(polygons) == 8 * 96


class TestBatch:
    def test_every_result_is_refined_and_other_levels_are_another_batch(
        self, five_meshes, tmp_path, capsys
    ):
        run(five_meshes, "--out-dir", tmp_path / "out", "--refine", 1)
        for path in sorted(five_meshes.iterdir()):
            found = len(import_mesh(tmp_path / "out" / path.name).data.polygons)
            assert found == 4 * len(import_mesh(path).data.polygons)
        first = {p.name: p.stat().st_mtime_ns for p in (tmp_path / "out").glob("*.ply")}
        run(five_meshes, "--out-dir", tmp_path / "out", "--refine", 1)
        assert first == {p.name: p.stat().st_mtime_ns for p in (tmp_path / "out").glob("*.ply")}
        run(five_meshes, "--out-dir", tmp_path / "out", "--limit")
        for path in sorted(five_meshes.iterdir()):
            found = len(import_mesh(tmp_path / "out" / path.name).data.polygons)
            assert found == len(import_mesh(path).data.polygons)

    def test_frames_are_refined_together_as_one_keyed_object(self, tmp_path):
        vertices, faces = random_closed(2)
        folder = tmp_path / "frames"
        folder.mkdir()
        for frame in (1, 2, 3):
            write_ply(folder / f"f_{frame:03d}.ply", vertices * (1, 1, frame), faces)
        out = tmp_path / "all.blend"
        run(*sorted(folder.iterdir()), "--sequence", "-o", out, "--refine", 1)
        obj = import_mesh(out)
        assert len(obj.data.polygons) == 4 * len(faces)
        shapes = [key_positions(obj, f"Frame {frame}") for frame in (1, 2, 3)]
        bpy.context.scene.frame_set(2)
        assert obj.data.shape_keys.eval_time == pytest.approx(
            obj.data.shape_keys.key_blocks[1].frame
        )
        for frame, found in zip((1, 2, 3), shapes, strict=True):
            plain = surface_of(tmp_path / "all_frames" / f"f_{frame:03d}.ply")
            assert cKDTree(found).query(plain.refined(1).vertices)[0].max() < 1e-5


def test_wrong_levels(capsys):
    assert cli.main(["fair", "in.ply", "--refine", "4"]) == 2
    assert "invalid choice: 4" in capsys.readouterr().err
