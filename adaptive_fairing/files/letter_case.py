"""Letter case of a file system: names that differ in upper and lower case only."""

from __future__ import annotations

import tempfile
import unicodedata
from pathlib import Path


def folded(path: Path) -> str:
    """Write a path so that all names of one file are equal where case does not count.

    Nor does it count there whether an accent is a character of its own.
    """
    return unicodedata.normalize("NFC", str(path)).casefold()


def ignores_case(folder: Path) -> bool:
    """Find out by a short-lived file whether case does not count, as on Windows and macOS.

    Parameters
    ----------
    folder
        Need not exist yet: then the one that it would be made in is asked. A folder that cannot
        be written to counts as one that tells names apart.
    """
    place = next(each for each in (folder.absolute(), *folder.absolute().parents) if each.is_dir())
    try:
        with tempfile.NamedTemporaryFile("w+b", prefix="case", dir=place) as probe:
            path = Path(probe.name)
            return path.with_name(path.name.swapcase()).exists()
    except OSError:
        return False
