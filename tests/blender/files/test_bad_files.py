"""Bad meshes and bad ends on the command line: notes, refusals, and an old file that survives."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from support.bad_meshes import collapsed, three_sheets, turned
from support.meshes import icosphere, random_closed
from support.objects import add_object

from adaptive_fairing.blender.data.mesh_arrays import read_positions, read_triangles
from adaptive_fairing.blender.files.mesh_files import export_mesh, import_mesh
from adaptive_fairing.cli import main as cli
from adaptive_fairing.core.diffusion import steps
from adaptive_fairing.files import atomic_files

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture
def make(tmp_path):
    """Write a mesh to a file of its own folder."""

    def write(vertices, faces, name="in.ply"):
        folder = tmp_path / "given"
        folder.mkdir(exist_ok=True)
        export_mesh(add_object(vertices, faces), folder / name, alone=True)
        return folder / name

    return write


@pytest.mark.parametrize(
    ("mesh", "expected"),
    [
        (turned, r"\d+ triangles were turned round, for the solve only"),
        (three_sheets, "3 edges have more than two triangles: cut there, their vertices held"),
        (collapsed, r"\d+ triangles have no area, or hardly any: bounded for the solve"),
    ],
)
def test_what_was_wrong_is_noted_on_the_terminal_and_in_the_report(
    make, tmp_path, capsys, mesh, expected
):
    given, report = make(*mesh()), tmp_path / "r.json"
    arguments = ["denoise", str(given), "-o", str(tmp_path / "o.ply"), "--report", str(report)]
    assert cli.main(arguments) == 0
    notes = [line for line in capsys.readouterr().err.splitlines() if ": note: " in line]
    assert re.fullmatch(f"adaptive-fairing: note: {expected}", notes[0])
    written = json.loads(report.read_text(encoding="utf-8"))
    assert [f"adaptive-fairing: note: {note}" for note in written["notes"]] == notes

    assert cli.main([*arguments, "--quiet"]) == 0
    assert capsys.readouterr().err == ""
    assert json.loads(report.read_text(encoding="utf-8"))["notes"] == written["notes"]


def test_faces_come_out_as_they_went_in(make, tmp_path):
    # Turned, cut and bounded for the solve only: the file keeps its own faces.
    for mesh in (turned(), three_sheets(), collapsed()):
        given = make(*mesh)
        assert cli.main(["denoise", str(given), "-o", str(tmp_path / "o.ply"), "--quiet"]) == 0
        expected = read_triangles(import_mesh(given).data)
        found = import_mesh(tmp_path / "o.ply").data
        np.testing.assert_array_equal(read_triangles(found), expected)
        assert np.isfinite(read_positions(found)).all()


def test_a_folder_that_is_a_file_is_status_1(make, tmp_path, capsys):
    given = make(*random_closed(seed=1))
    (tmp_path / "file").write_text("no folder")
    for option in (["-o", tmp_path / "file" / "o.ply"], ["--report", tmp_path / "file" / "r"]):
        arguments = ["denoise", given, "-o", tmp_path / "o.ply", *option]
        assert cli.main([str(argument) for argument in arguments]) == 1
        out, err = capsys.readouterr()
        assert out == ""
        assert re.fullmatch(r"adaptive-fairing: error: cannot write .*/file/\w.*\n", err)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "given"]


KILLED = """
import os, signal, sys
sys.path.insert(0, {root!r})
from adaptive_fairing.cli import main as cli

def die(*arguments, **options):
    os.kill(os.getpid(), signal.SIGKILL)

cli.parse(["fair", "x.ply"])
import adaptive_fairing.blender.jobs.file_job
os.replace = die
cli.main(sys.argv[1:])
"""


def fair_once(given, out):
    """Arguments of a run of one step."""
    return ["fair", str(given), "-o", str(out), "--steps", "1", "--quiet"]


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGKILL")
@pytest.mark.parametrize("suffix", [".blend", ".ply", ".obj"])
def test_a_killed_run_leaves_the_old_file_whole(make, tmp_path, suffix):
    given = make(*icosphere(2))
    out = tmp_path / f"out{suffix}"
    out.write_bytes(b"old" * 1000)
    result = subprocess.run(
        [sys.executable, "-c", KILLED.format(root=str(ROOT)), *fair_once(given, out)],
        capture_output=True,
        check=False,
    )
    assert result.returncode == -9
    assert_old_and_hidden(tmp_path, out)
    # No later run stumbles over what is left.
    assert cli.main(fair_once(given, out)) == 0
    assert out.read_bytes() != b"old" * 1000


def assert_old_and_hidden(folder, out):
    """Require that the file is the old one, and that what else was written is hidden."""
    assert (folder / out.name).read_bytes() == b"old" * 1000
    left = [path.name for path in folder.iterdir() if path.name not in (out.name, "given")]
    assert all(name.startswith(".out.") for name in left)


@pytest.mark.parametrize("suffix", [".blend", ".ply", ".obj"])
def test_others_see_the_old_file_while_a_run_works(make, tmp_path, monkeypatch, suffix):
    """What they see at a moment is what a run that is killed then would leave."""
    given = make(*icosphere(2))
    out = tmp_path / f"out{suffix}"
    out.write_bytes(b"old" * 1000)
    seen = []

    def seen_at(module, name):
        function = getattr(module, name)

        def look_and_go_on(*arguments, **options):
            assert_old_and_hidden(tmp_path, out)
            seen.append(name)
            return function(*arguments, **options)

        monkeypatch.setattr(module, name, look_and_go_on)

    seen_at(steps, "conjugate_gradients")
    seen_at(atomic_files, "_require_whole")
    seen_at(os, "replace")
    assert cli.main(fair_once(given, out)) == 0
    assert sorted(set(seen)) == ["_require_whole", "conjugate_gradients", "replace"]
    assert out.read_bytes() != b"old" * 1000
