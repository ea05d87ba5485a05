"""Batches with Blender in the worker processes: results, resuming, what is told."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from support.meshes import bumpy_disc, icosphere, random_closed
from support.objects import add_object, add_rich_object

from adaptive_fairing import cli
from adaptive_fairing.batch.plan import RECORDS
from adaptive_fairing.blender.files import empty_scene, export_mesh, import_mesh, save_blend
from adaptive_fairing.blender.mesh_data import read_positions

ROOT = Path(__file__).resolve().parents[2]
SAME_BYTES = (".obj", ".ply", ".stl", ".glb", ".gltf")
"""Formats that hold nothing but the mesh; the others have dates, addresses or chance in them."""


def batch(*arguments):
    """Run a batch; give its status."""
    return cli.main([str(argument) for argument in arguments])


def command(*arguments):
    """Start the program in a process of its own."""
    return subprocess.Popen(
        [sys.executable, "-m", "adaptive_fairing", *map(str, arguments)],
        cwd=ROOT,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=None if sys.platform == "win32" else _heed_interrupts,
    )


def _heed_interrupts():
    """Undo what a shell does to programs in the background, for a test to interrupt one."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def summary(path):
    """Status of every output in a summary."""
    return {mesh["output"]: mesh["status"] for mesh in json.loads(path.read_text())["meshes"]}


def outputs(folder):
    """All files below a folder but the records, as bytes by name."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and RECORDS not in path.parts
    }


@pytest.fixture(scope="module")
def meshes(tmp_path_factory):
    """Give a folder with five small meshes."""
    folder = tmp_path_factory.mktemp("meshes")
    for seed in range(5):
        empty_scene()
        export_mesh(add_object(*random_closed(seed)), folder / f"mesh_{seed}.ply", alone=True)
    return folder


@pytest.fixture(scope="module")
def faired(meshes, tmp_path_factory):
    """Give a folder with their results, made one by one."""
    folder = tmp_path_factory.mktemp("one by one")
    for path in meshes.iterdir():
        assert cli.main([str(path), "-o", str(folder / path.name), "--quiet"]) == 0
    return folder


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
            assert cli.main([str(path), "-o", str(alone / path.name), "--quiet"]) == 0
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
def seen(meshes, tmp_path_factory):
    """Three good meshes and three that fail, each for its own reason."""
    folder = tmp_path_factory.mktemp("seen")
    bad = folder / "bad.ply"
    bad.write_text("this is no mesh")
    points = folder / "points.obj"
    points.write_text("v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n")
    inputs = [*(meshes / f"mesh_{i}.ply" for i in range(3)), bad, points, folder / "no.stl"]
    process = command(
        *inputs, "--out-dir", folder / "out", "--jobs", 2, "--report", folder / "r.json",
        "--steps", 2,
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
        assert lines[3].startswith("adaptive-fairing: 6 meshes: 3 faired, 3 failed; ")
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
        assert bad["error"].startswith("1 vertices of mesh 'points'")
        assert bad["vertices"] is None


class TestResuming:
    @pytest.fixture
    def place(self, meshes, tmp_path):
        """Inputs of one's own, their finished outputs, and a function that runs the batch."""
        given = tmp_path / "given"
        shutil.copytree(meshes, given)
        for path in (given / "mesh_3.ply", given / "mesh_4.ply"):
            path.unlink()
        out, report = tmp_path / "out", tmp_path / "r.json"

        def again(*arguments):
            status = batch(given, "--out-dir", out, "--quiet", "--report", report, *arguments)
            assert status == 0
            return [status for _, status in sorted(summary(report).items())]

        assert again() == ["done"] * 3
        return given, out, again

    def test_finished_outputs_are_left_alone(self, place):
        _, out, again = place
        before = {path: path.stat().st_mtime_ns for path in out.iterdir() if path.is_file()}
        assert again() == ["skipped"] * 3
        assert before == {path: path.stat().st_mtime_ns for path in before}

    def test_other_settings_make_them_anew(self, place):
        _, out, again = place
        before = outputs(out)
        assert again("--tau", "0.02") == ["done"] * 3
        after = outputs(out)
        assert all(after[name] != before[name] for name in before)
        assert again() == ["done"] * 3
        assert outputs(out) == before

    def test_settings_that_do_not_change_the_result_do_not(self, place):
        _, _, again = place
        assert again("--jobs", "2", "--memory", "4G") == ["skipped"] * 3

    def test_a_changed_input_is_faired_anew(self, place):
        given, out, again = place
        shutil.copy(given / "mesh_0.ply", given / "mesh_1.ply")
        assert again() == ["skipped", "done", "skipped"]
        found = outputs(out)
        assert found["mesh_1.ply"] == found["mesh_0.ply"]

    def test_an_output_that_is_gone_or_not_the_same_is_made_again(self, place):
        _, out, again = place
        before = outputs(out)
        (out / "mesh_0.ply").unlink()
        (out / "mesh_2.ply").write_bytes(before["mesh_2.ply"][:-10])
        assert again() == ["done", "skipped", "done"]
        assert outputs(out) == before

    def test_a_record_that_is_gone_or_broken_is_no_proof(self, place):
        _, out, again = place
        (out / RECORDS / "mesh_0.ply.json").unlink()
        (out / RECORDS / "mesh_1.ply.json").write_text('{"status": "done"')
        assert again() == ["done", "done", "skipped"]

    def test_what_failed_is_tried_again(self, place):
        given, _, again = place
        bad = given / "mesh_1.ply"
        good = bad.read_bytes()
        bad.write_text("no mesh")
        with pytest.raises(AssertionError):
            again()
        bad.write_bytes(good)
        assert again() == ["skipped", "done", "skipped"]


