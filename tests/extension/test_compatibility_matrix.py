"""The table of supported Blenders: where tests have been run before, they do not run again."""

from __future__ import annotations

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


def test_an_unknown_version_is_refused(capsys):
    with pytest.raises(SystemExit):
        compatibility_matrix.main(["--tested", "5.9.9"])
    assert "unknown version 5.9.9" in capsys.readouterr().err
