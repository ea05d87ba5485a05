"""Inspection of .gltf and .glb files: JSON that describes pieces of binary buffers."""

from __future__ import annotations

import base64
import json
import struct
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from ...core.errors import listed
from .contents import Contents, DamagedError, require_single_precision

Json = dict[str, Any]

_COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_JSON_CHUNK, _BINARY_CHUNK = 0x4E4F534A, 0x004E4942


def inspect_gltf(path: Path) -> Contents:
    """Check that all buffers are complete, and check coordinates and faces.

    Blender joins and splits vertices of such files, so their number is not compared.
    """
    try:
        n_points = _check(path)
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, RecursionError) as error:
        raise DamagedError(f"its structure is damaged ({type(error).__name__}: {error})") from error
    return Contents(n_points=n_points)


def _check(path: Path) -> int:
    """Check everything, and count the positions of all meshes."""
    data = path.read_bytes()
    text, binary = _chunks(data) if data[:4] == b"glTF" else (data, None)
    scene: Json = json.loads(text.decode("utf-8"))
    buffers = [_buffer(each, path, binary) for each in scene.get("buffers", [])]
    views = scene.get("bufferViews", [])
    for number, view in enumerate(views):
        start, length = _natural(view.get("byteOffset", 0)), _natural(view["byteLength"])
        if start + length > len(buffers[_natural(view["buffer"])]):
            raise DamagedError(f"cut short: its buffer view {number} ends beyond the buffer")
    accessors = scene.get("accessors", [])
    n_bytes = sum(map(len, buffers))
    for number, accessor in enumerate(accessors):
        _check_accessor(number, accessor, views, n_bytes)
    positions = set()
    for mesh in scene.get("meshes", []):
        for primitive in mesh["primitives"]:
            if "KHR_draco_mesh_compression" not in primitive.get("extensions", {}):
                _check_primitive(primitive, accessors, views, buffers)
            positions.add(_natural(primitive["attributes"]["POSITION"]))
    return sum(_natural(accessors[number]["count"]) for number in positions)


def _chunks(data: bytes) -> tuple[bytes, bytes | None]:
    """Split a .glb file into its JSON and its binary buffer."""
    length = struct.unpack_from("<I", data, 8)[0] if len(data) >= 20 else -1
    if length > len(data) or length < 0:
        raise DamagedError(f"cut short: its header promises {length} bytes, it has {len(data)}")
    found: dict[int, bytes] = {}
    place = 12
    while place + 8 <= length:
        size, kind = struct.unpack_from("<II", data, place)
        place += 8
        if place + size > length:
            raise DamagedError("cut short: a chunk ends beyond the file")
        found.setdefault(kind, data[place : place + size])
        place += size
    return found[_JSON_CHUNK], found.get(_BINARY_CHUNK)


def _buffer(described: Json, path: Path, binary: bytes | None) -> bytes:
    uri, length = described.get("uri"), _natural(described["byteLength"])
    if uri is None:
        data = binary or b""
    elif uri.startswith("data:"):
        data = base64.b64decode(uri.partition(",")[2])
    else:
        file = path.parent / unquote(uri)
        if not file.is_file():
            raise DamagedError(f"its file {unquote(uri)} is missing")
        data = file.read_bytes()
    if len(data) < length:
        raise DamagedError(
            f"cut short: it promises a buffer of {length} bytes, {len(data)} are there"
        )
    return data


def _check_accessor(number: int, accessor: Json, views: list[Json], n_bytes: int) -> None:
    count, dtype, width = _layout(accessor)
    size = dtype.itemsize * width
    for part in _sparse_parts(accessor):
        _check_accessor(number, part, views, n_bytes)
    if "bufferView" not in accessor:
        # The standard reads such values as zeros. Compressed ones are stored elsewhere.
        if "sparse" in accessor and count > n_bytes:
            raise DamagedError(
                f"cut short: its accessor {number} promises {count} elements, its buffers have "
                f"{n_bytes} bytes"
            )
        return
    view = views[_natural(accessor["bufferView"])]
    stride = _natural(view.get("byteStride", 0)) or size
    start = _natural(accessor.get("byteOffset", 0))
    if count and start + stride * (count - 1) + size > view["byteLength"]:
        raise DamagedError(
            f"cut short: its accessor {number} promises {count} elements, its buffer view has room "
            f"for {max((view['byteLength'] - start) // stride, 0)}"
        )


def _check_primitive(
    primitive: Json, accessors: list[Json], views: list[Json], buffers: list[bytes]
) -> None:
    position = accessors[_natural(primitive["attributes"]["POSITION"])]
    if "bufferView" not in position and "sparse" not in position:
        raise DamagedError("a mesh has no coordinates")
    points = _read(position, views, buffers)
    require_single_precision(points)
    if "indices" in primitive:
        corners = _read(accessors[_natural(primitive["indices"])], views, buffers).reshape(-1)
        bad = np.flatnonzero(corners >= len(points))
        if len(bad):
            raise DamagedError(
                f"{len(bad)} corners of faces name vertices that are not there: {listed(bad)}; "
                f"the mesh has {len(points)} vertices"
            )


def _read(accessor: Json, views: list[Json], buffers: list[bytes]) -> NDArray[Any]:
    """Numbers of an accessor (count, width), whose bytes were checked to be there."""
    values = _read_view(accessor, views, buffers)
    parts = _sparse_parts(accessor)
    if parts:
        places, changed = (_read_view(part, views, buffers) for part in parts)
        bad = np.flatnonzero(places >= len(values))
        if len(bad):
            raise DamagedError(
                f"a sparse accessor replaces {len(bad)} values that do not exist: {listed(bad)}"
            )
        values = values.copy()
        values[places.reshape(-1)] = changed
    return values


def _sparse_parts(accessor: Json) -> list[Json]:
    """Describe the indices and the values of a sparse accessor as plain accessors."""
    if "sparse" not in accessor:
        return []
    sparse, values = accessor["sparse"], {"componentType": accessor["componentType"]}
    return [
        {"type": "SCALAR", **sparse["indices"], "count": sparse["count"]},
        {"type": accessor["type"], **values, **sparse["values"], "count": sparse["count"]},
    ]


def _read_view(accessor: Json, views: list[Json], buffers: list[bytes]) -> NDArray[Any]:
    count, dtype, width = _layout(accessor)
    if "bufferView" not in accessor:
        return np.zeros((count if "sparse" in accessor else 0, width), dtype=dtype)
    view = views[accessor["bufferView"]]
    start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    stride = view.get("byteStride", 0) or dtype.itemsize * width
    steps = (stride, dtype.itemsize)
    return np.ndarray((count, width), dtype, buffers[view["buffer"]], start, steps)


def _layout(accessor: Json) -> tuple[int, np.dtype[Any], int]:
    kind = np.dtype(_COMPONENTS[accessor["componentType"]])
    return _natural(accessor["count"]), kind, _WIDTHS[accessor["type"]]


def _natural(value: Any) -> int:
    if type(value) is not int or value < 0:
        raise ValueError(f"{value!r} where a number of 0 or more should be")
    return value