def test_files_that_belong_to_the_input_count(tmp_path):
    """The coordinates of a .gltf are in the .bin beside it."""
    export_mesh(add_object(*random_closed(1)), tmp_path / "a.gltf", alone=True)
    run = (
        tmp_path / "a.gltf",
        "--out-dir",
        tmp_path / "out",
        "--report",
        tmp_path / "r.json",
        "-q",
    )
    run = (*run[:-1], "--quiet")
    assert batch(*run) == 0
    os.utime(tmp_path / "a.bin", ns=(1, 1))
    assert batch(*run) == 0
    assert summary(tmp_path / "r.json") == {"a.gltf": "done"}
    assert batch(*run) == 0
    assert summary(tmp_path / "r.json") == {"a.gltf": "skipped"}


@pytest.mark.skipif(sys.platform == "win32", reason="processes cannot be killed like that")
def test_a_killed_batch_leaves_whole_outputs_and_goes_on_where_it_was(meshes, faired, tmp_path):
    given = tmp_path / "given"
    given.mkdir()
    for copy in range(4):
        for path in meshes.iterdir():
            shutil.copy(path, given / f"{path.stem}_{copy}.ply")
    out = tmp_path / "out"
    process = command(given, "--out-dir", out, "--jobs", 2)
    while not any(out.glob("*.ply")):
        time.sleep(0.01)
    process.kill()
    process.communicate()
    time.sleep(1)  # the workers notice and leave
    left = outputs(out)
    assert 0 < len([name for name in left if not name.startswith(".")]) < 20
    # Records that are whole: the kill may have left a hidden draft of one more.
    records = list((out / RECORDS).iterdir()) if (out / RECORDS).exists() else []
    finished = len([path for path in records if not path.name.startswith(".")])
    assert batch(given, "--out-dir", out, "--quiet", "--report", tmp_path / "r.json") == 0
    assert list(summary(tmp_path / "r.json").values()).count("skipped") == finished
    found, expected = outputs(out), outputs(faired)
    assert len(found) == 20, "and no drafts"
    for name, content in {**found, **left}.items():
        if not name.startswith("."):
            assert content == expected[f"{name[: len('mesh_0')]}.ply"], name


