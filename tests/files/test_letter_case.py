"""Names that differ in case only, on a file system of this machine and on imitated others."""

from pathlib import Path

import pytest

from adaptive_fairing.files.letter_case import folded, ignores_case


@pytest.fixture
def case_does_not_count(monkeypatch):
    """Imitate Windows and macOS: a name is found in any case."""

    def exists(path):
        return folded(path) in {folded(found) for found in path.parent.iterdir()}

    monkeypatch.setattr(Path, "exists", exists)


def test_a_file_system_says_what_it_does(tmp_path):
    (tmp_path / "name").touch()
    assert ignores_case(tmp_path) == (tmp_path / "NAME").exists()


def test_an_imitated_one_ignores_case(tmp_path, case_does_not_count):
    assert ignores_case(tmp_path)


def test_a_folder_that_does_not_exist_yet_is_like_the_one_around_it(tmp_path, case_does_not_count):
    assert ignores_case(tmp_path / "later" / "deeper")
    assert list(tmp_path.iterdir()) == []


def test_the_probe_is_removed(tmp_path):
    ignores_case(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_where_nothing_can_be_written_names_are_told_apart(tmp_path, monkeypatch):
    def refuse(*mode, **options):
        raise PermissionError(options["dir"])

    monkeypatch.setattr("tempfile.NamedTemporaryFile", refuse)
    assert not ignores_case(tmp_path)


def test_folded_paths_are_equal_where_systems_take_them_for_one():
    assert folded(Path("out/Café.PLY")) == folded(Path("OUT/cafe\u0301.ply"))
    assert folded(Path("out/a.ply")) != folded(Path("out/b.ply"))
