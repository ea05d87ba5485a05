"""Batches with Blender in the worker processes: results, what is told, what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from support.batches import batch, command, outputs, summary
from support.meshes import bumpy_disc
from support.objects import add_object, add_rich_object

from adaptive_fairing.blender.data.mesh_arrays import read_positions
from adaptive_fairing.blender.files.mesh_files import (
    empty_scene,
    export_mesh,
    import_mesh,
    save_blend,
)
from adaptive_fairing.cli import main as cli

SAME_BYTES = (".obj", ".ply", ".stl", ".glb", ".gltf")
"""Formats that hold nothing but the mesh; the others have dates, addresses or chance in them."""


def test_a_batch_writes_the_same_bytes_as_one_by_one(tmp_path):
    """Every format, twice over: two workers, and several meshes in each."""
    given, alone, together = (tmp_path / name for name in ("given", "alone", "together"))
    for folder in (given, alone):
        folder.mkdir()
    for suffix in (*SAME_BYTES, ".blend", ".abc", ".fbx", ".usdc"):
        empty_scene()
        rich = add_rich_object()
        path = given / f"rich_{suffix[1:]}{suffix}"
        if suffix == ".blend":
            save_blend(path)
        else:
            export_mesh(rich, path, alone=True)
        empty_scene()
        if suffix in SAME_BYTES:
            export_mesh(
                add_object(*bumpy_disc(1)), given / f"disc_{suffix[1:]}{suffix}", alone=True
            )
    for path in given.iterdir():
        if path.suffix not in (".mtl", ".bin"):
            assert cli.main(["denoise", str(path), "-o", str(alone / path.name), "--quiet"]) == 0
    assert batch(given, "--out-dir", together, "--jobs", 2, "--quiet") == 0
    expected, found = outputs(alone), outputs(together)
    assert found.keys() == expected.keys()
    for name in expected:
        if Path(name).suffix in (*SAME_BYTES, ".mtl", ".bin"):
            assert found[name] == expected[name], name
        else:
            shapes = [shape_of(folder / name) for folder in (alone, together)]
            assert np.array_equal(*shapes), name


def shape_of(path):
    """Read all shapes that a file holds: the mesh, or the keys of it."""
    keys = import_mesh(path).data.shape_keys
    if keys is None:
        return read_positions(import_mesh(path).data)
    return np.array([point.co[:] for block in keys.key_blocks for point in block.points])


@pytest.fixture(scope="module")
def seen(five_meshes, tmp_path_factory):
    """Three good meshes and three that fail, each for its own reason."""
    folder = tmp_path_factory.mktemp("seen")
    bad = folder / "bad.ply"
    bad.write_text("this is no mesh")
    points = folder / "points.obj"
    points.write_text("v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n")
    inputs = [*(five_meshes / f"mesh_{i}.ply" for i in range(3)), bad, points, folder / "no.stl"]
    process = command(
        *inputs, "--out-dir", folder / "out", "--jobs", 2, "--report", folder / "r.json",
        "--steps", 2, algorithm="fair",
    )  # fmt: skip
    _, err = process.communicate()
    report = json.loads((folder / "r.json").read_text())
    return {"status": process.returncode, "err": err, "report": report, "folder": folder}


class TestWhatIsTold:
    def test_the_status_is_1(self, seen):
        assert seen["status"] == 1

    def test_the_others_are_faired(self, seen):
        files = [path.name for path in (seen["folder"] / "out").iterdir() if path.is_file()]
        assert sorted(files) == ["mesh_0.ply", "mesh_1.ply", "mesh_2.ply"]

    def test_every_failure_is_one_line_with_its_reason(self, seen):
        lines = seen["err"].splitlines()
        assert len(lines) == 5
        told = {line.split(": ")[1]: line for line in lines}
        assert "cannot read" in told["bad.ply"]
        assert "not finite" in told["points.obj"]
        assert "there is no such file" in told["no.stl"]
        assert lines[3].startswith("adaptive-fairing: 6 meshes: 3 done, 3 failed; ")
        assert lines[4].startswith("adaptive-fairing: error: 3 of 6 meshes have no output, the ")

    def test_the_summary_has_them_all(self, seen):
        report = seen["report"]
        assert report["counts"] == {
            "meshes": 6, "done": 3, "skipped": 0, "failed": 3, "missing": 0,
        }  # fmt: skip
        assert report["settings"]["steps"] == 2
        by_name = {mesh["output"]: mesh for mesh in report["meshes"]}
        good, bad = by_name["mesh_1.ply"], by_name["points.obj"]
        assert (good["vertices"], good["triangles"], good["steps"]) == (42, 80, 2)
        assert 0 < good["curvature_ratio"] < 1
        assert good["peak_bytes"] is None or 0 < good["peak_bytes"] <= good["needed_bytes"]
        assert "points.obj: 1 vertices have coordinates that are not finite" in bad["error"]
        assert bad["vertices"] is None


def test_shards_make_the_whole_and_merge_sums_them_up(five_meshes, five_faired, tmp_path, capsys):
    out, report = tmp_path / "out", tmp_path / "r.json"
    common = [five_meshes, "--out-dir", out, "--report", report]
    assert batch(*common, "--shard", "1/2") == 0
    assert summary(report) == {f"mesh_{i}.ply": "done" for i in (0, 2, 4)}
    capsys.readouterr()
    assert batch(*common, "--merge") == 1
    assert "2 of 5 meshes have no output, the first is mesh_1.ply: not tried yet" in (
        capsys.readouterr().err
    )
    assert summary(report)["mesh_1.ply"] == "missing"
    assert batch(*common, "--shard", "2/2") == 0
    assert batch(*common, "--merge") == 0
    assert summary(report) == {f"mesh_{i}.ply": "skipped" for i in range(5)}
    assert outputs(out) == outputs(five_faired)


def test_failures_may_be_allowed(five_meshes, tmp_path, capsys):
    bad = tmp_path / "bad.ply"
    bad.write_text("no mesh")
    common = [five_meshes / "mesh_0.ply", bad, "--out-dir", tmp_path / "out"]
    assert batch(*common, "--allow-failures") == 0
    assert "adaptive-fairing: bad.ply: cannot read" in capsys.readouterr().err
    assert batch(*common, "--merge") == 1
    assert "1 of 2 meshes have no output, the first is bad.ply: cannot read" in (
        capsys.readouterr().err
    )
    assert batch(*common, "--merge", "--steps", "3", algorithm="fair") == 1
    told = capsys.readouterr().err
    assert "2 of 2 meshes have no output" in told
    assert told.endswith(": not tried yet\n")


def test_lines_that_flamenco_counts(five_meshes, tmp_path, capsys):
    assert batch(five_meshes, "--out-dir", tmp_path, "--flamenco", "--quiet") == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.startswith("Time: ") for line in lines] == [True] * 5
    assert sorted(line.split(" | ")[1] for line in lines) == [
        f"mesh_{i}.ply: done" for i in range(5)
    ]


def test_a_limit_that_no_mesh_fits_under_is_told(five_meshes, tmp_path, capsys):
    assert batch(five_meshes / "mesh_0.ply", "--out-dir", tmp_path, "--memory", "100M") == 1
    assert "the limit is 0.10 GB: raise --memory" in capsys.readouterr().err


def test_the_result_may_be_of_another_kind(five_meshes, tmp_path):
    assert batch(five_meshes / "mesh_0.ply", "--out-dir", tmp_path, "--format", "blend") == 0
    assert len(import_mesh(tmp_path / "mesh_0.blend").data.shape_keys.key_blocks) == 6


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["a.ply", "b.ply", "c.ply"], "give the folder for the outputs with --out-dir"),
        (["a.ply", "b.ply", "-o", "c.ply"], "-o is for a single mesh"),
        (["a.ply", "--jobs", "2"], "give the folder for the outputs"),
        (["a.ply", "--out-dir", "o", "--jobs", "0"], "--jobs 0"),
        (["a.ply", "--out-dir", "o", "--shard", "3/2"], "--shard 3/2"),
        (["a.ply", "--out-dir", "o", "--memory", "much"], "--memory much"),
        (["a.ply", "--out-dir", "o", "--format", "doc"], "--format doc"),
        (["a.ply", "--out-dir", "o", "--same-strength"], "--same-strength is for frames"),
        (["x/a.ply", "y/a.ply", "--out-dir", "o"], "have the same output a.ply"),
        (["a.txt", "--out-dir", "o"], "unknown kind of file"),
        (["a.ply", "b.ply", "--out-dir", "o", "--frames", "1-3"], "--frames is for one animated"),
        (["a.abc", "--out-dir", "o", "--frames", "3-1"], "1 comes before 3"),
        (["a.abc", "--frames", "1-3", "-o", "o.ply"], "in a .blend file only"),
        (["a.abc", "--frames", "1-3", "-o", "o.blend", "--shard", "1/2"], "-o needs all frames"),
        (["a.abc", "--frames", "1-3", "-o", "o.blend", "--format", "obj"], "omit --format"),
        (["a.abc", "--frames", "1-3", "--out-dir", "o", "--format", "blend"], "as mesh files"),
        (["a.ply", "--sequence", "--out-dir", "o"], "no frame number"),
        (["a.ply", "--out-dir", "o", "--strength", "0"], "strength must be"),
    ],
)
def test_contradictions_are_status_2_and_one_line(capsys, arguments, message):
    assert cli.main(["denoise", *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert message in err
