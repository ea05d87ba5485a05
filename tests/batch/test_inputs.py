"""Input files of a batch, names of their outputs, and refusals."""

from __future__ import annotations

import errno
import os
from itertools import chain
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from adaptive_fairing.batch import plan
from adaptive_fairing.batch.inputs import (
    ArgumentsError,
    Source,
    find_sources,
    frame_numbers,
    parse_frames,
)
from adaptive_fairing.batch.memory_use import parse_bytes, peak_bytes, resident_bytes
from adaptive_fairing.batch.plan import (
    parse_format,
    parse_shard,
    plan_animation,
    plan_file_frames,
    plan_files,
    shard_of,
)

OUT = Path("out")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in (
        "a.ply", "b.OBJ", "b.mtl", "notes.txt", "sub/a.ply", "sub/deep/c.stl", ".d.0123.ply",
        ".hidden/e.ply", "out/a.ply", "[odd] name.ply", "f_10.ply", "f_9.ply",
    ):  # fmt: skip
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    return tmp_path


def names(sources):
    return [source.relative.as_posix() for source in sources]


def sources(*paths):
    return [Source(Path(path).absolute(), Path(Path(path).name)) for path in paths]


def test_a_folder_means_its_mesh_files_but_no_drafts_and_no_results(folder):
    found = find_sources([str(folder)], OUT)
    assert names(found) == [
        "[odd] name.ply", "a.ply", "b.OBJ", "f_9.ply", "f_10.ply", "sub/a.ply", "sub/deep/c.stl",
    ]  # fmt: skip
    assert all(source.path.is_file() for source in found)


def test_a_pattern_means_what_it_matches(folder):
    assert names(find_sources(["*.ply"], OUT)) == ["[odd] name.ply", "a.ply", "f_9.ply", "f_10.ply"]
    assert names(find_sources(["sub/**/*"], OUT)) == ["a.ply", "c.stl"]


def test_a_name_with_brackets_is_a_file_if_there_is_one(folder):
    assert names(find_sources(["[odd] name.ply"], OUT)) == ["[odd] name.ply"]


def test_each_file_once_in_an_order_of_its_own(folder):
    found = find_sources(["f_10.ply", "f_*.ply", "a.ply"], OUT)
    assert names(found) == ["a.ply", "f_9.ply", "f_10.ply"]


def test_a_missing_file_is_a_mesh_that_will_fail(folder):
    assert names(find_sources(["missing.ply"], OUT)) == ["missing.ply"]


@pytest.mark.parametrize(
    ("argument", "message"),
    [
        ("notes.txt", "unknown kind of file"),
        ("*.xyz", "no mesh file matches"),
        ("sub/../empty", "holds no mesh file"),
    ],
)
def test_what_holds_no_mesh_is_refused(folder, argument, message):
    (folder / "empty").mkdir()
    with pytest.raises(ArgumentsError, match=message):
        find_sources([argument], OUT)


def test_outputs_keep_names_kinds_and_subfolders(folder):
    items = plan_files(find_sources([str(folder)], OUT), OUT, None)
    by_name = {item.name: item for item in items}
    assert by_name["sub/deep/c.stl"].output == OUT / "sub/deep/c.stl"
    assert by_name["sub/deep/c.stl"].record == OUT / "fairing_records/sub/deep/c.stl.json"
    assert by_name["b.obj"].input == folder / "b.OBJ"
    assert {item.output.suffix for item in plan_files(sources("a.obj"), OUT, ".glb")} == {".glb"}


def test_two_inputs_with_one_output_are_refused():
    for suffix, pair in ((None, ("x/a.ply", "y/a.ply")), (".blend", ("x/a.ply", "x/a.obj"))):
        with pytest.raises(ArgumentsError, match="have the same output a"):
            plan_files(sources(*pair), OUT, suffix)


@pytest.mark.parametrize(
    ("suffix", "pair"),
    [
        (None, ("x/A.ply", "y/a.ply")),
        (".ply", ("x/A.obj", "x/a.ply")),
        (None, ("x/\u00e9.ply", "y/e\u0301.ply")),
    ],
)
def test_outputs_that_differ_in_case_are_refused_where_they_are_one_file(monkeypatch, suffix, pair):
    """On Windows and macOS; Linux keeps both."""
    monkeypatch.setattr(plan, "ignores_case", lambda folder: False)
    assert len(plan_files(sources(*pair), OUT, suffix)) == 2
    monkeypatch.setattr(plan, "ignores_case", lambda folder: folder == OUT)
    with pytest.raises(ArgumentsError, match=r"have the same output .*, which is .* there"):
        plan_files(sources(*pair), OUT, suffix)


def test_the_disk_is_not_asked_about_names_that_differ_anyway(monkeypatch):
    monkeypatch.setattr(plan, "ignores_case", lambda folder: pytest.fail("asked"))
    assert len(plan_files(sources("x/a.ply", "x/b.ply"), OUT, None)) == 2


