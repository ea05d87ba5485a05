"""Batches of files with unusual names, and of files that are to be replaced."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from support.batches import batch, outputs, summary
from support.meshes import random_closed
from support.raw_files import ply_bytes

from adaptive_fairing.batch.plan import RECORDS

ROOT = Path(__file__).resolve().parents[3]
NAMES = {
    "not UTF-8": os.fsdecode(b"stra\xdfe.ply"),
    "accents": "Ärger und Éclairs.ply",
    "a line end": "two\nlines.ply",
    "wide letters, as long as can be": "点" * 83 + "ab.ply",
    "a dash": "-o.ply",
    "quotes": """it's "quoted" %s $HOME.ply""",
}
LOCALES = {"UTF-8": "C.UTF-8", "POSIX": "POSIX"}


@pytest.mark.skipif(sys.platform == "win32", reason="names of POSIX")
@pytest.mark.parametrize("locale", LOCALES.values(), ids=LOCALES)
def test_files_may_have_any_name(tmp_path, locale):
    given, out = tmp_path / "given", tmp_path / "out"
    given.mkdir()
    for name in NAMES.values():
        (given / name).write_bytes(ply_bytes(*random_closed(seed=1)))
    (given / os.fsdecode(b"bad\xff.ply")).write_bytes(b"no mesh")
    command = [
        sys.executable,
        "-m",
        "adaptive_fairing",
        "fair",
        given,
        "--out-dir",
        out,
        "--flamenco",
    ]
    command += ["--report", tmp_path / "r.json", "--allow-failures"]
    for status in ("done", "skipped"):
        result = subprocess.run(
            command, cwd=ROOT, env={**os.environ, "LC_ALL": locale}, capture_output=True,
            check=False,
        )  # fmt: skip
        assert result.returncode == 0, result.stderr
        # The file that fails, the summary, and the note that it did not count as a failure.
        assert result.stderr.count(b"\n") == 3
        assert result.stdout.count(b"\n") == len(NAMES) + 1
        told = {Path(name).name: told for name, told in summary(tmp_path / "r.json").items()}
        expected = dict.fromkeys(NAMES.values(), status)
        assert told == {**expected, os.fsdecode(b"bad\xff.ply"): "failed"}
    assert sorted(outputs(out)) == sorted(NAMES.values())


# It leaves before the bpy module is taken down, where some versions hang.
ONE_BY_ONE = """
import os
import sys
from adaptive_fairing.cli import main
given, *outputs = sys.argv[1:]
for output in outputs:
    report = ["--quiet", "--report", output + ".json"]
    assert main.main(["denoise", given, "-o", output, *report]) == 0, ascii(output)
os._exit(0)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="names of POSIX")
@pytest.mark.parametrize("locale", LOCALES.values(), ids=LOCALES)
def test_a_single_file_may_have_any_name(tmp_path, locale):
    given = tmp_path / NAMES["not UTF-8"]
    given.write_bytes(ply_bytes(*random_closed(seed=1)))
    outs = [
        tmp_path / os.fsdecode(f"Ü{suffix}".encode("latin-1"))
        for suffix in (".blend", ".obj", ".stl", ".ply", ".usda", ".fbx")
    ]
    result = subprocess.run(
        [sys.executable, "-c", ONE_BY_ONE, given, *outs],
        cwd=ROOT, env={**os.environ, "LC_ALL": locale}, capture_output=True, check=False,
    )  # fmt: skip
    assert (result.returncode, result.stderr) == (0, b"")
    for out in outs:
        assert out.stat().st_size > 0
        report = out.with_name(out.name + ".json").read_text()
        assert json.loads(report)["output"] == str(out)


def test_a_name_that_a_format_cannot_have_is_told_in_one_line(tmp_path, capsys):
    given = tmp_path / "in.ply"
    given.write_bytes(ply_bytes(*random_closed(seed=1)))
    assert batch(given, "-o", tmp_path / os.fsdecode(b"\xdc.glb")) == 1
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert err.endswith("surrogates not allowed\n")
    assert "Traceback" not in err


class TestReplacingInputs:
    @pytest.fixture
    def given(self, five_meshes, tmp_path, monkeypatch):
        shutil.copytree(five_meshes, tmp_path / "given")
        monkeypatch.chdir(tmp_path / "given")
        return tmp_path / "given"

    def test_it_is_refused_unless_asked_for(self, given, capsys):
        before = outputs(given)
        assert batch("*.ply", "--out-dir", ".") == 2
        assert batch("mesh_0.ply", "-o", "mesh_0.ply") == 2
        assert "add --overwrite-inputs" in capsys.readouterr().err
        assert outputs(given) == before

    def test_asked_for_it_is_done_once(self, given, five_faired, tmp_path):
        command = [".", "--out-dir", ".", "--overwrite-inputs", "--quiet"]
        assert batch(*command) == 0
        assert outputs(given) == outputs(five_faired)
        assert batch(*command, "--report", tmp_path / "r.json") == 0
        assert set(summary(tmp_path / "r.json").values()) == {"skipped"}
        assert outputs(given) == outputs(five_faired)
        # A file that is replaced by another is an input again.
        shutil.copy("mesh_0.ply", "mesh_1.ply")
        assert batch(*command, "--report", tmp_path / "r.json") == 0
        assert summary(tmp_path / "r.json")["mesh_1.ply"] == "done"
        assert len(list((given / RECORDS).iterdir())) == 5

    def test_a_single_one_is_replaced_if_asked_for(self, given, five_faired):
        assert batch("mesh_0.ply", "-o", "mesh_0.ply", "--overwrite-inputs", "--quiet") == 0
        expected = (five_faired / "mesh_0.ply").read_bytes()
        assert (given / "mesh_0.ply").read_bytes() == expected
