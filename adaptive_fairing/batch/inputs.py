"""Input files of a batch, from names, folders and patterns."""

from __future__ import annotations

import glob
import itertools
import os
import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple, NoReturn

from ..files.formats import SUFFIXES, is_supported

MOST_FRAMES = 1_000_000
"""Largest number of frames on Blender's timeline."""


class ArgumentsError(Exception):
    """Arguments that are invalid or contradict each other; the message is one line for the user."""


class Source(NamedTuple):
    """A file to process, and its path below the output folder."""

    path: Path
    relative: Path


def find_sources(inputs: Iterable[str], output_folder: Path) -> list[Source]:
    """Find the files that the arguments name; their order does not depend on that of the arguments.

    Parameters
    ----------
    inputs
        Files; folders, which stand for every mesh file in them and in their subfolders; patterns
        such as ``scans/**/*.ply``, for shells that do not expand them.
    output_folder
        Folders and patterns that contain it do not yield its files as inputs.

    Returns
    -------
    list of Source
        Each file once, in natural order of the names. A file of a folder keeps its subfolder.

    Raises
    ------
    ArgumentsError
        A pattern or folder has no mesh file, a folder cannot be read, or a file is of an unknown
        kind.
    """
    found: dict[Path, Path] = {}
    for text in inputs:
        for source in _sources_of(text, output_folder.resolve()):
            found.setdefault(source.path, source.relative)
    return [Source(*item) for item in sorted(found.items(), key=lambda item: natural_key(item[0]))]


def is_pattern(text: str) -> bool:
    """Whether an argument is a pattern, not the name of an existing file."""
    return glob.has_magic(text) and not Path(text).exists()


def natural_key(path: Path) -> list[tuple[int, int, str]]:
    """Sort key that puts ``frame_9`` before ``frame_10``."""
    parts = re.split(r"(\d+)", str(path))
    return [(1, int(part), part) if part.isdecimal() else (0, 0, part) for part in parts]


def frame_numbers(sources: Sequence[Source]) -> list[int]:
    """Read the numbers of the frames of one sequence from the names of its files.

    The number is the last one in a name, as in ``cloth_0012.ply``.

    Raises
    ------
    ArgumentsError
        A name has no number, two numbers are equal, or the names differ in more than the number.
    """
    numbers: dict[int, Path] = {}
    patterns: dict[str, Path] = {}
    for source in sources:
        match = re.fullmatch(r"(.*?)(\d+)(\D*)", source.path.stem)
        if match is None:
            raise ArgumentsError(f"{source.path.name} has no frame number in its name")
        number = int(match[2])
        if number in numbers:
            raise ArgumentsError(f"{numbers[number]} and {source.path} are both frame {number}")
        numbers[number] = source.path
        patterns.setdefault(f"{match[1]}#{match[3]}{source.path.suffix}", source.path)
    if len(patterns) > 1:
        first, second, *_ = (path.name for path in patterns.values())
        raise ArgumentsError(f"{first} and {second} are not frames of one sequence")
    return list(numbers)


def parse_frames(text: str) -> list[int]:
    """Read a list of frames such as ``1-50`` or ``1, 5, 10-20``: ascending, each frame once.

    Raises
    ------
    ArgumentsError
        The text is not such a list.
    """
    frames: set[int] = set()
    for part in text.split(","):
        match = re.fullmatch(r"\s*(\d+)(?:\s*-\s*(\d+))?\s*", part)
        if match is None:
            raise ArgumentsError(f"--frames {text}: give frames such as 1-50 or 1,5,10-20")
        first, last = int(match[1]), int(match[2] or match[1])
        if last < first:
            raise ArgumentsError(f"--frames {text}: {last} comes before {first}")
        if last - first >= MOST_FRAMES:
            raise ArgumentsError(f"--frames {text}: more than {MOST_FRAMES} frames")
        frames.update(range(first, last + 1))
    return sorted(frames)


def _sources_of(text: str, output_folder: Path) -> list[Source]:
    path = Path(text)
    if path.is_dir():
        root = path.resolve()
        files = [file for file in _files_in(root) if _is_wanted(file, root, output_folder)]
        if not files:
            raise ArgumentsError(f"folder {text} holds no mesh file ({' '.join(SUFFIXES)})")
        return [Source(file, file.relative_to(root)) for file in files]
    if is_pattern(text):
        root = _folder_of_pattern(path).resolve()
        matches = (_absolute(Path(each)) for each in glob.glob(text, recursive=True))
        files = [file for file in matches if _is_wanted(file, root, output_folder)]
        if not files:
            raise ArgumentsError(f"no mesh file matches {text}")
        return [Source(file, Path(file.name)) for file in files]
    if not is_supported(path):
        raise ArgumentsError(f"{path}: unknown kind of file; use one of {' '.join(SUFFIXES)}")
    # A file that does not exist is reported like every mesh that fails, with its reason.
    return [Source(_absolute(path), Path(path.name))]


def _absolute(path: Path) -> Path:
    """Make a path absolute; links are not followed, because outputs are named after them."""
    return Path(os.path.abspath(path))


def _files_in(root: Path) -> Iterator[Path]:
    """Walk through a folder; links to folders are not followed, links to files are."""

    def refuse(error: OSError) -> NoReturn:
        raise ArgumentsError(f"cannot read folder {error.filename}: {error.strerror}")

    for folder, _, names in os.walk(root, onerror=refuse):
        yield from (Path(folder, name) for name in names)


def _folder_of_pattern(pattern: Path) -> Path:
    """Folder that contains every match: the parts of the path before the first wildcard."""
    parts = itertools.takewhile(lambda part: not glob.has_magic(part), pattern.parts)
    return Path(*parts)


def _is_wanted(file: Path, root: Path, output_folder: Path) -> bool:
    """Whether to take a file found in a folder; hidden files are left out, such as drafts."""
    inner = file.relative_to(root).parts if file.is_relative_to(root) else (file.name,)
    is_hidden = any(part.startswith(".") for part in inner)
    # An output folder inside the input folder holds results alone. One around it holds inputs too.
    is_result = output_folder in file.parents and root in output_folder.parents
    return file.is_file() and is_supported(file) and not is_hidden and not is_result
