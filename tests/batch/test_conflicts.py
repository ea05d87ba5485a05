"""No file is written over what the program reads, or over another result."""

from __future__ import annotations

import os

import pytest

from adaptive_fairing.batch.conflicts import Pair, require_no_conflict
from adaptive_fairing.batch.inputs import ArgumentsError
from adaptive_fairing.cli import main as cli


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("a.ply", "b.ply"):
        (tmp_path / name).write_text("mesh")
    (tmp_path / "out").mkdir()
    return tmp_path


def refused(capsys, *arguments):
    """Arguments that are refused before anything is done: the line."""
    assert cli.main(["denoise", *map(str, arguments)]) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    return err


@pytest.mark.parametrize(
    "arguments",
    [
        ["a.ply", "b.ply", "--out-dir", "."],
        ["*.ply", "--out-dir", "."],
        ["*.ply", "--out-dir", "out/.."],
        [".", "--out-dir", "out/.."],
        ["a.ply", "-o", "a.ply"],
        ["a.ply", "-o", "out/../a.ply"],
    ],
)
def test_an_output_that_is_its_input_is_refused(capsys, folder, arguments):
    assert "add --overwrite-inputs" in refused(capsys, *arguments)
    assert (folder / "a.ply").read_text() == "mesh"


@pytest.mark.parametrize("link", [os.symlink, os.link], ids=["symbolic", "hard"])
def test_an_output_that_links_to_an_input_is_refused(capsys, folder, link):
    link(folder / "a.ply", folder / "out" / "a.ply")
    assert "is the input" in refused(capsys, "a.ply", "b.ply", "--out-dir", "out")
    assert "is the input" in refused(capsys, "a.ply", "-o", "out/a.ply")
    os.replace(folder / "out" / "a.ply", folder / "out" / "b.ply")
    line = refused(capsys, "a.ply", "b.ply", "--out-dir", "out", "--overwrite-inputs")
    assert "out/b.ply is another input" in line


def test_two_outputs_that_link_to_one_file_are_refused(folder):
    (folder / "out" / "a.ply").write_text("old")
    (folder / "out" / "b.ply").symlink_to("a.ply")
    pairs = [Pair(folder / name, folder / "out" / name) for name in ("a.ply", "b.ply")]
    with pytest.raises(ArgumentsError, match=r"a\.ply and .*b\.ply are one file"):
        require_no_conflict(pairs)


@pytest.mark.parametrize("report", ["a.ply", "out/a.ply", "out/fairing_records/a.ply.json"])
def test_a_report_replaces_no_mesh_and_no_record(capsys, folder, report):
    line = refused(capsys, "a.ply", "b.ply", "--out-dir", "out", "--report", report)
    assert f"{report} is an input or another result" in line


@pytest.mark.parametrize("report", ["a.ply", "./a.ply", "out/o.ply"])
def test_the_report_of_a_single_mesh_replaces_no_mesh(capsys, folder, report):
    line = refused(capsys, "a.ply", "-o", "out/o.ply", "--report", report, "--overwrite-inputs")
    assert "is an input or another result" in line


def test_the_keyed_file_replaces_no_input(capsys, folder):
    (folder / "dance.blend").touch()
    line = refused(capsys, "dance.blend", "--frames", "1-3", "-o", "dance.blend")
    assert "is the input" in line


def test_frames_do_not_replace_their_inputs(capsys, folder):
    (folder / "f1.ply").touch()
    line = refused(capsys, "f1.ply", "--sequence", "--out-dir", ".", "--overwrite-inputs")
    assert "--overwrite-inputs is not for frames" in line
