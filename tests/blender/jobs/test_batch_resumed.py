"""Batches that go on where an earlier run was: what counts as finished; runs that are killed."""

from __future__ import annotations

import os
import shutil
import signal
import sys
import time

import psutil
import pytest
from support.batches import batch, command, outputs, summary
from support.meshes import icosphere, random_closed
from support.objects import add_object
from support.raw_files import ply_bytes

from adaptive_fairing.batch.plan import RECORDS
from adaptive_fairing.blender.files.mesh_files import export_mesh


@pytest.fixture(scope="module")
def finished(five_meshes, tmp_path_factory):
    """A folder with three inputs and their finished outputs, to be copied."""
    folder = tmp_path_factory.mktemp("finished")
    given = folder / "given"
    shutil.copytree(five_meshes, given)
    for path in (given / "mesh_3.ply", given / "mesh_4.ply"):
        path.unlink()
    options = ("--out-dir", folder / "out", "--quiet", "--report", folder / "r.json")
    assert batch(given, *options, algorithm="denoise") == 0
    assert list(summary(folder / "r.json").values()) == ["done"] * 3
    return folder


class TestResuming:
    @pytest.fixture
    def place(self, finished, tmp_path):
        """Inputs of one's own, their finished outputs, and a function that runs the batch."""
        shutil.copytree(finished, tmp_path, dirs_exist_ok=True)  # with the times of all files
        given, out, report = (tmp_path / name for name in ("given", "out", "r.json"))

        def again(*arguments, algorithm="denoise"):
            options = ("--out-dir", out, "--quiet", "--report", report, *arguments)
            status = batch(given, *options, algorithm=algorithm)
            assert status == 0
            return [status for _, status in sorted(summary(report).items())]

        return given, out, again

    def test_finished_outputs_are_left_alone(self, place):
        _, out, again = place
        before = {path: path.stat().st_mtime_ns for path in out.iterdir() if path.is_file()}
        assert again() == ["skipped"] * 3
        assert before == {path: path.stat().st_mtime_ns for path in before}

    def test_other_settings_make_them_anew(self, place):
        _, out, again = place
        before = outputs(out)
        assert again("--tau", "0.02", algorithm="fair") == ["done"] * 3
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
    report = tmp_path / "r.json"
    run = (tmp_path / "a.gltf", "--out-dir", tmp_path / "out", "--report", report, "--quiet")
    assert batch(*run) == 0
    os.utime(tmp_path / "a.bin", ns=(1, 1))
    assert batch(*run) == 0
    assert summary(report) == {"a.gltf": "done"}
    assert batch(*run) == 0
    assert summary(report) == {"a.gltf": "skipped"}


@pytest.mark.skipif(sys.platform == "win32", reason="processes cannot be killed like that")
def test_a_killed_batch_leaves_whole_outputs_and_goes_on_where_it_was(
    five_meshes, five_faired, tmp_path
):
    given = tmp_path / "given"
    given.mkdir()
    for copy in range(4):
        for path in five_meshes.iterdir():
            shutil.copy(path, given / f"{path.stem}_{copy}.ply")
    out = tmp_path / "out"
    options = ("--out-dir", out)
    process = command(given, *options, "--jobs", 2)
    while not any(out.glob("*.ply")):
        assert process.poll() is None
        time.sleep(0.01)
    workers = psutil.Process(process.pid).children(recursive=True)
    process.kill()
    process.communicate()
    _, alive = psutil.wait_procs(workers, timeout=60)
    assert not alive, "the workers notice and leave"
    left = outputs(out)
    assert 0 < len([name for name in left if not name.startswith(".")]) < 20
    # Records that are whole: the kill may have left a hidden draft of one more.
    records = list((out / RECORDS).iterdir()) if (out / RECORDS).exists() else []
    finished = len([path for path in records if not path.name.startswith(".")])
    assert batch(given, *options, "--quiet", "--report", tmp_path / "r.json") == 0
    assert list(summary(tmp_path / "r.json").values()).count("skipped") == finished
    found, expected = outputs(out), outputs(five_faired)
    assert len(found) == 20, "and no drafts"
    for name, content in {**found, **left}.items():
        if not name.startswith("."):
            assert content == expected[f"{name[: len('mesh_0')]}.ply"], name


@pytest.mark.skipif(sys.platform == "win32", reason="processes cannot be killed like that")
def test_a_killed_worker_costs_only_its_mesh(tmp_path):
    """One mesh takes long enough to be hit; the one after it is done by another process."""
    given = tmp_path / "given"
    given.mkdir()
    (given / "a_large.ply").write_bytes(ply_bytes(*icosphere(6)))
    (given / "b_small.ply").write_bytes(ply_bytes(*random_closed(1)))
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
    try:
        return process.cmdline()
    except psutil.Error:
        return []


def test_two_identical_batches_at_once_do_not_disturb_each_other(
    five_meshes, five_faired, tmp_path
):
    out = tmp_path / "out"
    both = [command(five_meshes, "--out-dir", out) for _ in range(2)]
    told = [process.communicate()[1] for process in both]
    assert [process.returncode for process in both] == [0, 0], told
    assert outputs(out) == outputs(five_faired)


@pytest.mark.skipif(sys.platform == "win32", reason="no such signals")
def test_ctrl_c_says_how_to_go_on(five_meshes, tmp_path):
    given = tmp_path / "given"
    given.mkdir()
    for copy in range(8):  # enough to be at work when the signal comes
        for path in five_meshes.iterdir():
            shutil.copy(path, given / f"{path.stem}_{copy}.ply")
    process = command(given, "--out-dir", tmp_path / "out")
    while not any(tmp_path.glob("out/*.ply")):
        assert process.poll() is None
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate()
    assert process.returncode == 130
    assert err.splitlines()[-1] == (
        "adaptive-fairing: error: interrupted: finished outputs stay, run again to continue"
    )
