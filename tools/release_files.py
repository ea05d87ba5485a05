"""Files beside the zips of a release: checksums, and notes out of CHANGELOG.md."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Sequence
from pathlib import Path

from fetch_wheels import file_sha256

ROOT = Path(__file__).resolve().parent.parent
CHECKSUMS = "SHA256SUMS"
NOTES = "release_notes.md"


class ReleaseError(Exception):
    """The files of a release cannot be made."""


def write(zips: Sequence[Path], folder: Path) -> list[Path]:
    """Write both files into `folder`, where the zips are; return their paths.

    Raises
    ------
    ReleaseError
        CHANGELOG.md says nothing of the manifest's version.
    """
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text("utf-8"))
    changes = (ROOT / "CHANGELOG.md").read_text("utf-8")
    texts = {CHECKSUMS: checksums(zips), NOTES: notes(changes, manifest["version"])}
    for name, text in texts.items():
        (folder / name).write_text(text, "utf-8", newline="\n")
    return [folder / name for name in texts]


def checksums(paths: Sequence[Path]) -> str:
    """Return a line for each file, as `sha256sum --check` reads them."""
    return "".join(f"{file_sha256(path)}  {path.name}\n" for path in sorted(paths))


def notes(changes: str, version: str) -> str:
    """Return the part of a changelog about a version, its heading included.

    Raises
    ------
    ReleaseError
        There is no such part, or it is empty.
    """
    heading = rf"## \[{re.escape(version)}\]"
    found = re.search(rf"^{heading}.*?\n(.*?)(?=^## |\Z)", changes, re.M | re.S)
    if found is None or not found[1].strip():
        raise ReleaseError(f"CHANGELOG.md has nothing about {version}: write what is new")
    return found[0].strip() + "\n"