def test_frames_are_ordered_by_their_numbers():
    files = sources("cloth_9.ply", "cloth_10.ply", "cloth_0011.ply")
    assert frame_numbers(files) == [9, 10, 11]
    items = plan_file_frames([files[1], files[2], files[0]], OUT, None)
    assert [item.number for item in items] == [9, 10, 11]
    assert [item.frame for item in items] == [None] * 3


@pytest.mark.parametrize(
    ("files", "message"),
    [
        (["cloth.ply"], "cloth.ply has no frame number"),
        (["a_1.ply", "a_01.ply"], "are both frame 1"),
        (["a_1.ply", "b_2.ply"], "a_1.ply and b_2.ply are not frames of one sequence"),
        (["a_1.ply", "a_2.obj"], "are not frames of one sequence"),
    ],
)
def test_what_is_no_sequence_is_refused(files, message):
    with pytest.raises(ArgumentsError, match=message):
        frame_numbers(sources(*files))


@pytest.mark.parametrize(
    ("text", "frames"),
    [("7", [7]), ("1-3", [1, 2, 3]), ("10, 2-4,3", [2, 3, 4, 10]), ("0-1", [0, 1])],
)
def test_lists_of_frames(text, frames):
    assert parse_frames(text) == frames


@pytest.mark.parametrize("text", ["", "a", "1-", "3-1", "1,,2", "1..5"])
def test_what_is_no_list_of_frames_is_refused(text):
    with pytest.raises(ArgumentsError, match="--frames"):
        parse_frames(text)


def test_outputs_of_an_animation_are_numbered_alike():
    items = plan_animation(Path("dance.abc"), [1, 12000], OUT, ".ply")
    assert [item.name for item in items] == ["dance_00001.ply", "dance_12000.ply"]
    assert [item.frame for item in items] == [item.number for item in items] == [1, 12000]


@given(st.integers(0, 200), st.integers(1, 12))
def test_the_shards_are_the_whole_and_do_not_overlap(n_items, n_shards):
    items = list(range(n_items))
    shards = [shard_of(items, (i, n_shards)) for i in range(1, n_shards + 1)]
    assert sorted(chain.from_iterable(shards)) == items
    assert max(map(len, shards)) - min(map(len, shards)) <= 1


def test_arguments_are_read_or_refused():
    assert parse_shard("2/8") == (2, 8)
    for text in ("0/8", "9/8", "2", "a/b", "-1/2"):
        with pytest.raises(ArgumentsError, match="--shard"):
            parse_shard(text)
    assert parse_format("PLY") == parse_format(".ply") == ".ply"
    with pytest.raises(ArgumentsError, match="--format xyz"):
        parse_format("xyz")
    assert [parse_bytes(text) for text in ("8G", "1.5 gb", "300m", "7")] == [
        8 * 10**9, 15 * 10**8, 3 * 10**8, 7,
    ]  # fmt: skip
    for text in ("0", "G", "-1G", "8X"):
        with pytest.raises(ArgumentsError, match="--memory"):
            parse_bytes(text)


def test_the_memory_of_this_process_is_known_where_it_can_be():
    resident, peak = resident_bytes(), peak_bytes()
    if resident is not None:
        assert 10**7 < resident < 1.1 * peak  # the system counts the peak a little late


def test_links_to_files_are_followed_and_links_to_folders_are_not(folder, tmp_path_factory):
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    (elsewhere / "far.ply").touch()
    (folder / "sub" / "near.ply").symlink_to(elsewhere / "far.ply")
    (folder / "sub" / "round").symlink_to(folder, target_is_directory=True)
    (folder / "sub" / "loop.ply").symlink_to("loop.ply")
    (folder / "sub" / "nowhere.ply").symlink_to("gone.ply")
    expected = ["a.ply", "deep/c.stl", "near.ply"]
    found = find_sources([str(folder / "sub")], OUT)
    assert names(found) == expected
    assert all(source.path.is_relative_to(folder) for source in found)
    # Outputs are called after the links.
    assert names(find_sources(["sub/*.ply"], OUT)) == ["a.ply", "near.ply"]
    assert names(find_sources(["sub/loop.ply"], OUT)) == ["loop.ply"]


def test_a_folder_that_cannot_be_read_is_named(folder, monkeypatch):
    scandir = os.scandir

    def refuse(path):
        if str(path).endswith("deep"):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))
        return scandir(path)

    monkeypatch.setattr(os, "scandir", refuse)
    with pytest.raises(ArgumentsError, match=r"cannot read folder .*sub/deep: Permission denied"):
        find_sources([str(folder)], OUT)


def test_an_output_folder_around_the_inputs_hides_none_of_them(folder):
    assert names(find_sources(["sub"], Path())) == ["a.ply", "deep/c.stl"]
