"""The path of a result: from the original through the shape at each knot, straight in between.

The knots are the strengths of `denoise`, or the step numbers of `fair`. A result without shape keys
keeps its path in point attributes of the mesh, so it is saved, copied and undone with the mesh.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import bpy
import numpy as np

from .mesh_arrays import AttributeArray, read_values, write_attribute

if TYPE_CHECKING:  # enabling the add-on does not load the core
    from numpy.typing import NDArray

    from ...core.runtime.arrays import SingleArray

ORIGINAL = ".fairing_original"
"""Vector point attribute: coordinates before the first run."""


def offset_name(index: int) -> str:
    """Name of the attribute with the offset at a knot, counted from 1."""
    return f".fairing_offset_{index}"


@dataclass(frozen=True)
class StoredPath:
    """Original shape and offsets of a result.

    Attributes
    ----------
    original
        (n, 3) positions at 0.
    knots
        (k,) ascending, above 0. The first may be 0: there the path jumps from the original to the
        shape that earlier runs gave.
    offset_at
        Returns the offset (n, 3) from the original at a knot, by its index from 0.
    """

    original: SingleArray
    knots: tuple[float, ...]
    offset_at: Callable[[int], NDArray[np.floating]]

    @classmethod
    def through(cls, original: SingleArray, knots: Sequence[float], shapes: Sequence) -> StoredPath:
        """Make the path through shapes (n, 3), whose offsets are exact."""
        start = original.astype(np.float64)
        return cls(original, tuple(knots), lambda index: shapes[index] - start)

    @property
    def shapes(self) -> list[NDArray[np.floating]]:
        """Shape (n, 3) at each knot."""
        return [self.original + self.offset_at(index) for index in range(len(self.knots))]

    def offset(self, place: float) -> NDArray[np.floating]:
        """Interpolate the offset between the knots, constant beyond the last; a new array."""
        ends = (0.0, *self.knots)
        number = float(np.interp(place, ends, range(len(ends))))
        below = min(int(number), len(self.knots) - 1)
        part = np.float32(number - below)
        high = self.offset_at(below)
        if below == 0:
            return part * high
        low = self.offset_at(below - 1)
        return low + part * (high - low)


def write_path(mesh: bpy.types.Mesh, path: StoredPath, *, with_original: bool = True) -> None:
    """Store a path on a mesh without one, not in Edit Mode."""
    if with_original:
        write_vectors(mesh, ORIGINAL, path.original)
    for index in range(len(path.knots)):
        write_vectors(mesh, offset_name(index + 1), path.offset_at(index))


def read_path(mesh: bpy.types.Mesh, original: SingleArray, knots: tuple[float, ...]) -> StoredPath:
    """Read the path of a mesh; offsets are read when they are needed."""
    return StoredPath(
        original, knots, lambda index: read_values(mesh.attributes[offset_name(index + 1)])
    )


def has_offsets(mesh: bpy.types.Mesh, n_knots: int) -> bool:
    """Whether a mesh has an offset for every knot, and at least one."""
    names = [offset_name(index) for index in range(1, n_knots + 1)]
    return bool(names) and all(name in mesh.attributes for name in names)


def stored_names(mesh: bpy.types.Mesh) -> list[str]:
    """Names of the attributes of a path, whole or not, on a mesh."""
    starts = (ORIGINAL, offset_name(0)[:-1])
    return [name for name in mesh.attributes.keys() if name.startswith(starts)]


def write_vectors(mesh: bpy.types.Mesh, name: str, vectors: NDArray[np.floating]) -> None:
    """Write (n, 3) vectors as an attribute of the points."""
    write_attribute(mesh, AttributeArray(name, "FLOAT_VECTOR", "POINT", vectors))
