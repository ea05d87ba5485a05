"""Crates, which are binary .usd files: the values of their attributes.

A crate has sections: texts ("tokens"), fields (a name and the place of its value), sets of fields,
paths, and specs, which assign a set of fields to a path. All their numbers are packed.

Source: the public description of the format in OpenUSD, pxr/usd/usd/crateFile.h.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

MAGIC = b"PXR-USDC"

_FIRST_PACKED, _FIRST_WITHOUT_RANK, _FIRST_WIDE = (0, 4), (0, 5), (0, 7)
"""Versions from which on sections are packed, arrays have no rank, their sizes have eight bytes."""

_IS_ARRAY, _IS_INLINED, _IS_PACKED = 1 << 63, 1 << 62, 1 << 61
_SMALLEST_PACKED = 16
"""Shorter arrays are not packed."""

_INT = 3
"""The type of whole numbers of four bytes."""

_LEAF, _CHILD = -2, -1
"""Jumps in paths: nothing follows, or a child; 0 means a sibling, other numbers lead to it."""


class Attribute(NamedTuple):
    """An attribute: its prim, its name, and the place of its value."""

    prim: str
    name: str
    value: int


class Crate:
    """A crate whose sections have been read; a damaged one raises errors of numpy and struct.

    Raises
    ------
    NotImplementedError
        The version of the format is not known here.
    """

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._version = tuple(data[8:10])
        if not _FIRST_PACKED <= self._version < (1, 0):
            raise NotImplementedError(f"version {self._version}")
        (place,) = struct.unpack_from("<q", data, 16)
        (count,) = struct.unpack_from("<Q", data, place)
        sections = [struct.unpack_from("<16sqq", data, place + 8 + 32 * i) for i in range(count)]
        self._sections = {name.rstrip(b"\0"): start for name, start, _ in sections}

    def attributes(self) -> Iterator[Attribute]:
        """All attributes with a value that is not animated."""
        tokens, paths, fields, sets = self._tokens(), self._paths(), self._fields(), self._sets()
        names = [tokens[token] for token, _ in fields]
        section = _Section(self._data, self._sections[b"SPECS"])
        count = section.number()
        places, first_fields = section.integers(count), section.integers(count)
        for place, first in zip(places.tolist(), first_fields.tolist(), strict=True):
            prim, token = paths.get(place, ("", 0))
            if token < 0:
                for at in _group(sets, first):
                    if names[at] == "default":
                        yield Attribute(prim, tokens[-token], fields[at][1])

    def integers(self, value: int) -> NDArray[np.int64]:
        """Read an array of whole numbers."""
        if not value & _IS_ARRAY or value >> 48 & 0xFF != _INT:
            raise ValueError("a value that is not an array of whole numbers")
        count, place = self._array(value)
        if value & _IS_PACKED and count >= _SMALLEST_PACKED:
            return _Section(self._data, place).integers(count)
        return np.frombuffer(self._data, "<i4", count, place).astype(np.int64)

    def length(self, value: int) -> int:
        """Count the elements of an array."""
        return self._array(value)[0]

    def _array(self, value: int) -> tuple[int, int]:
        """Count the elements of an array, and return the offset of the first too."""
        place = value & (1 << 48) - 1
        if place == 0:
            return 0, 0
        if self._version < _FIRST_WITHOUT_RANK:
            place += 4
        form = "<I" if self._version < _FIRST_WIDE else "<Q"
        return struct.unpack_from(form, self._data, place)[0], place + struct.calcsize(form)

    def _tokens(self) -> list[str]:
        section = _Section(self._data, self._sections[b"TOKENS"])
        count, _ = section.number(), section.number()
        return section.unpacked().decode("utf-8", "replace").split("\0")[:count]

    def _fields(self) -> list[tuple[int, int]]:
        """Token and value of every field."""
        section = _Section(self._data, self._sections[b"FIELDS"])
        tokens = section.integers(section.number())
        values = np.frombuffer(section.unpacked(), "<u8")
        return list(zip(tokens.tolist(), values.tolist(), strict=True))

    def _sets(self) -> list[int]:
        """Fields of all sets, one set after the other, -1 after each."""
        section = _Section(self._data, self._sections[b"FIELDSETS"])
        return section.integers(section.number()).tolist()

    def _paths(self) -> dict[int, tuple[str, int]]:
        """Parent and token of every path by its index; the token of a property is negative."""
        section = _Section(self._data, self._sections[b"PATHS"])
        section.number()
        count = section.number()
        numbers, elements, jumps = (section.integers(count).tolist() for _ in range(3))
        tokens, found = self._tokens(), {}
        waiting, is_new = [(0, "")], [True] * count
        while waiting:
            at, parent = waiting.pop()
            while at < count and is_new[at]:
                is_new[at] = False
                found[numbers[at]] = parent, elements[at]
                jump = jumps[at]
                if jump > 0:
                    waiting.append((at + jump, parent))
                if jump == _LEAF:
                    break
                if jump != 0:
                    name = tokens[abs(elements[at])] if parent else ""
                    parent = f"{parent.rstrip('/')}/{name}"
                at += 1
        return found


class _Section:
    """Packed numbers of a crate, one after the other."""

    def __init__(self, data: bytes, place: int) -> None:
        self._data, self._place = data, place

    def number(self) -> int:
        (number,) = struct.unpack_from("<Q", self._data, self._place)
        self._place += 8
        return int(number)

    def unpacked(self) -> bytes:
        """Read a block of bytes that begins with its packed size."""
        size = self.number()
        piece = self._data[self._place : self._place + size]
        self._place += size
        if len(piece) < size or piece[:1] != b"\0":
            raise ValueError("a piece that is cut short, or several pieces")
        return _unpacked(piece[1:])

    def integers(self, count: int) -> NDArray[np.int64]:
        """Read whole numbers stored as differences; the most common difference takes no room."""
        data = self.unpacked()
        codes = np.frombuffer(data, np.uint8, (2 * count + 7) // 8, 4)
        code = (codes[:, None] >> np.array([0, 2, 4, 6], dtype=np.uint8) & 3).reshape(-1)[:count]
        width = np.array([0, 1, 2, 4])[code]
        place = 4 + len(codes) + np.cumsum(width) - width
        difference = np.full(count, struct.unpack_from("<i", data)[0], dtype=np.int64)
        raw = np.frombuffer(data, np.uint8)
        for kind, size in ((1, 1), (2, 2), (3, 4)):
            chosen = code == kind
            rows = np.ascontiguousarray(raw[place[chosen, None] + np.arange(size)])
            difference[chosen] = rows.view(f"<i{size}").reshape(-1)
        return np.cumsum(difference).astype(np.int32).astype(np.int64)


def _group(sets: list[int], first: int) -> list[int]:
    return sets[first : sets.index(-1, first)]


def _unpacked(data: bytes) -> bytes:
    """Unpack a block of LZ4: pieces of text, each followed by a copy of earlier output."""
    found, place = bytearray(), 0
    while place < len(data):
        mark = data[place]
        length, place = _length(data, place + 1, mark >> 4)
        found += data[place : place + length]
        place += length
        if place >= len(data):
            break
        back = data[place] | data[place + 1] << 8
        length, place = _length(data, place + 2, mark & 15)
        start = len(found) - back
        if start < 0 or back == 0:
            raise ValueError("a copy from before the beginning")
        piece = found[start : start + length + 4]
        found += (piece * (length // back + 5))[: length + 4] if back < length + 4 else piece
    return bytes(found)


def _length(data: bytes, place: int, length: int) -> tuple[int, int]:
    """Read a length, which continues in further bytes if it is 15, and the offset behind it."""
    if length == 15:
        while True:
            length += data[place]
            place += 1
            if data[place - 1] != 255:
                break
    return length, place
