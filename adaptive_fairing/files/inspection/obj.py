"""Look at a .obj file: vertices and faces as lines of text."""

from __future__ import annotations

import re
import warnings
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...core.errors import listed
from .contents import LARGEST, Contents, DamagedError, refuse_not_finite, refuse_unknown_vertices

_VERTEX = re.compile(rb"^[ \t]*v[ \t]", re.MULTILINE)
_FACE = re.compile(rb"^[ \t]*f[ \t]+([^\r\n]*)", re.MULTILINE)
_GROUP = re.compile(rb"^[ \t]*g[ \t]", re.MULTILINE)

_CHUNK = 100_000

# Matches numbers that are certainly finite in single precision, as nearly all are. Vertices with
# other numbers are read one by one, which is slow.
_PLAIN = rb"[ \t]+[-+]?(?:\d{1,8}(?:\.\d*)?|\.\d+)(?:[eE][-+]?[0-2]?\d)?"
_UNUSUAL_VERTEX = re.compile(
    rb"^[ \t]*v(?=[ \t])(?!(?:" + _PLAIN + rb"){3}(?:\s|\Z))[ \t]*([^\r\n]*)", re.MULTILINE
)


def inspect_obj(path: Path) -> Contents:
    """Check coordinates and the vertices of faces; count both."""
    data = path.read_bytes()
    if b"\\" in data:
        data = re.sub(rb"\\\r?\n", b"  ", data)
    vertices = _places(_VERTEX, data)
    _check_coordinates(data, vertices)
    faces = _places(_FACE, data)
    _check_faces(data, faces, vertices)
    group = _GROUP.search(data)
    is_crossed = group is not None and len(faces) > 0 and bool(faces[0] < group.start())
    return Contents(len(vertices), len(faces), has_faces_before_groups=is_crossed)


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
    lines = (match[1] for match in _FACE.finditer(data))
    bad = []
    for start in range(0, len(faces), _CHUNK):
        # A face may name only vertices above it; negative numbers count back from there.
        known = np.searchsorted(vertices, faces[start : start + _CHUNK])
        bad.append(start + _with_unknown_vertices(list(islice(lines, _CHUNK)), known))
    refuse_unknown_vertices(np.concatenate(bad) if bad else [], len(vertices))


def _with_unknown_vertices(faces: list[bytes], known: NDArray[np.intp]) -> NDArray[np.int64]:
    """Find the faces that name other vertices than the first `known` ones, (m,)."""
    # In "12/3/4" the vertex is the first number.
    text = re.sub(rb"/\S*|#[^\n]*", b"", b"\n".join(faces))
    sizes = [len(line.split()) for line in text.split(b"\n")]
    face_of = np.repeat(np.arange(len(faces)), sizes)
    corners = _numbers(text)
    if len(corners) != len(face_of):
        raise DamagedError("a face has text where the number of a vertex should be")
    known = known[face_of]
    return np.unique(face_of[(corners == 0) | (corners > known) | (corners < -known)])


def _numbers(text: bytes) -> NDArray[np.int64]:
    """Read whole numbers, up to the first thing that is none."""
    with warnings.catch_warnings():
        # numpy warns of text that is no number.
        warnings.simplefilter("ignore", DeprecationWarning)
        try:
            return np.fromstring(text.decode("ascii", "replace"), dtype=np.int64, sep=" ")
        except ValueError:
            return np.empty(0, dtype=np.int64)
