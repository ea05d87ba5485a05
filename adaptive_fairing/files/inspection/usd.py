"""Inspection of .usd files, text or binary, and of packages of them: the faces of their meshes.

Blender's importer trusts the number of corners of each face. If they add up to more corners than
there are, it reads beyond the end: the result differs from run to run, or it crashes.
"""

from __future__ import annotations

import re
import struct
import zipfile
import zlib
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .contents import Contents, DamagedError, refuse_unknown_vertices
from .usd_crate import MAGIC, Crate

_ZIP, _TEXT = b"PK\3\4", b"#usda"

_DEFINITION = re.compile(rb"^[ \t]*(?:def|over|class)\b[^\n]*", re.MULTILINE)
_NAME = re.compile(rb'"([^"]*)"')


class Faces(NamedTuple):
    """Faces of a mesh: its name, the corners of each counted, all corners, the number of points."""

    mesh: str
    counts: NDArray[np.int64]
    corners: NDArray[np.int64]
    n_points: int | None


def inspect_usd(path: Path) -> Contents:
    """Check that the corners of all faces are there; animated values are not checked."""
    for faces in _meshes(path.read_bytes()):
        _check(faces)
    return Contents()


def _meshes(data: bytes) -> Iterator[Faces]:
    if data.startswith(_ZIP):
        try:
            with zipfile.ZipFile(BytesIO(data)) as package:
                for name in package.namelist():
                    if Path(name).suffix.lower() in (".usd", ".usda", ".usdc"):
                        yield from _meshes(package.read(name))
        except (zipfile.BadZipFile, zlib.error, RuntimeError, EOFError, ValueError) as error:
            raise DamagedError(f"its package is damaged ({error})") from error
    elif data.startswith(_TEXT):
        yield from _meshes_of_text(data)
    elif data.startswith(MAGIC):
        try:
            yield from list(_meshes_of_crate(data))
        except (NotImplementedError, ValueError, IndexError, KeyError, struct.error):
            return  # what is damaged so that it cannot be read, Blender refuses


def _check(faces: Faces) -> None:
    bad = np.flatnonzero(faces.counts < 0)
    if len(bad):
        raise DamagedError(f"{len(bad)} faces of {faces.mesh!r} have a negative number of corners")
    promised, there = int(faces.counts.sum()), len(faces.corners)
    if promised != there:
        raise DamagedError(
            f"its faceVertexCounts of {faces.mesh!r} promise {promised} corners of faces, {there} "
            "are there"
        )
    if faces.n_points is not None:
        face_of = np.repeat(np.arange(len(faces.counts)), faces.counts)
        is_bad = (faces.corners < 0) | (faces.corners >= faces.n_points)
        refuse_unknown_vertices(np.unique(face_of[is_bad]), faces.n_points)


def _meshes_of_crate(data: bytes) -> Iterator[Faces]:
    crate = Crate(data)
    prims: dict[str, dict[str, int]] = {}
    for attribute in crate.attributes():
        prims.setdefault(attribute.prim, {})[attribute.name] = attribute.value
    for prim, values in prims.items():
        if "faceVertexCounts" in values and "faceVertexIndices" in values:
            yield Faces(
                prim.rpartition("/")[2],
                crate.integers(values["faceVertexCounts"]),
                crate.integers(values["faceVertexIndices"]),
                crate.length(values["points"]) if "points" in values else None,
            )


def _meshes_of_text(data: bytes) -> Iterator[Faces]:
    heads = list(_DEFINITION.finditer(data))
    for head, following in zip(heads, [*heads[1:], None], strict=True):
        # The numbers of a mesh stand above what else is in it.
        body = data[head.end() : following.start() if following else len(data)]
        counts, corners = (
            _list(body, rb"int[] faceVertexCounts"), _list(body, rb"int[] faceVertexIndices")
        )  # fmt: skip
        if counts is None or corners is None:
            continue
        name = _NAME.search(head[0])
        points = _list(body, rb"point3f[] points")
        yield Faces(
            name[1].decode("utf-8", "replace") if name else "a mesh",
            _whole_numbers(counts),
            _whole_numbers(corners),
            None if points is None else points.count(b"("),
        )


def _list(body: bytes, name: bytes) -> bytes | None:
    """Find the text between the brackets of a list."""
    found = re.search(rb"\b" + re.escape(name) + rb"\s*=\s*\[([^\]]*)\]", body)
    return None if found is None else found[1]


def _whole_numbers(text: bytes) -> NDArray[np.int64]:
    try:
        return np.array(text.replace(b",", b" ").split(), dtype=np.bytes_).astype(np.int64)
    except (ValueError, OverflowError) as error:
        raise DamagedError("a face has text where a whole number should be") from error
