"""Inspection of .obj files: vertices and faces as lines of text."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...core.errors import listed
from .contents import (
    FAR,
    LARGEST,
    SMALLEST,
    Contents,
    DamagedError,
    FarPoints,
    is_far,
    refuse_not_finite,
    refuse_unknown_vertices,
    require_single_precision,
)

_VERTEX = re.compile(rb"^[ \t]*v[ \t]", re.MULTILINE)
_FACE = re.compile(rb"^[ \t]*f[ \t]+([^\r\n]*)", re.MULTILINE)
_GROUP = re.compile(rb"^[ \t]*g[ \t]", re.MULTILINE)
_OBJECT = re.compile(rb"^[ \t]*o[ \t]", re.MULTILINE)
_POINT = re.compile(rb"^[ \t]*v[ \t]+(\S+)[ \t]+(\S+)[ \t]+(\S+)", re.MULTILINE)

_CHUNK = 100_000

_SAMPLE = 1000
"""First vertices, read to find out if a mesh is far or tiny; then all vertices are read."""

# Matches numbers that are certainly finite in single precision, as nearly all are. Vertices with
# other numbers are read one by one, which is slow.
_PLAIN = rb"[ \t]+[-+]?(?:\d{1,8}(?:\.\d*)?|\.\d+)(?:[eE][-+]?[0-2]?\d)?"
_UNUSUAL_VERTEX = re.compile(
    rb"^[ \t]*v(?=[ \t])(?!(?:" + _PLAIN + rb"){3}(?:\s|\Z))[ \t]*([^\r\n]*)", re.MULTILINE
)


def inspect_obj(path: Path) -> Contents:
    """Check coordinates and faces, and count vertices and faces."""
    data = path.read_bytes()
    if b"\\" in data:
        data = re.sub(rb"\\\r?\n", b"  ", data)
    vertices = _places(_VERTEX, data)
    _check_coordinates(data, vertices)
    faces = _places(_FACE, data)
    _check_faces(data, faces, vertices)
    group = _GROUP.search(data)
    is_crossed = group is not None and len(faces) > 0 and bool(faces[0] < group.start())
    return Contents(
        len(vertices),
        len(faces),
        has_faces_before_groups=is_crossed,
        far=_far_points(data, faces, vertices),
    )


def _places(pattern: re.Pattern[bytes], data: bytes) -> NDArray[np.int64]:
    return np.fromiter((match.start() for match in pattern.finditer(data)), dtype=np.int64)


def _check_coordinates(data: bytes, vertices: NDArray[np.int64]) -> None:
    not_numbers, not_finite = [], []
    for match in _UNUSUAL_VERTEX.finditer(data):
        index = int(np.searchsorted(vertices, match.start()))
        try:
            # Python would take "1_000" for a number.
            x, y, z = (float(word.replace(b"_", b"?")) for word in match[1].split()[:3])
        except ValueError:
            not_numbers.append(index)
        else:
            if not (abs(x) <= LARGEST and abs(y) <= LARGEST and abs(z) <= LARGEST):
                not_finite.append(index)
    if not_numbers:
        raise DamagedError(
            f"{len(not_numbers)} vertices are not three numbers: {listed(not_numbers)}"
        )
    refuse_not_finite(not_finite)


def _check_faces(data: bytes, faces: NDArray[np.int64], vertices: NDArray[np.int64]) -> None:
    bad = [
        np.unique(face_of[(corners < 0) | (corners >= known)])
        for face_of, corners, known in _corners(data, faces, vertices)
    ]
    refuse_unknown_vertices(np.concatenate(bad) if bad else [], len(vertices))


def _corners(
    data: bytes, faces: NDArray[np.int64], vertices: NDArray[np.int64]
) -> Iterator[tuple[NDArray[np.int64], ...]]:
    """Read the corners of many faces at a time.

    Yields
    ------
    face_of, corners, known
        (k,) each: the index of the face, its vertex, and the number of vertices above the face in
        the file, which are all that it may name.
    """
    lines = (match[1] for match in _FACE.finditer(data))
    for start in range(0, len(faces), _CHUNK):
        chunk = list(islice(lines, _CHUNK))
        # In "12/3/4" the vertex is the first number.
        text = re.sub(rb"/\S*|#[^\n]*", b"", b"\n".join(chunk))
        sizes = [len(line.split()) for line in text.split(b"\n")]
        face_of = np.repeat(np.arange(len(chunk)), sizes)
        given = _numbers(text)
        if len(given) != len(face_of):
            raise DamagedError("a face has text where the number of a vertex should be")
        known = np.searchsorted(vertices, faces[start : start + _CHUNK])[face_of]
        # Negative numbers count back from the face; 0 names none.
        yield start + face_of, np.where(given < 0, known + given, given - 1), known


def _numbers(text: bytes) -> NDArray[np.int64]:
    """Read whole numbers, up to the first text that is not one."""
    with warnings.catch_warnings():
        # numpy warns of text that is no number.
        warnings.simplefilter("ignore", DeprecationWarning)
        try:
            return np.fromstring(text.decode("ascii", "replace"), dtype=np.int64, sep=" ")
        except ValueError:
            return np.empty(0, dtype=np.int64)


def _far_points(
    data: bytes, faces: NDArray[np.int64], vertices: NDArray[np.int64]
) -> FarPoints | None:
    """Read all coordinates if they are far from the origin; refuse a mesh that is too small."""
    sample = _points(data, _SAMPLE)
    largest = np.abs(sample).max(initial=0)
    if SMALLEST < largest < (FAR - 2) * np.ptp(sample, axis=0).max() / 2:
        return None
    points = _points(data)
    require_single_precision(points)
    if not is_far(points):
        return None
    found = list(_corners(data, faces, vertices))
    face_of, corners = (np.concatenate([part[i] for part in found]) for i in (0, 1))
    # Blender drops vertices that no face uses.
    ends = np.searchsorted(face_of, np.searchsorted(faces, _places(_OBJECT, data)))
    parts = [np.unique(corners), *map(np.unique, np.split(corners, ends))]
    return FarPoints(points, parts)


def _points(data: bytes, limit: int | None = None) -> NDArray[np.float64]:
    """Read the coordinates of the first vertices, or of all; they are already checked."""
    words = [match.groups() for match in islice(_POINT.finditer(data), limit)]
    return np.array(words, dtype=np.bytes_).astype(np.float64).reshape(-1, 3)
