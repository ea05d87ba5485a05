"""Inspection of .ply files: the header with elements and properties, then their rows."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .contents import (
    Contents,
    DamagedError,
    FarPoints,
    is_far,
    refuse_unknown_vertices,
    repeated,
    require_single_precision,
)

_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2",
    "ushort": "u2", "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
_BYTE_ORDERS = {"ascii": "=", "binary_little_endian": "<", "binary_big_endian": ">"}
_HEADER_END = re.compile(rb"^end_header[^\n]*\n?", re.MULTILINE)
_LONGEST_HEADER = 1 << 20
_LONGEST_COUNT = 18
_LONGEST_NUMBER = 64


class Property(NamedTuple):
    """A property of an element: one number in each row, or a list after its length."""

    name: str
    dtype: np.dtype[Any]
    length_dtype: np.dtype[Any] | None


@dataclass(frozen=True)
class Element:
    """A kind of rows that the header announces, and how many there are."""

    name: str
    count: int
    properties: list[Property]


@dataclass(frozen=True)
class Header:
    """Header of a file: the layout of the rows, and the number of bytes before them."""

    elements: list[Element]
    is_text: bool
    n_bytes: int


@dataclass(frozen=True)
class Rows:
    """Rows of an element.

    Attributes
    ----------
    columns
        (n,) values of each plain property.
    lists
        All values of each list property, one row after the other, and (n + 1,) the start of each
        row in them.
    starts
        (n + 1,) start of each row in the file, and the end of the last one.
    """

    columns: Mapping[str, NDArray[Any]]
    lists: Mapping[str, tuple[NDArray[Any], NDArray[np.int64]]]
    starts: NDArray[np.int64]


def inspect_ply(path: Path) -> Contents:
    """Check that all rows are there, check coordinates and faces, and count both."""
    data = path.read_bytes()
    header = read_header(data)
    rows = read_rows(data, header)
    vertex = rows.get("vertex")
    if vertex is None or not {"x", "y", "z"} <= vertex.columns.keys():
        raise DamagedError("its header names no vertices with x, y and z")
    points = np.column_stack([vertex.columns[axis] for axis in "xyz"])
    require_single_precision(points)
    corners, starts = _corners(rows)
    is_bad = (corners < 0) | (corners >= len(points))
    face_of = np.repeat(np.arange(len(starts) - 1), np.diff(starts))
    refuse_unknown_vertices(np.unique(face_of[is_bad]), len(points))
    again = repeated(corners, starts)
    return Contents(
        len(points),
        len(starts) - 1,
        # The importer would drop faces that repeat others in an order left to chance.
        readable=_without_faces(data, header, rows["face"].starts, again) if len(again) else None,
        far=FarPoints(points.astype(float), [np.arange(len(points))]) if is_far(points) else None,
    )


def _without_faces(
    data: bytes, header: Header, starts: NDArray[np.int64], faces: NDArray[np.int64]
) -> bytes:
    """Copy of a .ply file without the faces of these indices (k,), otherwise byte for byte."""
    kept = np.ones(len(starts) - 1, dtype=bool)
    kept[faces] = False
    lines = [
        b"element face %d\n" % kept.sum() if line.split()[:2] == [b"element", b"face"] else line
        for line in data[: header.n_bytes].splitlines(keepends=True)
    ]
    # Runs of faces that are kept are copied in one piece.
    edges = np.flatnonzero(np.diff(kept, prepend=False, append=False)).reshape(-1, 2)
    pieces = [data[starts[first] : starts[last]] for first, last in edges]
    return b"".join([*lines, data[header.n_bytes : starts[0]], *pieces, data[starts[-1] :]])


def read_header(data: bytes) -> Header:
    """Read the header.

    Raises
    ------
    DamagedError
        The header is missing or malformed.
    """
    end = _HEADER_END.search(data, 0, _LONGEST_HEADER)
    if data[:3] != b"ply" or end is None:
        raise DamagedError("it does not begin with the header of a .ply file")
    elements: list[Element] = []
    byte_order = ""
    # Bytes are split at ends of lines only, text also at characters that a comment may have.
    for line in (each.decode("latin-1") for each in data[: end.start()].splitlines()[1:]):
        words = line.split()
        try:
            match words:
                case [] | ["comment" | "obj_info", *_]:
                    pass
                case ["format", name, _]:
                    byte_order = _BYTE_ORDERS[name]
                case ["element", name, count] if count.isdecimal() and len(count) <= _LONGEST_COUNT:
                    elements.append(Element(name, int(count), []))
                case ["property", "list", length, kind, name]:
                    dtypes = [np.dtype(byte_order + _TYPES[each]) for each in (kind, length)]
                    elements[-1].properties.append(Property(name, *dtypes))
                case ["property", kind, name]:
                    dtype = np.dtype(byte_order + _TYPES[kind])
                    elements[-1].properties.append(Property(name, dtype, None))
                case _:
                    raise DamagedError(f"its header has a line that makes no sense: {line[:60]!r}")
        except (KeyError, IndexError) as error:
            raise DamagedError(
                f"its header has a line that makes no sense: {line[:60]!r}"
            ) from error
    if not byte_order:
        raise DamagedError("its header does not name the format")
    for element in elements:
        if element.count and not element.properties:
            raise DamagedError(
                f"its header promises {element.count} rows of {element.name!r} without properties"
            )
    return Header(elements, byte_order == "=", end.end())


def read_rows(data: bytes, header: Header) -> dict[str, Rows]:
    """Read the rows of all elements.

    Raises
    ------
    DamagedError
        Rows that the header announces are missing, or a row is malformed.
    """
    found, place = {}, header.n_bytes
    read = _read_text if header.is_text else _read_binary
    for element in header.elements:
        found[element.name] = read(data, place, element)
        place = int(found[element.name].starts[-1])
    return found


def _corners(rows: Mapping[str, Rows]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Vertices of all faces, and the start of each face in them."""
    face = rows.get("face")
    if face is not None:
        for name in ("vertex_indices", "vertex_index"):
            if name in face.lists:
                corners, starts = face.lists[name]
                return corners.astype(np.int64), starts
    return np.empty(0, dtype=np.int64), np.zeros(1, dtype=np.int64)


