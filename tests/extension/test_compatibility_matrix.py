"""The table of supported Blenders: where tests have been run before, they do not run again."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

import compatibility_matrix


def test_tests_run_but_where_they_have_been_run(monkeypatch, tmp_path, capsys):
    tested = []

    def run_tests(row, module, *_):
        tested.append(module.version)
        row.cells["tests"] = "1 passed"

    monkeypatch.setattr(compatibility_matrix, "make_environment", lambda *_: Path("python"))
    monkeypatch.setattr(compatibility_matrix, "make_test_packages", lambda *_: tmp_path)
    monkeypatch.setattr(compatibility_matrix, "check_blender", lambda *_, **__: None)
    monkeypatch.setattr(compatibility_matrix, "_run_tests", run_tests)
    monkeypatch.setattr(compatibility_matrix.build_extension, "build", lambda *_, **__: [tmp_path])
    versions = [module.version for module in compatibility_matrix.BLENDERS]
    assert compatibility_matrix.main(["--tested", versions[2]]) == 0
    assert tested == versions[:2] + versions[3:]
    lines = capsys.readouterr().out.splitlines()[2:]
    cells = [line.strip("| ").rpartition("|")[2].strip() for line in lines]
    assert cells == ["1 passed", "1 passed", "run before", "1 passed"]


def test_the_core_is_tested_once_for_each_python_and_numpy(monkeypatch, tmp_path, capsys):
    """Blender 4.5 and 5.0 have the same; each has its own tests of the add-on."""
    ran = []

    def run_isolated(command, work, **environment):
        ran.append(Path(command[-1]).name)
        return subprocess.CompletedProcess(command, 0, f"{len(ran)} passed in 1.00s", "")

    monkeypatch.setattr(compatibility_matrix, "run_isolated", run_isolated)
    monkeypatch.setattr(compatibility_matrix, "make_environment", lambda *_: Path("python"))
    monkeypatch.setattr(compatibility_matrix, "make_test_packages", lambda *_: tmp_path)
    monkeypatch.setattr(compatibility_matrix, "check_blender", lambda *_, **__: None)
    monkeypatch.setattr(compatibility_matrix.build_extension, "build", lambda *_, **__: [tmp_path])
    for tested, expected in (
        ([], ["1 passed + 2 passed", "3 passed + 4 passed", "core as in 4.5.15 + 5 passed"]),
        (["5.0.1"], ["1 passed + 2 passed", "core as in 5.0.1 + 3 passed", "run before"]),
    ):
        ran.clear()
        only = [module.version for module in compatibility_matrix.BLENDERS[:3]]
        assert compatibility_matrix.main(["--only", *only, "--tested", *tested]) == 0
        lines = capsys.readouterr().out.splitlines()[2:]
        assert [line.strip("| ").rpartition("|")[2].strip() for line in lines] == expected


def test_an_unknown_version_is_refused(capsys):
    with pytest.raises(SystemExit):
        compatibility_matrix.main(["--tested", "5.9.9"])
    assert "unknown version 5.9.9" in capsys.readouterr().err
