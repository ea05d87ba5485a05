"""Companions: files that an exporter writes beside the one that it was asked for.

A .bin, a .mtl, textures: nobody asked for them, so they must not replace an existing file. If that
file is equal, it is shared. Otherwise the companion gets a free name, and the main file refers to
that name.
"""

from __future__ import annotations

import filecmp
import json
import os
from collections.abc import Iterator, Mapping
from itertools import count
from pathlib import Path
from urllib.parse import quote, unquote

Renames = Mapping[str, str]
"""Old and new names, relative to the folder, with slashes."""


def companions_of(draft: Path) -> list[Path]:
    """All other files in the folder of a draft; a draft has a folder of its own."""
    return sorted(file for file in draft.parent.rglob("*") if file.is_file() and file != draft)


def names_to_change(draft: Path) -> Renames:
    """Companions of a draft whose names are taken, each with a free name for it.

    Parameters
    ----------
    draft
        File exported into a folder of its own; all files there are to move to the folder above.
    """
    destination = draft.parent.parent
    files = [file.relative_to(draft.parent) for file in companions_of(draft)]
    new = set(files)
    changes = {}
    for file in files:
        for name in _names(file):
            is_own = name == file or name not in new
            if is_own and _is_home(destination / name, draft.parent / file):
                break
        new.add(name)
        if name != file:
            changes[file.as_posix()] = name.as_posix()
    return changes


def is_same_file(place: Path, file: Path) -> bool:
    """Whether a file exists at a path and equals another file."""
    return place.is_file() and filecmp.cmp(place, file, shallow=False)


def _names(file: Path) -> Iterator[Path]:
    """Yield the name of a file, then numbered variants of it."""
    yield file
    for number in count(2):
        yield file.with_name(f"{file.stem}_{number}{file.suffix}")


def _is_home(place: Path, file: Path) -> bool:
    return not os.path.lexists(place) or is_same_file(place, file)


def rename_in_gltf(draft: Path, names: Renames) -> None:
    """Rename files that a .gltf file refers to, and write their new names into it."""
    scene = json.loads(draft.read_bytes())
    for item in [*scene.get("buffers", []), *scene.get("images", [])]:
        new = names.get(unquote(item.get("uri", "")))
        if new is not None:
            item["uri"] = quote(new)
    text = json.dumps(scene, indent="\t", separators=(",", ":"), ensure_ascii=False)
    draft.write_text(text, encoding="utf-8")
    _rename_files(draft.parent, names)


def rename_in_obj(draft: Path, names: Renames) -> None:
    """Rename the .mtl file that an .obj file refers to, and write its new name into it."""
    lines = draft.read_bytes().splitlines(keepends=True)
    for number, line in enumerate(lines):
        if line.startswith(b"mtllib "):
            new = names.get(os.fsdecode(line[7:].strip()))
            if new is not None:
                lines[number] = b"mtllib " + os.fsencode(new) + b"\n"
    draft.write_bytes(b"".join(lines))
    _rename_files(draft.parent, names)


def _rename_files(folder: Path, names: Renames) -> None:
    for old, new in names.items():
        (folder / old).rename(folder / new)
