"""Atomic files: written under another name beside their place, then renamed.

An interrupted run, a full disk or a crash leaves the old file as it was. The rename is atomic
because both names are in one folder, hence on one file system.
"""

from __future__ import annotations

import contextlib
import errno
import glob
import os
import platform
import secrets
import shutil
import string
import time
import zlib
from collections.abc import Iterator, Sequence
from pathlib import Path

from .companions import companions_of, is_same_file


@contextlib.contextmanager
def replaced_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a free path beside `path` with the same suffix; rename that file to `path` at the end.

    Parameters
    ----------
    path
        Final path; an existing file is replaced, a symbolic link is followed.

    Yields
    ------
    Path
        Where to write.

    Raises
    ------
    OSError
        The file cannot be moved there, or the body raised it. No temporary file is left.
    """
    final = writable_place(path)
    draft = final.with_name(f"{_draft_start(final)}{_draft_mark()}{final.suffix}")
    try:
        with _named_errors(final):
            yield draft
            _require_whole(draft)
            _move(draft, final)
    finally:
        # A virus scanner may have a draft open. Then `remove_drafts` removes it later.
        with contextlib.suppress(PermissionError):
            for left in (draft, draft.with_name(f"{draft.name}@")):
                left.unlink(missing_ok=True)


@contextlib.contextmanager
def replaced_files(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a path of the same name in a new folder; move all files of the folder at the end.

    For formats of several files that name each other, such as an .obj and its .mtl. The file itself
    is moved last, when those that it names are in place. It replaces an old one. The others replace
    nothing, because nobody asked for them: see `companions`.

    Parameters, yields and errors as in `replaced_file`.
    """
    final = writable_place(path)
    folder = final.with_name(f"{_draft_start(final)}{_draft_mark()}")
    draft = folder / final.name
    try:
        with _named_errors(final):
            folder.mkdir()
            yield draft
            companions = companions_of(draft)
            for file in [*companions, draft]:
                _require_whole(file)
            with _added(companions, folder, final.parent):
                _move(draft, final)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


@contextlib.contextmanager
def _added(files: Sequence[Path], folder: Path, destination: Path) -> Iterator[None]:
    """Move files into another folder; remove them again if the body raises an error."""
    added: list[Path] = []
    try:
        for file in files:
            place = destination / file.relative_to(folder)
            try:
                place.parent.mkdir(parents=True, exist_ok=True)
            except FileExistsError as error:
                reason = f"{place.parent.name} is a file where a folder is needed"
                raise FileExistsError(error.errno, reason) from error
            if not is_same_file(place, file) and _add(file, place):
                added.append(place)
        yield
    except BaseException:
        for place in added:
            place.unlink(missing_ok=True)
        raise


def _add(file: Path, place: Path) -> bool:
    """Move a finished file to a free path; it is an error if another file is there.

    Returns whether it was moved: another run may have put an equal file there at that moment.
    """
    try:
        os.link(file, place)
    except FileExistsError as error:
        if is_same_file(place, file):
            return False
        reason = f"another program has just made a file {place.name}; run again"
        raise FileExistsError(error.errno, reason) from error
    except OSError:  # a file system without links
        with file.open("rb") as source, place.open("xb") as target:
            shutil.copyfileobj(source, target)
    return True


def remove_drafts(path: str | os.PathLike[str]) -> None:
    """Remove drafts of a file that killed processes have left; a running process keeps its own."""
    final = Path(os.path.realpath(path))
    start = _draft_start(final)
    for draft in final.parent.glob(f"{glob.escape(start)}*"):
        # Blender writes a .blend under a name with one more letter first.
        name = draft.name.removeprefix(start).removesuffix("@").removesuffix(final.suffix)
        if _is_mark(name) and not _is_being_written(draft, name):
            with contextlib.suppress(PermissionError):  # still open somewhere, on Windows
                if draft.is_dir():
                    shutil.rmtree(draft)
                else:
                    draft.unlink()


def _draft_start(final: Path) -> str:
    # Systems count bytes, of which a letter may have several.
    return f".{os.fsdecode(os.fsencode(final.stem)[:100])}."


