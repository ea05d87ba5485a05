"""Inspection of .stl files: triangles with corners of their own, in binary or text."""

from __future__ import annotations

import codecs
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .contents import Contents, DamagedError, require_single_precision

HEADER_BYTES, TRIANGLE_BYTES = 84, 50

_CORNER = re.compile(rb"\bvertex\s+(\S+)\s+(\S+)\s+(\S+)")


def inspect_stl(path: Path) -> Contents:
    """Check triangles and coordinates; Blender joins corners, so no number is compared."""
    data, readable = path.read_bytes(), None
    promised = int.from_bytes(data[80:84], "little") if len(data) >= HEADER_BYTES else -1
    if len(data) == HEADER_BYTES + TRIANGLE_BYTES * promised:
        rows = np.frombuffer(data, np.uint8, offset=HEADER_BYTES).reshape(-1, TRIANGLE_BYTES)
        corners = np.ascontiguousarray(rows[:, 12:48]).view("<f4").reshape(-1, 3)
    elif (text := _lower_case(data)).startswith(b"solid") and b"\0" not in data:
        corners = _corners_of_text(text)
        # The importer knows words in lower case only.
        readable = None if text in data else text
    elif promised < 0:
        raise DamagedError(f"it has {len(data)} bytes, too few for a .stl file")
    else:
        there = (len(data) - HEADER_BYTES) // TRIANGLE_BYTES
        raise DamagedError(f"its header promises {promised} triangles, but {there} fit into it")
    require_single_precision(corners)
    return Contents(readable=readable)


def _lower_case(data: bytes) -> bytes:
    """Text of a file in lower case, without a byte order mark or white space in front."""
    return data.removeprefix(codecs.BOM_UTF8).lstrip().lower()


def _corners_of_text(data: bytes) -> NDArray[np.float64]:
    words = _CORNER.findall(data)
    n_facets, n_ends = len(re.findall(rb"\bfacet\s+normal\b", data)), data.count(b"endfacet")
    if not n_facets == n_ends == len(words) / 3:
        raise DamagedError(
            f"cut short or damaged: {n_facets} facets begin, {n_ends} end, with {len(words)} "
            "corners in all"
        )
    try:
        return np.array([[float(word) for word in corner] for corner in words]).reshape(-1, 3)
    except ValueError as error:
        raise DamagedError("a corner has text where a number should be") from error
