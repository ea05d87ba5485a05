"""Full precision for .obj files: Blender's exporter rounds coordinates to six decimals.

In metres that is 1 % of an edge of 0.05 mm, and erases a mesh of size 1e-7. Here the coordinates of
an exported file are replaced by numbers that read back as exactly the same float32, or as the
doubles that a mesh far from the origin needs.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray

from ...files.inspection.contents import is_far
from .far_meshes import world_points

# From Blender's axes to the exporter's default: forward -Z, up Y.
_Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


def restore_precision(path: Path, *, keep_axes: bool) -> None:
    """Rewrite the coordinates in an .obj file that was exported from the current scene.

    An object whose number of vertices in the file is not that of its mesh keeps the exporter's
    numbers.

    Parameters
    ----------
    path
        File written by Blender's exporter.
    keep_axes
        Whether it was exported with Blender's own axes, instead of "Y up".
    """
    axes = np.eye(3) if keep_axes else _Y_UP
    exact = {
        # The exporter writes names without spaces.
        obj.name.replace(" ", "_"): world_points(obj) @ axes.T
        for obj in bpy.context.scene.objects
        if obj.type == "MESH"
    }
    lines = path.read_bytes().splitlines(keepends=True)
    for name, at in _vertex_lines(lines).items():
        points = exact.get(name)
        if points is not None and len(points) == len(at):
            _replace(lines, at, points)
    with path.open("wb") as file:
        file.writelines(lines)


def _vertex_lines(lines: list[bytes]) -> Mapping[str, list[int]]:
    """Find the vertex lines of every object in the file, by index."""
    found: dict[str, list[int]] = {}
    current: list[int] = []
    for number, line in enumerate(lines):
        if line.startswith(b"v "):
            current.append(number)
        elif line.startswith(b"o "):
            current = found.setdefault(line[2:].decode("utf-8").strip(), [])
    return found


def _replace(lines: list[bytes], at: list[int], points: NDArray[np.float64]) -> None:
    # Nine digits identify a float32; a double has as many as it needs.
    form = "v {!r} {!r} {!r}" if is_far(points) else "v {:.9g} {:.9g} {:.9g}"
    given = points if is_far(points) else points.astype(np.float32)
    for number, point in zip(at, given.tolist(), strict=True):
        # What follows the coordinates is a colour.
        color = b"".join(b" " + item for item in lines[number].split()[4:])
        lines[number] = form.format(*point).encode() + color + b"\n"