def _draft_mark() -> str:
    """Mark in the name of a draft: its machine, its process and a random number."""
    return f"{_machine()}{os.getpid():08x}{secrets.token_hex(4)}"


def _machine() -> str:
    return f"{zlib.crc32(platform.node().encode()):08x}"


def _is_mark(text: str) -> bool:
    return len(text) == 24 and set(text) <= set(string.hexdigits)


def _is_being_written(draft: Path, mark: str) -> bool:
    """Whether the process that writes a draft may still be running."""
    try:
        age = time.time() - draft.stat().st_mtime
    except FileNotFoundError:  # it has just been finished
        return True
    is_ours = mark.startswith(_machine())
    return age < _LONGEST_PAUSE and (not is_ours or _is_running(int(mark[8:16], 16)))


_LONGEST_PAUSE = 3600.0
"""Seconds after which a draft counts as abandoned, in case its process number is used again."""


def _is_running(process: int) -> bool:
    """Whether another process is running."""
    # Windows has no such question, and removes no file that is open.
    if process == os.getpid() or os.name == "nt":
        return False
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:  # somebody else's
        return True
    return True


def writable_place(path: str | os.PathLike[str]) -> Path:
    """Check that a file can be written, before the work for it begins.

    Returns
    -------
    Path
        Absolute, symbolic links followed.

    Raises
    ------
    OSError
        The file cannot be written; the message says in one line why not.
    """
    final = Path(os.path.realpath(path))
    try:
        final.stat()
    except FileNotFoundError:
        pass
    except OSError as error:
        raise OSError(f"cannot write {final}: {error.strerror}") from error
    if final.is_dir():
        raise IsADirectoryError(f"cannot write {final}: it is a folder, add a file name")
    if final.exists() and not final.is_file():
        raise OSError(f"cannot write {final}: it is not a regular file")
    if not final.parent.is_dir():
        raise FileNotFoundError(f"cannot write {final}: its folder does not exist, make it first")
    if not os.access(final.parent, os.W_OK):
        raise PermissionError(f"cannot write {final}: no permission to write into its folder")
    return final


def require_space(folder: Path, n_bytes: int) -> None:
    """Check that a folder has room, by filling it for a moment.

    For writers that crash on a full disk. The free space that the system reports is not enough: it
    ignores quotas and the limits of the process.

    Raises
    ------
    OSError
        There is not enough room.
    """
    probe = folder / f".{secrets.token_hex(6)}"
    try:
        _append_zeros(probe, n_bytes)
    finally:
        probe.unlink(missing_ok=True)


def _move(draft: Path, final: Path) -> None:
    """Move a finished file to its place; it keeps the permissions of the file that it replaces."""
    if final.exists():
        shutil.copymode(final, draft)
    try:
        os.replace(draft, final)
    except PermissionError as error:  # Windows replaces no file that is open
        reason = f"{error.strerror}; close it in other programs"
        raise PermissionError(error.errno, reason) from error


def _require_whole(file: Path) -> None:
    """Check that the disk was not full when the file was written.

    Blender's writers do not notice: they leave a truncated file and report success. On a full disk
    the file cannot grow; if it can, it was written to its end.
    """
    size = file.stat().st_size
    if size == 0:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    _append_zeros(file, _PROBE_SIZE)
    os.truncate(file, size)


# More than a block of any file system, because the last block of a file may have room left.
_PROBE_SIZE = 1 << 16


def _append_zeros(file: Path, n_bytes: int) -> None:
    piece = bytes(min(n_bytes, 1 << 20))
    with file.open("ab") as stream:
        for start in range(0, n_bytes, len(piece)):
            stream.write(piece[: n_bytes - start])
        stream.flush()
        os.fsync(stream.fileno())


@contextlib.contextmanager
def _named_errors(final: Path) -> Iterator[None]:
    """Name the file instead of its draft in errors of the operating system, and the reason."""
    try:
        yield
    except OSError as error:
        raise OSError(f"cannot write {final}: {error.strerror or error}") from error
