"""Inspection of binary .fbx files: a tree of nodes with numbers and arrays as properties."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .contents import Contents, DamagedError, refuse_unknown_vertices, require_single_precision

_MAGIC = b"Kaydara FBX Binary  \0\x1a\0"
_FIRST_NODE = 27
_WIDE_OFFSETS = 7500
"""Version from which on offsets have eight bytes instead of four."""

_NUMBER_BYTES = {"Y": 2, "C": 1, "B": 1, "I": 4, "F": 4, "D": 8, "L": 8}
_ARRAYS = {"f": "<f4", "d": "<f8", "l": "<i8", "i": "<i4", "b": "u1", "c": "u1"}
_LARGEST_RATIO = 1032
"""Largest number of bytes that deflate makes from one."""

_DEEPEST = 64


class Node(NamedTuple):
    """A node with its path of names, such as ``Objects/Geometry/Vertices``, and its arrays."""

    path: str
    arrays: list[NDArray[Any]]


def inspect_fbx(path: Path) -> Contents:
    """Check that all nodes and arrays are complete, and check coordinates and faces.

    The number of vertices is not compared, because a file may hold shapes beside its meshes.
    """
    data = path.read_bytes()
    if not data.startswith(_MAGIC):
        return Contents()  # text, which Blender refuses
    points: NDArray[Any] = np.empty((0, 3))
    try:
        version = struct.unpack_from("<I", data, len(_MAGIC))[0]
        for node in _nodes(data, _FIRST_NODE, len(data), version >= _WIDE_OFFSETS, "", 0):
            if node.path == "/Objects/Geometry/Vertices" and node.arrays:
                points = node.arrays[0].reshape(-1, 3)
                require_single_precision(points)
            elif node.path == "/Objects/Geometry/PolygonVertexIndex" and node.arrays:
                _check_faces(node.arrays[0], len(points))
    except (struct.error, zlib.error, ValueError) as error:
        raise DamagedError(f"cut short or damaged ({error})") from error
    return Contents()


def _check_faces(corners: NDArray[Any], n_vertices: int) -> None:
    is_last = corners < 0  # the last corner of a face is stored as -1 - vertex
    vertices = np.where(is_last, ~corners, corners)
    face_of: NDArray[np.intp] = np.cumsum(is_last) - is_last
    refuse_unknown_vertices(np.unique(face_of[vertices >= n_vertices]), n_vertices)


def _nodes(
    data: bytes, place: int, end: int, is_wide: bool, path: str, depth: int
) -> Iterator[Node]:
    """Walk the nodes between two offsets, and the nodes in them; read only arrays of geometry."""
    layout = struct.Struct("<QQQB" if is_wide else "<IIIB")
    if depth > _DEEPEST:
        raise DamagedError("its nodes are nested too deeply")
    while place < end:
        node_end, n_properties, n_bytes, name_length = layout.unpack_from(data, place)
        if node_end == 0:
            return
        name_start = place + layout.size
        first = name_start + name_length
        children = first + n_bytes
        if not children <= node_end <= end:
            raise DamagedError("cut short or damaged: a node ends beyond the file or its parent")
        name = f"{path}/{data[name_start:first].decode('latin-1')}"
        yield Node(name, _arrays(data, first, children, n_properties, name))
        yield from _nodes(data, children, node_end, is_wide, name, depth + 1)
        place = node_end


def _arrays(data: bytes, place: int, end: int, count: int, name: str) -> list[NDArray[Any]]:
    """Check the properties of a node, and return its arrays if they are geometry."""
    found = []
    for _ in range(count):
        kind = chr(data[place]) if place < end else ""
        place += 1
        if kind in _NUMBER_BYTES:
            place += _NUMBER_BYTES[kind]
        elif kind in ("S", "R"):
            place += 4 + struct.unpack_from("<I", data, place)[0]
        elif kind in _ARRAYS:
            length, is_packed, n_bytes = struct.unpack_from("<III", data, place)
            dtype = np.dtype(_ARRAYS[kind])
            wanted, there = length * dtype.itemsize, n_bytes if is_packed else end - place - 12
            if wanted > there * (_LARGEST_RATIO if is_packed else 1):
                raise DamagedError(f"cut short or damaged: {name} promises {length} numbers")
            place += 12 + (n_bytes if is_packed else wanted)
            if name.startswith("/Objects/Geometry/") and place <= end:
                piece = data[place - n_bytes : place] if is_packed else data[place - wanted : place]
                piece = zlib.decompress(piece) if is_packed else piece
                if len(piece) != wanted:
                    raise DamagedError(f"{name} promises {length} numbers, but holds more or fewer")
                found.append(np.frombuffer(piece, dtype))
        else:
            raise DamagedError(f"cut short or damaged: a property of {name} has an unknown type")
        if place > end:
            raise DamagedError(f"cut short or damaged: a property of {name} ends beyond its node")
    return found