@pytest.mark.skipif(sys.platform == "win32", reason="processes cannot be killed like that")
def test_a_killed_worker_costs_only_its_mesh(tmp_path):
    """One mesh takes long enough to be hit; the one after it is done by another process."""
    import psutil

    given = tmp_path / "given"
    given.mkdir()
    export_mesh(add_object(*icosphere(6)), given / "a_large.ply", alone=True)
    empty_scene()
    export_mesh(add_object(*random_closed(1)), given / "b_small.ply", alone=True)
    process = command(given, "--out-dir", tmp_path / "out", "--report", tmp_path / "r.json")
    workers = []
    while not workers:
        # Importing numpy and the like starts processes too, for a moment.
        children = psutil.Process(process.pid).children()
        workers = [child for child in children if "--worker" in command_line(child)]
    os.kill(workers[0].pid, signal.SIGKILL)
    _, err = process.communicate()
    assert process.returncode == 1
    assert "a_large.ply: the worker process was ended by signal 9 (SIGKILL)" in err
    assert summary(tmp_path / "r.json") == {"a_large.ply": "failed", "b_small.ply": "done"}


def command_line(process):
    """Arguments of a process; none if it has ended meanwhile."""
    import psutil

    try:
        return process.cmdline()
    except psutil.Error:
        return []


def test_shards_make_the_whole_and_merge_sums_them_up(meshes, faired, tmp_path, capsys):
    out, report = tmp_path / "out", tmp_path / "r.json"
    common = [meshes, "--out-dir", out, "--report", report]
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
    assert outputs(out) == outputs(faired)


def test_failures_may_be_allowed(meshes, tmp_path, capsys):
    bad = tmp_path / "bad.ply"
    bad.write_text("no mesh")
    common = [meshes / "mesh_0.ply", bad, "--out-dir", tmp_path / "out"]
    assert batch(*common, "--allow-failures") == 0
    assert "adaptive-fairing: bad.ply: cannot read" in capsys.readouterr().err
    assert batch(*common, "--merge") == 1
    assert "1 of 2 meshes have no output, the first is bad.ply: cannot read" in (
        capsys.readouterr().err
    )
    assert batch(*common, "--merge", "--steps", "3") == 1
    told = capsys.readouterr().err
    assert "2 of 2 meshes have no output" in told
    assert told.endswith(": not tried yet\n")


def test_lines_that_flamenco_counts(meshes, tmp_path, capsys):
    assert batch(meshes, "--out-dir", tmp_path, "--flamenco", "--quiet") == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.startswith("Time: ") for line in lines] == [True] * 5
    assert sorted(line.split(" | ")[1] for line in lines) == [
        f"mesh_{i}.ply: done" for i in range(5)
    ]


def test_a_limit_that_no_mesh_fits_under_is_told(meshes, tmp_path, capsys):
    assert batch(meshes / "mesh_0.ply", "--out-dir", tmp_path, "--memory", "100M") == 1
    assert "the limit is 0.10 GB: raise --memory" in capsys.readouterr().err


def test_the_result_may_be_of_another_kind(meshes, tmp_path):
    assert batch(meshes / "mesh_0.ply", "--out-dir", tmp_path, "--format", "blend") == 0
    assert len(import_mesh(tmp_path / "mesh_0.blend").data.shape_keys.key_blocks) == 5


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["a.ply", "b.ply"], "give the folder for the outputs with --out-dir"),
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
        (["a.ply", "--out-dir", "o", "--steps", "0"], "steps must be"),
    ],
)
def test_contradictions_are_status_2_and_one_line(capsys, arguments, message):
    assert cli.main(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert message in err


@pytest.mark.skipif(sys.platform == "win32", reason="no such signals")
def test_ctrl_c_says_how_to_go_on(meshes, tmp_path):
    given = tmp_path / "given"
    given.mkdir()
    for copy in range(8):  # enough to be at work when the signal comes
        for path in meshes.iterdir():
            shutil.copy(path, given / f"{path.stem}_{copy}.ply")
    process = command(given, "--out-dir", tmp_path / "out")
    while not any(tmp_path.glob("out/*.ply")):
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate()
    assert process.returncode == 130
    assert err.splitlines()[-1] == (
        "adaptive-fairing: error: interrupted: what is finished stays, run again to go on"
    )