def _cut_short(element: Element, n_rows: int) -> DamagedError:
    return DamagedError(
        f"cut short: its header promises {element.count} rows of {element.name!r}, {n_rows} of "
        "them are there"
    )


def _read_binary(data: bytes, place: int, element: Element) -> Rows:
    room = len(data) - place
    smallest = sum((each.length_dtype or each.dtype).itemsize for each in element.properties)
    if element.count * smallest > room:
        raise _cut_short(element, room // smallest)
    # Usually all lists are as long as the first ones. Then the rows are one array.
    fixed = _row_dtype(data, place, element.properties)
    if fixed is not None and element.count * fixed.itemsize <= room:
        table = np.frombuffer(data, fixed, element.count, place)
        lengths = {
            each.name: table[f"length of {each.name}"]
            for each in element.properties
            if each.length_dtype is not None
        }
        if all((each == each[:1]).all() for each in lengths.values()):
            return _rows_of_table(table, element, place)
    return _walk_binary(data, place, element)


def _row_dtype(data: bytes, place: int, properties: Sequence[Property]) -> np.dtype[Any] | None:
    """Layout of a row with lists as long as in the row at this offset; None if that is cut off."""
    fields: list[tuple[Any, ...]] = []
    for each in properties:
        if each.length_dtype is None:
            fields.append((each.name, each.dtype))
            place += each.dtype.itemsize
            continue
        piece = data[place : place + each.length_dtype.itemsize]
        if len(piece) < each.length_dtype.itemsize:
            return None
        length = int(np.frombuffer(piece, each.length_dtype)[0])
        place += len(piece) + max(length, 0) * each.dtype.itemsize
        if length < 0 or place > len(data):
            return None
        fields += [(f"length of {each.name}", each.length_dtype), (each.name, each.dtype, length)]
    try:
        return np.dtype(fields)
    except ValueError as error:
        raise DamagedError("its header names a property twice") from error


def _rows_of_table(table: NDArray[Any], element: Element, place: int) -> Rows:
    columns, lists = {}, {}
    for each in element.properties:
        if each.length_dtype is None:
            columns[each.name] = table[each.name]
        else:
            values = table[each.name].reshape(len(table), -1)
            starts = np.arange(len(table) + 1) * values.shape[1]
            lists[each.name] = values.reshape(-1), starts
    return Rows(columns, lists, place + np.arange(len(table) + 1) * table.dtype.itemsize)


def _walk_binary(data: bytes, place: int, element: Element) -> Rows:
    """Read rows of different lengths one by one."""
    places: dict[str, list[int]] = {each.name: [] for each in element.properties}
    lengths: dict[str, list[int]] = {each.name: [] for each in element.properties}
    starts = [place]
    for row in range(element.count):
        for each in element.properties:
            length = 1
            if each.length_dtype is not None:
                width = each.length_dtype.itemsize
                order: Literal["big", "little"] = (
                    "big" if each.length_dtype.byteorder == ">" else "little"
                )
                signed = each.length_dtype.kind == "i"
                length = int.from_bytes(data[place : place + width], order, signed=signed)
                place += width
            places[each.name].append(place)
            lengths[each.name].append(length)
            place += length * each.dtype.itemsize
            if length < 0 or place > len(data):
                raise _cut_short(element, row)
        starts.append(place)
    columns, lists = {}, {}
    for each in element.properties:
        ends = np.concatenate([[0], np.cumsum(lengths[each.name])]).astype(np.int64)
        # Offsets of the bytes of all values: those of a row follow its own without gaps.
        width = each.dtype.itemsize
        shift = np.array(places[each.name], dtype=np.int64) - width * ends[:-1]
        index = np.arange(width * ends[-1]) + np.repeat(shift, width * np.diff(ends))
        values = np.frombuffer(data, np.uint8)[index].view(each.dtype)
        if each.length_dtype is None:
            columns[each.name] = values
        else:
            lists[each.name] = values, ends
    return Rows(columns, lists, np.array(starts))


def _read_text(data: bytes, place: int, element: Element) -> Rows:
    ends = place + 1 + np.flatnonzero(np.frombuffer(data, np.uint8, offset=place) == ord("\n"))
    if len(data) > place and (len(ends) == 0 or ends[-1] < len(data)):
        ends = np.append(ends, len(data))
    if len(ends) < element.count:
        raise _cut_short(element, len(ends))
    starts = np.concatenate([[place], ends[: element.count]]).astype(np.int64)
    lines = data[place : starts[-1]].split(b"\n")[: element.count]
    columns: dict[str, NDArray[Any]] = {}
    lists: dict[str, tuple[NDArray[Any], NDArray[np.int64]]] = {}
    words = b"\n".join(lines).split()
    table = _numbers(words, element)
    sizes = np.array([len(line.split()) for line in lines], dtype=np.int64)
    at = np.cumsum(sizes) - sizes
    row_ends = at + sizes
    for each in element.properties:
        if (at >= row_ends).any():
            raise _cut_short(element, int(np.argmax(at >= row_ends)))
        if each.length_dtype is None:
            columns[each.name] = table[at]
            at = at + 1
            continue
        lengths = table[at]
        is_bad = ~((lengths >= 0) & (at + 1 + lengths <= row_ends))
        if is_bad.any():
            raise _cut_short(element, int(np.argmax(is_bad)))
        lengths = lengths.astype(np.int64)
        ends_of = np.concatenate([[0], np.cumsum(lengths)])
        index = np.arange(ends_of[-1]) + np.repeat(at + 1 - ends_of[:-1], lengths)
        lists[each.name] = table[index], ends_of
        _require_whole_numbers(words, at, element)
        if each.dtype.kind in "iu":
            _require_whole_numbers(words, index, element)
        at = at + 1 + lengths
    return Rows(columns, lists, starts)


def _require_whole_numbers(
    words: Sequence[bytes], index: NDArray[np.int64], element: Element
) -> None:
    """Refuse whole numbers written as 1e1 or 10.0: the importer would read a 1, or nothing."""
    chosen = [words[at] for at in index.tolist()]
    if b"".join(chosen).translate(None, b"+-0123456789"):
        bad = next(word for word in chosen if not word.lstrip(b"+-").isdigit())
        raise DamagedError(
            f"a row of {element.name!r} has {bad.decode('latin-1')!r} where a whole number should "
            "be"
        )


def _numbers(words: Sequence[bytes], element: Element) -> NDArray[np.float64]:
    if max(map(len, words), default=0) > _LONGEST_NUMBER:
        raise DamagedError(f"a row of {element.name!r} has text where a number should be")
    try:
        return np.array(words, dtype=np.bytes_).astype(np.float64)
    except ValueError as error:
        raise DamagedError(
            f"a row of {element.name!r} has text where a number should be"
        ) from error
