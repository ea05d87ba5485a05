"""Coordinates of .ply files in double precision, for meshes far from the origin."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...files.inspection.ply import read_header

_AXES = ("x", "y", "z")


def write_doubles(path: Path, points: NDArray[np.float64]) -> None:
    """Replace the coordinates of a binary .ply file from Blender's exporter.

    Parameters
    ----------
    path
        Little-endian file whose first element is the vertices, without list properties.
    points
        (n, 3) coordinates of the vertices.
    """
    data = path.read_bytes()
    header = read_header(data)
    properties = header.elements[0].properties
    old = np.dtype([(each.name, each.dtype) for each in properties])
    new = np.dtype(
        [(each.name, "<f8" if each.name in _AXES else each.dtype) for each in properties]
    )
    rows = np.frombuffer(data, old, len(points), header.n_bytes).astype(new)
    for axis, values in zip(_AXES, points.T, strict=True):
        rows[axis] = values
    text = data[: header.n_bytes]
    for axis in _AXES:
        text = text.replace(
            f"property float {axis}\n".encode(), f"property double {axis}\n".encode()
        )
    path.write_bytes(text + rows.tobytes() + data[header.n_bytes + len(points) * old.itemsize :])
