"""The result of `denoise` on a mesh: the original, and the offset from it at each strength.

They are point attributes of the mesh, so they are saved, copied and undone with it. Two ways show
them:

- "LIVE": the coordinates of the mesh are original + weight · offset(strength). Every exporter
  writes what is seen.
- "MODIFIER": the coordinates of the mesh stay; a modifier adds the offset, see `modifier`.

The coordinates that were written are known by a checksum. Whoever moves, adds or removes vertices
makes the stored result stale: it is never written over that work.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from typing import TYPE_CHECKING

import bpy
import numpy as np

from . import modifier
from .attribute_arrays import remove_attributes
from .mesh_arrays import read_mesh_coordinates, write_positions
from .vertex_groups import group_weights

if TYPE_CHECKING:  # enabling the add-on does not load the core
    from ...core.runtime.arrays import SingleArray

ORIGINAL = ".fairing_original"
"""Vector point attribute: coordinates before the first run."""

PAINT_GROUP = "Fairing"
"""Vertex group of which the weights say how much of the result is seen: 1 all, 0 the original."""


def offset_name(index: int) -> str:
    """Name of the attribute with the offset at a strength, counted from 1."""
    return f".fairing_offset_{index}"


@dataclass(frozen=True)
class StoredResult:
    """A result of `denoise`.

    Attributes
    ----------
    original
        (n, 3) positions at strength 0.
    strengths
        (k,) ascending, above 0.
    offsets
        (n, 3) for each strength, from the original.
    """

    original: SingleArray
    strengths: tuple[float, ...]
    offsets: tuple[SingleArray, ...]

    def offset(self, strength: float) -> SingleArray:
        """Interpolate between the strengths; beyond the last the offset stays."""
        return interpolated(self.strengths, self.offsets.__getitem__, strength)


def interpolated(strengths, offset_at, strength: float) -> SingleArray:
    """Take the offset (n, 3) at a strength; `offset_at` gives those of the two neighbours only."""
    knots = (0.0, *strengths)
    place = float(np.interp(strength, knots, range(len(knots))))
    below = min(int(place), len(strengths) - 1)
    part = np.float32(place - below)
    high = offset_at(below)
    if below == 0:
        return part * high  # a new array, which callers may change
    low = offset_at(below - 1)
    return low + part * (high - low)


def write_stored(mesh: bpy.types.Mesh, stored: StoredResult, *, with_original: bool) -> None:
    """Keep a result on a mesh, in place of an earlier one.

    Parameters
    ----------
    mesh
        Mesh that is not in Edit Mode.
    stored
        What to keep.
    with_original
        Whether to keep the coordinates before the first run, too.
    """
    remove_stored(mesh)
    if with_original:
        write_vectors(mesh, ORIGINAL, stored.original)
    for index, offset in enumerate(stored.offsets, start=1):
        write_vectors(mesh, offset_name(index), offset)


def remove_stored(mesh: bpy.types.Mesh) -> None:
    """Remove the attributes of a result; the coordinates stay."""
    offsets = [name for name in mesh.attributes.keys() if name.startswith(offset_name(0)[:-1])]
    remove_attributes(mesh, [ORIGINAL, *offsets])


def read_stored(obj: bpy.types.Object) -> StoredResult | None:
    """Read the result of an object; None if there is none, or if it is stale."""
    if not is_current(obj):
        return None
    mesh, record = obj.data, obj.adaptive_fairing
    strengths = strengths_of(record)
    offsets = [read_vectors(mesh, offset_name(i)) for i in range(1, len(strengths) + 1)]
    return StoredResult(_original(obj), strengths, tuple(offsets))


def strengths_of(record: bpy.types.PropertyGroup) -> tuple[float, ...]:
    """Strengths of the stored offsets."""
    return tuple(record.strengths[: record.n_strengths])


def is_current(obj: bpy.types.Object) -> bool:
    """Whether an object has a stored result that fits the coordinates of its mesh."""
    record, mesh = obj.adaptive_fairing, obj.data
    if record.result not in ("LIVE", "MODIFIER") or obj.mode == "EDIT":
        return False
    names = [offset_name(index) for index in range(1, record.n_strengths + 1)]
    if record.result == "LIVE":
        names.append(ORIGINAL)
    elif modifier.find(obj) is None:
        return False
    if any(name not in mesh.attributes for name in names):
        return False
    return checksum(read_mesh_coordinates(mesh)) == record.checksum


def has_result(obj: bpy.types.Object) -> bool:
    """Whether an object has a result of which all is still there: its shape keys, or offsets."""
    if obj.adaptive_fairing.result == "KEYS":
        from .shape_keys import has_fairing_keys  # needs the core

        return has_fairing_keys(obj.data)
    return is_current(obj)


def checksum(positions: SingleArray) -> str:
    """Tell coordinates from any others; text, since properties hold no unsigned numbers."""
    return f"{len(positions)}-{zlib.crc32(np.ascontiguousarray(positions))}"


def shown_by(obj: bpy.types.Object) -> SingleArray:
    """Compute the shape that a stored result shows, (n, 3). It must be current."""
    mesh, record = obj.data, obj.adaptive_fairing
    offset = interpolated(
        strengths_of(record),
        lambda index: read_vectors(mesh, offset_name(index + 1)),
        record.strength,
    )
    original, weights = _original(obj), paint_weights(obj)
    if weights is not None:
        offset = weights[:, None] * offset
    if record.is_split:
        distance = (original - np.float32(record.split_point)) @ np.float32(record.split_normal)
        offset[distance < 0] = 0
    return original + offset


def update_shown(obj: bpy.types.Object) -> bool:
    """Bring the mesh of a "LIVE" result to the strength and the weights; False if it is stale."""
    if not is_current(obj):
        return False
    if obj.adaptive_fairing.result == "LIVE":
        write_shown(obj, shown_by(obj))
    return True


def write_shown(obj: bpy.types.Object, positions: SingleArray) -> None:
    """Write coordinates that belong to the stored result."""
    write_positions(obj.data, positions)
    obj.adaptive_fairing.checksum = checksum(read_mesh_coordinates(obj.data))


def paint_group(obj: bpy.types.Object) -> bpy.types.VertexGroup:
    """Give the vertex group `PAINT_GROUP` and let it count; a new one shows the whole result."""
    group = obj.vertex_groups.get(PAINT_GROUP)
    if group is None:
        group = obj.vertex_groups.new(name=PAINT_GROUP)
        group.add(range(len(obj.data.vertices)), 1.0, "REPLACE")
        forget_weights()
    obj.vertex_groups.active = group
    if obj.adaptive_fairing.result == "MODIFIER":
        modifier.set_group(obj, PAINT_GROUP)
    return group


def paint_weights(obj: bpy.types.Object) -> SingleArray | None:
    """Weights of the group `PAINT_GROUP`, (n,), 0 outside of it; None if there is no such group."""
    group = obj.vertex_groups.get(PAINT_GROUP)
    if group is None:
        return None
    key = obj.session_uid, len(obj.data.vertices)
    if key not in _weights:
        _weights.clear()
        _weights[key] = group_weights(obj, group)
    return _weights[key]


def forget_weights() -> None:
    """Have the weights read again: somebody may have painted."""
    _weights.clear()


_weights: dict[tuple[int, int], SingleArray] = {}  # of the object that was shown last


def _original(obj: bpy.types.Object) -> SingleArray:
    if obj.adaptive_fairing.result == "LIVE":
        return read_vectors(obj.data, ORIGINAL)
    return read_mesh_coordinates(obj.data)


def read_vectors(mesh: bpy.types.Mesh, name: str) -> SingleArray:
    """Read a vector attribute of the points, (n, 3)."""
    buffer = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.attributes[name].data.foreach_get("vector", buffer)
    return buffer.reshape(-1, 3)


def write_vectors(mesh: bpy.types.Mesh, name: str, vectors: SingleArray) -> None:
    """Write (n, 3) vectors as a new attribute of the points."""
    attribute = mesh.attributes.new(name, "FLOAT_VECTOR", "POINT")
    attribute.data.foreach_set("vector", np.ascontiguousarray(vectors, dtype=np.float32).ravel())
