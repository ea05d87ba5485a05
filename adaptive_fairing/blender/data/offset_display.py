"""Results of `denoise` as offsets: in the coordinates of the mesh, or beside them by a modifier.

Changes of the mesh by hand stay. A vertex of a "LIVE" result counts as untouched if it lies on the
line from its original position to its position in the shape shown. Only untouched vertices are
moved.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import bmesh
import bpy
import numpy as np

from . import modifier
from .display_base import Display, ResultDisplay, is_behind
from .mesh_arrays import checksum, read_key, read_mesh_coordinates, write_positions
from .paint_group import paint_weights
from .stored_path import (
    ORIGINAL,
    StoredPath,
    has_offsets,
    read_path,
    read_vectors,
    write_path,
)

if TYPE_CHECKING:  # enabling the add-on does not load the core
    from numpy.typing import NDArray

    from ...core.runtime.arrays import SingleArray

N_STRENGTHS = 8
"""Largest number of strengths in a record: a vector property has a fixed size."""

ROUNDING = 2.0**-21
"""Distance from its line up to which a vertex is untouched, relative to the largest coordinate.

Four units in the last place: the original, the offset, their sum, and one refinement are rounded.
"""


_touched: dict[tuple[int, str, float], NDArray[np.bool_]] = {}  # of the object asked for last


class _OffsetDisplay(ResultDisplay):
    """Display of a result of `denoise`, which is offsets from the original."""

    slider = "strength"
    has_weights = True

    @property
    def _knots(self) -> tuple[float, ...]:
        record = self.obj.adaptive_fairing
        return tuple(record.strengths[: record.n_strengths])

    def _write_path(self, path: StoredPath, place: float, *, with_original: bool) -> None:
        write_path(self.obj.data, path, with_original=with_original)
        record = self.obj.adaptive_fairing
        record.result = self.name
        record.n_strengths = len(path.knots)
        record.strengths = [*path.knots, *[0.0] * (N_STRENGTHS - len(path.knots))]
        self.obj.data.adaptive_fairing.strength = place

    def _offset(self, original: SingleArray, place: float) -> SingleArray:
        """Offset (n, 3) at a place, by weights and split."""
        record = self.obj.adaptive_fairing
        offset = read_path(self.obj.data, original, self._knots).offset(place)
        weights = paint_weights(self.obj)
        if weights is not None:
            offset *= weights[:, None]
        if record.is_before or record.is_split:
            offset[is_behind(original, record)] = 0
        return offset

    def so_far(
        self, start: SingleArray, parts: list[float]
    ) -> tuple[SingleArray, list[SingleArray]]:
        original, place = self.original(), self.place
        return original, [self._offset(original, place * part) for part in parts]


class LiveDisplay(_OffsetDisplay):
    """The coordinates of the mesh itself."""

    name = "LIVE"

    @property
    def is_whole(self) -> bool:
        is_there = self.has_original and self._has_same_net
        # In Edit Mode coordinates cannot be read.
        return is_there and (self.obj.data.is_editmode or not self._touched().all())

    @property
    def has_original(self) -> bool:
        mesh = self.obj.data
        has_keys = mesh.shape_keys is not None  # of the user, which show another shape
        return ORIGINAL in mesh.attributes and not has_keys

    @property
    def has_strokes(self) -> bool:
        is_readable = self.has_original and not self.obj.data.is_editmode
        return is_readable and bool(self._touched().any())

    @property
    def goes_on(self) -> bool:
        return self.is_whole and not self.has_strokes

    @property
    def place(self) -> float:
        return self.obj.data.adaptive_fairing.strength

    @property
    def _has_same_net(self) -> bool:
        mesh = self.obj.data
        vertices = bmesh.from_edit_mesh(mesh).verts if mesh.is_editmode else mesh.vertices
        return mesh.adaptive_fairing.checksum.startswith(f"{len(vertices)}-")

    def _touched(self) -> NDArray[np.bool_]:
        """Whether each vertex was moved by hand, (n,); not in Edit Mode."""
        mesh = self.obj.data
        now = read_mesh_coordinates(mesh)
        if not has_offsets(mesh, self.obj.adaptive_fairing.n_strengths):
            return np.ones(len(now), dtype=bool)
        known, place = mesh.adaptive_fairing.checksum, self.place
        found = checksum(now)
        if found == known:
            return np.zeros(len(now), dtype=bool)
        key = self.obj.session_uid, found, place
        if key not in _touched:
            original = read_vectors(mesh, ORIGINAL)
            offset = read_path(mesh, original, self._knots).offset(place)
            _touched.clear()
            _touched[key] = _is_off_line(now - original, offset, np.abs(original).max(initial=0))
        return _touched[key]

    def write(self, path: StoredPath, place: float) -> None:
        self._write_path(path, place, with_original=True)
        original = read_vectors(self.obj.data, ORIGINAL)
        self._write_shown(original + self._offset(original, place))

    def show(self, place: float) -> None:
        mesh = self.obj.data
        touched = self._touched()
        original = read_vectors(mesh, ORIGINAL)
        shape = original + self._offset(original, place)
        shape[touched] = read_mesh_coordinates(mesh)[touched]
        self._write_shown(shape)
        mesh.adaptive_fairing.strength = place
        if touched.any():  # are found again by their places
            mesh.adaptive_fairing.checksum = f"{len(shape)}-"

    def note_written(self) -> None:
        mesh = self.obj.data
        mesh.adaptive_fairing.checksum = checksum(read_mesh_coordinates(mesh))

    def _write_shown(self, positions: SingleArray) -> None:
        write_positions(self.obj.data, positions)
        self.note_written()

    def original(self) -> SingleArray | None:
        if not self.has_original:
            return None
        original = read_vectors(self.obj.data, ORIGINAL)
        if not self._has_same_net:  # vertices that were not there before the run have no original
            touched = self._touched()
            original[touched] = read_mesh_coordinates(self.obj.data)[touched]
        return original

    def so_far(
        self, start: SingleArray, parts: list[float]
    ) -> tuple[SingleArray, list[SingleArray]]:
        original, moves = super().so_far(start, parts)
        touched = self._touched()
        original[touched] = start[touched]  # a stroke is part of what the next run begins with
        for move in moves:
            move[touched] = 0
        return original, moves

    def add_split(self, original: SingleArray) -> None:
        self.show(self.place)


class ModifierDisplay(_OffsetDisplay):
    """A modifier that adds the offset to a mesh which stays as it is."""

    name = "MODIFIER"

    @property
    def is_whole(self) -> bool:
        n_strengths = self.obj.adaptive_fairing.n_strengths
        return self.has_original and has_offsets(self.obj.data, n_strengths)

    @property
    def has_original(self) -> bool:
        return modifier.find(self.obj) is not None

    @property
    def place(self) -> float:
        return modifier.strength_of(self.obj)

    def write(self, path: StoredPath, place: float) -> None:
        has_keys = self.obj.data.shape_keys is not None
        self._write_path(path, place, with_original=not has_keys)
        if not has_keys:
            write_positions(self.obj.data, path.original)
        coordinates = read_mesh_coordinates(self.obj.data)
        self.obj.data.adaptive_fairing.checksum = checksum(coordinates)
        modifier.add(self.obj, path.knots, place)

    def show(self, place: float) -> None:
        modifier.set_strength(self.obj, place)
        self.obj.data.adaptive_fairing.strength = place

    def original(self) -> SingleArray | None:
        return read_mesh_coordinates(self.obj.data)

    def shown(self) -> SingleArray:
        shown = super().shown()
        if not self.is_whole:
            return shown
        return shown + self._offset(self.original(), self.place)

    def apply(self) -> None:
        mesh = self.obj.data
        if mesh.shape_keys is None:
            super().apply()
            return
        offset = self._offset(self.original(), self.place)
        self.clear()
        for block in mesh.shape_keys.key_blocks:  # all keys of the user move along
            block.points.foreach_set("co", np.ravel(read_key(block) + offset))
        mesh.update()

    def share(self, other: bpy.types.Object) -> None:
        super().share(other)
        modifier.add(other, self._knots, self.place)

    def add_split(self, original: SingleArray) -> None:
        super().add_split(Display.shown(self))

    def paint_group(self) -> bpy.types.VertexGroup:
        group = super().paint_group()
        modifier.set_group(self.obj, group.name)
        return group


def _is_off_line(moves: SingleArray, offsets: SingleArray, size: float) -> NDArray[np.bool_]:
    """Whether each move (n, 3) ends elsewhere than between the original and the offset (n, 3)."""
    lengths = np.maximum(np.einsum("id,id->i", offsets, offsets), np.finfo(np.float32).tiny)
    parts = np.clip(np.einsum("id,id->i", moves, offsets) / lengths, 0, 1)
    return np.abs(moves - parts[:, None] * offsets).max(axis=1) > ROUNDING * size
