"""Readers of .obj and .ply that keep every vertex and face as it stands in the file."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

_PLY_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2",
    "int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8",
}  # fmt: skip


class RawMesh(NamedTuple):
    """Vertices (n, 3) and polygons as tuples of vertex indices."""

    vertices: np.ndarray
    faces: list[tuple[int, ...]]


def read_mesh_file(path: Path) -> RawMesh:
    """Read a file by its suffix, one of `READERS`."""
    return READERS[path.suffix.lower()](path)


def read_obj(path: Path) -> RawMesh:
    """Read the positions and faces of an .obj file."""
    vertices: list[list[float]] = []
    faces: list[tuple[int, ...]] = []
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append([float(word) for word in words[1:4]])
        elif words[:1] == ["f"]:
            numbers = [int(word.split("/")[0]) for word in words[1:]]
            faces.append(tuple(k - 1 if k > 0 else len(vertices) + k for k in numbers))
    return RawMesh(np.array(vertices).reshape(-1, 3), faces)


def read_ply(path: Path) -> RawMesh:
    """Read the positions and faces of an ASCII or binary .ply file."""
    data = path.read_bytes()
    start = data.index(b"end_header")
    start = data.index(b"\n", start) + 1
    header = [line.split() for line in data[:start].decode("ascii", "replace").splitlines()]
    layout = next(words[1] for words in header if words[:1] == ["format"])
    values = _Values(data[start:], layout)
    vertices, faces = np.empty((0, 3)), []
    for words in header:
        if words[:1] != ["element"]:
            continue
        name, count = words[1], int(words[2])
        properties = _properties_of(header, words)
        rows = values.rows(count, properties)
        if name == "vertex":
            names = [each[-1] for each in properties]
            columns = [names.index(axis) for axis in "xyz"]
            vertices = np.array([[row[k] for k in columns] for row in rows], dtype=float)
        elif name == "face":
            place = next(k for k, each in enumerate(properties) if each[0] == "list")
            faces = [tuple(int(index) for index in row[place]) for row in rows]
    return RawMesh(vertices.reshape(-1, 3), faces)


READERS = {".obj": read_obj, ".ply": read_ply}


def _properties_of(header: list[list[str]], element: list[str]) -> list[list[str]]:
    """Return the properties of an element, as words behind "property"."""
    properties = []
    for words in header[header.index(element) + 1 :]:
        if words[:1] != ["property"]:
            break
        properties.append(words[1:])
    return properties


class _Values:
    """The body of a .ply file, value by value."""

    def __init__(self, body: bytes, layout: str) -> None:
        self._body = body
        self._words = body.split() if layout == "ascii" else None
        self._order = ">" if layout == "binary_big_endian" else "<"
        self._place = 0

    def rows(self, count: int, properties: list[list[str]]) -> list[list]:
        return [[self._value(each) for each in properties] for _ in range(count)]

    def _value(self, words: list[str]):
        if words[0] != "list":
            return self._take(words[0], 1)[0]
        return self._take(words[2], int(self._take(words[1], 1)[0]))

    def _take(self, kind: str, count: int) -> list[float]:
        first = self._place
        if self._words is not None:
            self._place += count
            return [float(word) for word in self._words[first : self._place]]
        dtype = np.dtype(self._order + _PLY_TYPES[kind])
        self._place += count * dtype.itemsize
        return np.frombuffer(self._body, dtype, count, first).tolist()
