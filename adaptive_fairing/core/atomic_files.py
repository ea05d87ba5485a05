"""Files that are whole or absent: written under another name beside their place, then renamed.

An interrupted run, a full disk or a crash leaves the old file as it was. The rename is atomic
because both names are in one folder, hence on one file system.
"""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def replaced_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a free path beside `path` with the same suffix; rename it to `path` at the end.

    Parameters
    ----------
    path
        Place of the file; an existing one is replaced, a symbolic link is followed.

    Yields
    ------
    Path
        Where to write.

    Raises
    ------
    OSError
        The file cannot be put there; or the error of the body. No temporary file is left.
    """
    final = writable_place(path)
    draft = final.with_name(f".{final.stem[:100]}.{secrets.token_hex(6)}{final.suffix}")
    try:
        yield draft
        os.replace(draft, final)
    finally:
        draft.unlink(missing_ok=True)


@contextmanager
def replaced_files(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a path of the same name in a new folder beside `path`; move all its files at the end.

    For formats of several files that name each other (an .obj and its .mtl). The file itself is
    moved last, when those that it names are in place.

    Parameters, yields, errors: as in `replaced_file`.
    """
    final = writable_place(path)
    folder = final.with_name(f".{final.stem[:100]}.{secrets.token_hex(6)}")
    folder.mkdir()
    draft = folder / final.name
    try:
        yield draft
        companions = [file for file in folder.rglob("*") if file.is_file() and file != draft]
        for file in [*companions, draft]:
            place = final.parent / file.relative_to(folder)
            place.parent.mkdir(parents=True, exist_ok=True)
            os.replace(file, place)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def writable_place(path: str | os.PathLike[str]) -> Path:
    """Check that a file can be written here, before the work for it is done.

    Returns
    -------
    Path
        Absolute, symbolic links followed.

    Raises
    ------
    OSError
        With one line that says what is in the way.
    """
    final = Path(path).resolve()
    if final.is_dir():
        raise IsADirectoryError(f"cannot write {final}: it is a folder, add a file name")
    if final.exists() and not final.is_file():
        raise OSError(f"cannot write {final}: it is not a regular file")
    if not final.parent.is_dir():
        raise FileNotFoundError(f"cannot write {final}: its folder does not exist, make it first")
    if not os.access(final.parent, os.W_OK):
        raise PermissionError(f"cannot write {final}: no permission to write into its folder")
    return final
