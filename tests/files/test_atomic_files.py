"""Files that are whole or absent."""

import errno
import os
import platform
import stat
import subprocess
import sys
import time
from pathlib import Path

import pytest

from adaptive_fairing.files.atomic_files import (
    remove_drafts,
    replaced_file,
    replaced_files,
    require_space,
    writable_place,
)

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def old(tmp_path):
    path = tmp_path / "name.txt"
    path.write_text("old")
    return path


@pytest.mark.parametrize("replaced", [replaced_file, replaced_files])
def test_the_file_changes_only_at_the_end(old, replaced):
    with replaced(old) as draft:
        assert draft.suffix == ".txt"
        draft.write_text("new")
        assert old.read_text() == "old"
    assert old.read_text() == "new"
    assert list(old.parent.iterdir()) == [old]


@pytest.mark.parametrize("replaced", [replaced_file, replaced_files])
@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_an_error_leaves_the_old_file_and_no_draft(old, replaced, error):
    with pytest.raises(error), replaced(old) as draft:
        draft.write_text("half")
        raise error
    assert old.read_text() == "old"
    assert list(old.parent.iterdir()) == [old]


@pytest.mark.parametrize("replaced", [replaced_file, replaced_files])
def test_errors_of_the_system_name_the_file_and_the_reason(old, replaced):
    with pytest.raises(OSError) as caught, replaced(old):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), "draft")
    assert str(caught.value) == f"cannot write {old}: No space left on device"


@pytest.fixture
def windows(monkeypatch):
    """Imitate Windows, where no file that a program has open can be replaced or removed."""
    held: set[Path] = set()
    message = "The process cannot access the file because it is being used by another process"

    def unless_held(change):
        def changed(*paths, **options):
            if held & {Path(path) for path in paths}:
                raise PermissionError(errno.EACCES, message, str(paths[0]), 32, str(paths[-1]))
            return change(*paths, **options)

        return changed

    monkeypatch.setattr(os, "replace", unless_held(os.replace))
    monkeypatch.setattr(Path, "unlink", unless_held(Path.unlink))
    return held


@pytest.mark.parametrize("replaced", [replaced_file, replaced_files])
def test_a_file_that_a_program_has_open_stays_and_the_draft_goes(old, windows, replaced):
    windows.add(old)
    with pytest.raises(OSError) as caught, replaced(old) as draft:
        draft.write_text("new")
    assert str(caught.value) == (
        f"cannot write {old}: The process cannot access the file because it is being used by "
        "another process; close it in other programs"
    )
    assert old.read_text() == "old"
    assert list(old.parent.iterdir()) == [old]
    windows.clear()
    with replaced(old) as draft:
        draft.write_text("new")
    assert old.read_text() == "new"


def test_a_draft_that_a_program_has_open_hides_no_error_and_goes_later(old, windows):
    with pytest.raises(ValueError, match="of the body"), replaced_file(old) as draft:
        draft.write_text("half")
        windows.add(draft)
        raise ValueError("of the body")
    remove_drafts(old)
    assert sorted(old.parent.iterdir()) == sorted([old, draft])
    windows.clear()
    remove_drafts(old)
    assert list(old.parent.iterdir()) == [old]


@pytest.mark.parametrize("replaced", [replaced_file, replaced_files])
def test_the_content_is_what_was_written(old, replaced):
    content = bytes(range(256)) * 1000
    with replaced(old) as draft:
        draft.write_bytes(content)
    assert old.read_bytes() == content


@pytest.mark.parametrize("replaced", [replaced_file, replaced_files])
def test_an_empty_draft_is_a_failure(old, replaced):
    with pytest.raises(OSError, match="No space left"), replaced(old) as draft:
        draft.touch()
    assert old.read_text() == "old"


def test_companions_keep_their_names_and_folders(old):
    with replaced_files(old) as draft:
        assert draft.name == old.name
        draft.write_text("new")
        (draft.parent / "more").mkdir()
        (draft.parent / "more" / "companion.bin").write_text("also")
    assert (old.parent / "more" / "companion.bin").read_text() == "also"
    assert sorted(path.name for path in old.parent.iterdir()) == ["more", "name.txt"]


def test_a_file_in_the_place_of_a_folder_of_companions_is_named(old):
    (old.parent / "textures").write_text("of another program")
    message = f"cannot write {old}: textures is a file where a folder is needed"
    with pytest.raises(OSError) as caught, replaced_files(old) as draft:
        draft.write_text("new")
        (draft.parent / "textures").mkdir()
        (draft.parent / "textures" / "wood.png").write_text("also")
    assert str(caught.value) == message
    assert (old.read_text(), len(list(old.parent.iterdir()))) == ("old", 2)


@pytest.mark.parametrize("has_links", [True, False])
def test_a_companion_replaces_nothing(old, monkeypatch, has_links):
    """Not even what appears there at the last moment."""
    if not has_links:

        def refuse(*_):
            raise OSError(errno.EPERM, os.strerror(errno.EPERM))

        monkeypatch.setattr(os, "link", refuse)
    beside = old.with_name("companion.bin")

    def write(content):
        with replaced_files(old) as draft:
            draft.write_text("new")
            (draft.parent / "companion.bin").write_text(content)

    beside.write_text("of another program")
    with pytest.raises(OSError, match=r"cannot write .*name\.txt: "):
        write("also")
    assert (old.read_text(), beside.read_text()) == ("old", "of another program")
    beside.unlink()
    for _ in range(2):  # the second time an equal file is there
        write("also")
        assert (old.read_text(), beside.read_text()) == ("new", "also")
    assert sorted(path.name for path in old.parent.iterdir()) == ["companion.bin", "name.txt"]


