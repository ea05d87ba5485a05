"""Letter case of a file system: names that differ in upper and lower case only."""

from __future__ import annotations

import tempfile
import unicodedata
from pathlib import Path


def folded(path: Path) -> str:
    """Fold a path so that all names of one file are equal where letter case does not count.

    Such file systems also treat an accented letter and its two-character form as equal.
    """
    return unicodedata.normalize("NFC", str(path)).casefold()


def ignores_case(folder: Path) -> bool:
    """Whether letter case does not count, as on Windows and macOS; tried with a short-lived file.

    Parameters
    ----------
    folder
        Folder to try. If it does not exist, the nearest folder above it is tried. A folder that
        cannot be written to counts as one where letter case counts.
    """
    place = next(each for each in (folder.absolute(), *folder.absolute().parents) if each.is_dir())
    try:
        with tempfile.NamedTemporaryFile("w+b", prefix="case", dir=place) as probe:
            path = Path(probe.name)
            return path.with_name(path.name.swapcase()).exists()
    except OSError:
        return False
