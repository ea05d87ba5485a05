"""Files refined without being faired: the command, its output, its report."""

import json

import numpy as np
import pytest
from support.meshes import bumpy_disc, random_closed
from support.objects import add_object, key_positions, write_ply

from adaptive_fairing.blender.data.mesh_arrays import read_mesh
from adaptive_fairing.blender.files.mesh_files import export_mesh, import_mesh, save_blend
from adaptive_fairing.cli import main as cli
from adaptive_fairing.core import LimitSurface, TriangleTopology


def refine(*arguments):
    return cli.main(["refine", *map(str, arguments)])


def surface_of(path):
    data = read_mesh(import_mesh(path).data)
    return LimitSurface(TriangleTopology(data.triangles, len(data.vertices)), data.vertices)


@pytest.fixture
def noisy(tmp_path):
    return write_ply(tmp_path / "noisy.ply", *random_closed(seed=1))


@pytest.mark.parametrize("levels", [1, 2])
def test_a_file_becomes_its_limit_surface(noisy, tmp_path, capsys, levels):
    out, report = tmp_path / "fine.ply", tmp_path / "r.json"
    assert refine(noisy, "-o", out, "--levels", levels, "--report", report) == 0
    expected = surface_of(noisy).refined(levels)
    found = read_mesh(import_mesh(out).data)
    np.testing.assert_allclose(found.vertices, expected.vertices, atol=1e-6)
    assert np.array_equal(found.triangles, expected.triangles)
    n_vertices, n_triangles = len(expected.vertices), len(expected.triangles)
    assert capsys.readouterr().err.splitlines() == [
        f"adaptive-fairing: refined {levels} times, {n_vertices} vertices; wrote {out}"
    ]
    told = json.loads(report.read_text())
    assert (told["algorithm"], told["settings"]) == ("refine", {"levels": levels})
    assert (told["mesh"]["vertices"], told["written"]["triangles"]) == (42, n_triangles)


def test_limit_points_without_new_vertices(tmp_path):
    source = write_ply(tmp_path / "disc.ply", *bumpy_disc(0))
    assert refine(source, "-o", tmp_path / "limit.ply", "--limit", "--quiet") == 0
    found = read_mesh(import_mesh(tmp_path / "limit.ply").data)
    np.testing.assert_allclose(found.vertices, surface_of(source).points, atol=1e-6)


def test_shape_keys_and_other_objects_of_a_blend_survive(tmp_path):
    vertices, faces = random_closed(seed=1)
    obj = add_object(vertices, faces, name="One")
    obj.shape_key_add(name="Basis")
    key = obj.shape_key_add(name="Wide", from_mix=False)
    key.points.foreach_set("co", (2.0 * vertices).astype(np.float32).ravel())
    add_object(*bumpy_disc(0), name="Two")
    save_blend(tmp_path / "in.blend")
    assert refine(tmp_path / "in.blend", "--object", "One", "--quiet") == 0
    found = import_mesh(tmp_path / "in_refined.blend", "One")
    topology = TriangleTopology(faces, len(vertices))
    expected = LimitSurface(topology, 2.0 * vertices).refined(1)
    np.testing.assert_allclose(key_positions(found, "Wide"), expected.vertices, atol=1e-6)
    assert len(import_mesh(tmp_path / "in_refined.blend", "Two").data.vertices) == len(
        bumpy_disc(0)[0]
    )


def test_a_file_that_splits_vertices_is_refined_in_one_piece(tmp_path):
    obj = add_object(*random_closed(seed=1))
    for edge in obj.data.edges[:60]:
        edge.use_edge_sharp = True
    export_mesh(obj, tmp_path / "torn.glb", alone=True)
    assert refine(tmp_path / "torn.glb", "-o", tmp_path / "fine.ply", "--quiet") == 0
    found = read_mesh(import_mesh(tmp_path / "fine.ply").data)
    assert len(found.triangles) == 4 * 80
    assert TriangleTopology(found.triangles, len(found.vertices)).is_closed


def test_what_cannot_be_refined_is_told_and_reported(tmp_path, capsys):
    bad, report = tmp_path / "bad.ply", tmp_path / "r.json"
    bad.write_text("no mesh")
    assert refine(bad, "-o", tmp_path / "o.ply", "--report", report) == 1
    assert "cannot read" in capsys.readouterr().err
    assert "cannot read" in json.loads(report.read_text())["error"]
    assert not (tmp_path / "o.ply").exists()
