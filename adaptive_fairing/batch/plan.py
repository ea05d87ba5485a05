"""Plan of a batch: the input, the output and the record of every mesh."""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ..files.formats import BLEND, MESH_FORMATS, suffix_of
from ..files.letter_case import folded, ignores_case
from .inputs import ArgumentsError, Source, frame_numbers

RECORDS = "fairing_records"
"""Folder below the output folder with one record per mesh."""

_LONGEST_NAME = 240

KEYED_SUFFIX = ".ply"
"""Format of frames that become one object with shape keys: exact, and vertices keep their order."""


@dataclass(frozen=True)
class Item:
    """One mesh to process.

    Attributes
    ----------
    name
        Output relative to the output folder, for messages.
    input
        File with the mesh.
    frame
        Frame of an animated input; None takes the mesh as it is stored.
    number
        Number of the frame on the timeline, if the mesh is part of a sequence.
    output, record
        Files to write.
    """

    name: str
    input: Path
    frame: int | None
    number: int | None
    output: Path
    record: Path


def plan_files(sources: Sequence[Source], folder: Path, suffix: str | None) -> list[Item]:
    """Plan a batch: one output for every file.

    Parameters
    ----------
    sources
        The files.
    folder
        Output folder.
    suffix
        Suffix of the outputs; None takes that of the input.

    Raises
    ------
    ArgumentsError
        Two inputs have the same output.
    """
    items = []
    for source in sources:
        relative = source.relative.with_suffix(suffix or suffix_of(source.path))
        items.append(_item(relative, folder, source.path))
    _require_different_outputs(items, folder)
    return items


def _require_different_outputs(items: Sequence[Item], folder: Path) -> None:
    seen: dict[Path | str, Item] = {}
    for item in items:
        for key in (item.output, folded(item.output)):
            other = seen.setdefault(key, item)
            if other.input == item.input:
                continue
            if other.output == item.output or ignores_case(folder):
                same = "" if other.output == item.output else f", which is {other.name} there"
                raise ArgumentsError(
                    f"{other.input} and {item.input} have the same output {item.name}{same}: give "
                    "the folder that both are in, or fair them into two folders"
                )


def plan_file_frames(sources: Sequence[Source], folder: Path, suffix: str | None) -> list[Item]:
    """Plan a sequence of numbered files, each with the mesh of one frame.

    Parameters and errors as in `plan_files`; an error too if the files are not one sequence.
    """
    items = []
    for source, number in zip(sources, frame_numbers(sources), strict=True):
        relative = Path(source.path.name).with_suffix(suffix or suffix_of(source.path))
        items.append(_item(relative, folder, source.path, number=number))
    return sorted(items, key=lambda item: item.number or 0)


def plan_animation(source: Path, frames: Sequence[int], folder: Path, suffix: str) -> list[Item]:
    """Plan the frames of an animated object in one file.

    Parameters
    ----------
    source
        File with the animation.
    frames
        Frames to process.
    folder, suffix
        Output folder, and the suffix of the outputs.
    """
    width = max(4, len(str(max(frames))))
    return [
        _item(
            Path(f"{source.stem}_{frame:0{width}d}{suffix}"),
            folder,
            source,
            frame=frame,
            number=frame,
        )
        for frame in frames
    ]


def shard_of(items: Sequence[Item], shard: tuple[int, int]) -> list[Item]:
    """Items of shard (i, n): every n-th from the i-th on, because neighbours have similar sizes."""
    index, count = shard
    return list(items[index - 1 :: count])


def parse_shard(text: str) -> tuple[int, int]:
    """Read a shard such as ``2/8``.

    Raises
    ------
    ArgumentsError
        The text is not a shard, or its number is out of range.
    """
    match = re.fullmatch(r"(\d+)/(\d+)", text)
    if match is None or not 1 <= int(match[1]) <= int(match[2]):
        raise ArgumentsError(f"--shard {text}: give i/n with i from 1 to n, such as 2/8")
    return int(match[1]), int(match[2])


def parse_format(text: str) -> str:
    """Suffix of a kind of file, written as ``ply`` or ``.ply``.

    Raises
    ------
    ArgumentsError
        The kind is not supported.
    """
    suffix = f".{text.lower().removeprefix('.')}"
    known = (BLEND, *MESH_FORMATS)
    if suffix not in known:
        raise ArgumentsError(f"--format {text}: use one of {' '.join(known)}")
    return suffix


def _item(
    relative: Path,
    folder: Path,
    source: Path,
    *,
    frame: int | None = None,
    number: int | None = None,
) -> Item:
    record = folder / RECORDS / relative.with_name(f"{_short(relative.name)}.json")
    return Item(relative.as_posix(), source, frame, number, folder / relative, record)


def _short(name: str) -> str:
    """Shorten a name so that a suffix fits into the 255 bytes that file systems allow."""
    data = os.fsencode(name)
    if len(data) <= _LONGEST_NAME:
        return name
    return f"{os.fsdecode(data[:200])}.{hashlib.sha256(data).hexdigest()[:16]}"
