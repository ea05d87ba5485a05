"""Files whose mesh is refined, or whose attribute is faired: commands, outputs, reports."""

import json

import numpy as np
import pytest
from support.meshes import bumpy_disc, noisy_ball, random_closed
from support.objects import add_object, key_positions, write_ply

from adaptive_fairing.blender.data.mesh_arrays import read_mesh
from adaptive_fairing.blender.files.mesh_files import export_mesh, import_mesh, save_blend
from adaptive_fairing.cli import main as cli
from adaptive_fairing.core import FairingSettings, LimitSurface, TriangleTopology, fair_values


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
        f"adaptive-fairing: {n_vertices} vertices, refined {levels} times; wrote {out}"
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


def colored_ball(path):
    """Write a ball with noisy colours to a .ply file; give its vertices, faces and colours."""
    vertices, faces = noisy_ball()
    obj = add_object(vertices, faces)
    colors = np.ones((len(vertices), 4), dtype=np.float32)
    colors[:, :3] = np.random.default_rng(1).uniform(0.3, 0.7, (len(vertices), 3))
    layer = obj.data.color_attributes.new("Paint", "FLOAT_COLOR", "POINT")
    layer.data.foreach_set("color", colors.ravel())
    save_blend(path)
    return vertices, faces, colors


def colors_of(path, name="Paint"):
    data = import_mesh(path).data.color_attributes[name].data
    colors = np.empty((len(data), 4), dtype=np.float32)
    data.foreach_get("color", colors.ravel())
    return colors


def test_an_attribute_is_faired_and_the_vertices_stay(tmp_path, capsys):
    vertices, faces, colors = colored_ball(tmp_path / "in.blend")
    out, report = tmp_path / "out.blend", tmp_path / "r.json"
    options = ["--attribute", "Paint", "--steps", "2", "--scheme", "uniform", "--radius", "1"]
    arguments = ["fair", tmp_path / "in.blend", "-o", out, *options, "--report", report]
    assert cli.main([str(argument) for argument in arguments]) == 0
    settings = FairingSettings(method="uniform", steps=2, radius=1.0)
    expected = fair_values(vertices.astype(np.float32), faces, colors, settings)[-1]
    np.testing.assert_allclose(colors_of(out), expected, atol=1e-5)
    assert np.ptp(expected[:, 0]) < np.ptp(colors[:, 0]) / 2
    assert np.array_equal(
        read_mesh(import_mesh(out).data).vertices,
        read_mesh(import_mesh(tmp_path / "in.blend").data).vertices,
    )
    assert capsys.readouterr().err.splitlines() == [
        f"adaptive-fairing: 642 vertices, Paint faired, 2 steps; wrote {out}"
    ]
    told = json.loads(report.read_text())
    assert (told["algorithm"], told["attribute"]) == ("fair", "Paint")
    assert (told["settings"]["scheme"], told["settings"]["radius"]) == ("uniform", 1.0)


def test_an_attribute_goes_through_a_mesh_file(tmp_path):
    colored_ball(tmp_path / "in.blend")
    export_mesh(import_mesh(tmp_path / "in.blend"), tmp_path / "in.ply", alone=True)
    name = import_mesh(tmp_path / "in.ply").data.color_attributes[0].name
    before = colors_of(tmp_path / "in.ply", name)
    arguments = ["fair", str(tmp_path / "in.ply"), "-o", str(tmp_path / "out.ply"), "--quiet"]
    assert cli.main([*arguments, "--attribute", name]) == 0
    after = colors_of(tmp_path / "out.ply", name)
    assert after[:, :3].std() < 0.9 * before[:, :3].std()
    np.testing.assert_allclose(after.mean(axis=0), before.mean(axis=0), atol=0.02)


def test_an_attribute_that_is_not_there_is_status_1_and_the_others_are_named(tmp_path, capsys):
    colored_ball(tmp_path / "in.blend")
    arguments = ["fair", str(tmp_path / "in.blend"), "-o", str(tmp_path / "out.blend")]
    assert cli.main([*arguments, "--attribute", "paint"]) == 1
    assert "there is no 'paint' on the mesh, but 'Paint'" in capsys.readouterr().err
    assert not (tmp_path / "out.blend").exists()