def test_a_symbolic_link_stays_one(old):
    link = old.with_name("link.txt")
    link.symlink_to(old)
    with replaced_file(link) as draft:
        draft.write_text("new")
    assert link.is_symlink()
    assert old.read_text() == "new"


def test_the_new_file_has_the_usual_permissions(old):
    ordinary = old.with_name("ordinary")
    ordinary.write_text("x")
    with replaced_file(old) as draft:
        draft.write_text("new")
    assert old.stat().st_mode == ordinary.stat().st_mode


@pytest.mark.skipif(sys.platform == "win32", reason="modes of POSIX")
@pytest.mark.parametrize("replaced", [replaced_file, replaced_files])
@pytest.mark.parametrize("mode", [0o600, 0o664, 0o755])
def test_a_file_that_is_replaced_keeps_its_mode(old, replaced, mode):
    old.chmod(mode)
    with replaced(old) as draft:
        draft.write_text("new")
    assert stat.S_IMODE(old.stat().st_mode) == mode


@pytest.mark.parametrize("suffix", ["", "@"])
def test_what_a_killed_process_has_left_is_removed_and_nothing_else(old, suffix):
    """Blender writes a .blend file under a name with an @ first."""
    code = "import os; os.kill(os.getpid(), 9)" if sys.platform != "win32" else "os._exit(1)"
    writer = (
        "import sys; from adaptive_fairing.files.atomic_files import replaced_file\n"
        f"with replaced_file({str(old)!r}) as draft:\n"
        f"    open(str(draft) + {suffix!r}, 'w').write('half')\n    {code}"
    )
    subprocess.run([sys.executable, "-c", writer], cwd=ROOT, check=False)
    left = set(old.parent.iterdir()) - {old}
    assert len(left) == 1
    for other in (".name.0123456789ab.png", ".name.txt", ".name.of_mine.txt", "name.txt@"):
        old.with_name(other).write_text("mine")
    remove_drafts(old)
    assert not left & set(old.parent.iterdir())
    assert len(list(old.parent.iterdir())) == 5


@pytest.mark.skipif(sys.platform == "win32", reason="there an open file cannot be removed anyway")
@pytest.mark.parametrize("replaced", ["replaced_file", "replaced_files"])
def test_what_another_process_is_writing_stays_and_is_finished(old, replaced):
    writer = (
        f"import sys; from adaptive_fairing.files.atomic_files import {replaced} as replaced\n"
        f"with replaced({str(old)!r}) as draft:\n"
        "    draft.write_text('whole')\n    print(flush=True)\n    input()"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", writer],
        cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    process.stdout.readline()
    remove_drafts(old)
    assert old.read_text() == "old"
    process.communicate("\n")
    assert process.returncode == 0
    assert old.read_text() == "whole"
    assert list(old.parent.iterdir()) == [old]


@pytest.mark.parametrize(("age", "is_left"), [(60, True), (2 * 3600, False)])
def test_what_another_machine_may_be_writing_stays_for_an_hour(old, monkeypatch, age, is_left):
    with monkeypatch.context() as patch:
        patch.setattr(platform, "node", lambda: "another")
        with replaced_file(old) as draft:
            draft.write_text("new")
    draft.write_text("half")
    os.utime(draft, (time.time() - age,) * 2)
    remove_drafts(old)
    assert draft.exists() == is_left


@pytest.mark.parametrize("replaced", [replaced_file, replaced_files])
@pytest.mark.parametrize("letter", ["n", "é", "点", "𝔛"])
def test_a_name_may_be_as_long_as_the_system_takes(tmp_path, replaced, letter):
    path = tmp_path / f"{letter * (251 // len(letter.encode()))}.txt"
    with replaced(path) as draft:
        draft.write_text("new")
    assert path.read_text() == "new"


def test_a_link_that_leads_round_is_named(tmp_path):
    (tmp_path / "loop.txt").symlink_to("loop.txt")
    with pytest.raises(OSError, match=r"cannot write .*loop\.txt: "):
        writable_place(tmp_path / "loop.txt")


@pytest.mark.parametrize(
    ("place", "message"),
    [
        (".", "it is a folder, add a file name"),
        ("no/file.txt", "its folder does not exist, make it first"),
        (os.devnull, "it is not a regular file"),
    ],
)
def test_places_that_cannot_be_written_are_named(tmp_path, place, message):
    with pytest.raises(OSError, match=message):
        writable_place(tmp_path / place)


WRITE_CARELESSLY = """
import os, resource, sys
from pathlib import Path
from adaptive_fairing.files.atomic_files import replaced_file, require_space
resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
try:
    if sys.argv[2] == "ahead":
        require_space(Path(sys.argv[1]).parent, 5000)
    else:
        with replaced_file(sys.argv[1]) as draft:
            file = os.open(draft, os.O_WRONLY | os.O_CREAT)
            os.write(file, bytes(5000))  # writes 4096 bytes, and nobody looks
            os.close(file)
except OSError as error:
    print(error)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no limit for file sizes")
@pytest.mark.parametrize("when", ["ahead", "after"])
def test_a_file_that_was_cut_off_is_noticed(old, when):
    result = subprocess.run(
        [sys.executable, "-c", WRITE_CARELESSLY, str(old), when],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    assert "File too large" in result.stdout
    assert old.read_text() == "old"
    assert list(old.parent.iterdir()) == [old]


def test_space_that_is_there_is_given_back(tmp_path):
    require_space(tmp_path, 3 << 20)
    assert list(tmp_path.iterdir()) == []
