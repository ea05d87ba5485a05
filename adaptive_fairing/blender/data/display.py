"""Displays of a result on an object: three kinds behind one interface.

A run leaves one of these on an object, named by `FairingRecord.result`:

- "LIVE": the coordinates of the mesh are original + weight · offset(strength). Every exporter
  writes what is seen.
- "MODIFIER": the coordinates of the mesh stay; a modifier adds the offset, see `modifier`.
- "KEYS": the steps of `fair` as shape keys, see `shape_keys`.
- "", nothing that can be changed any more.

No other module asks which kind it is: `display_of` returns that of an object.

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
from .display_base import Display, is_behind
from .mesh_arrays import checksum, read_key, read_mesh_coordinates, read_values, write_positions
from .shape_keys import (
    BASIS,
    has_step_keys,
    keys_checksum,
    last_step,
    remove_step_keys,
    show_step,
    shown_step,
    write_absolute_keys,
    write_relative_keys,
)
from .stored_path import ORIGINAL, StoredPath, has_offsets, read_path, write_path, write_vectors
from .vertex_groups import paint_weights

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


class _OffsetDisplay(Display):
    """Display of a result of `denoise`, which is offsets from the original."""

    slider = "strength"
    has_weights = True

    def continues(self, earlier: Display) -> bool:
        return earlier.is_whole

    def continued(
        self, earlier: Display, path: StoredPath, place: float, weights: NDArray | None
    ) -> StoredPath:
        """Add the offset of the earlier result at the same fraction of the strength shown."""
        parts = [1.0, *(each / place for each in path.knots)]
        original, (kept, *moves) = earlier.so_far(path.original, parts)
        if weights is None:
            return StoredPath(original, path.knots, lambda i: moves[i] + path.offset_at(i))
        inside = np.float32(weights)[:, None]
        moves = [kept + inside * (each - kept) for each in (np.zeros_like(kept), *moves)]
        return StoredPath(
            original,
            (0.0, *path.knots),
            lambda i: moves[i] + path.offset_at(i - 1) if i else moves[0],
        )

    @property
    def _knots(self) -> tuple[float, ...]:
        record = self.obj.adaptive_fairing
        return tuple(record.strengths[: record.n_strengths])

    def write(self, path: StoredPath, place: float) -> None:
        mesh, record = self.obj.data, self.obj.adaptive_fairing
        write_path(mesh, path, with_original=mesh.shape_keys is None)
        record.result = self.name
        record.n_strengths = len(path.knots)
        record.strengths = [*path.knots, *[0.0] * (N_STRENGTHS - len(path.knots))]
        mesh.adaptive_fairing.strength = place

    def note_written(self) -> None:
        mesh = self.obj.data
        mesh.adaptive_fairing.checksum = checksum(read_mesh_coordinates(mesh))

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
            original = read_values(mesh.attributes[ORIGINAL])
            offset = read_path(mesh, original, self._knots).offset(place)
            _touched.clear()
            _touched[key] = _is_off_line(now - original, offset, np.abs(original).max(initial=0))
        return _touched[key]

    def write(self, path: StoredPath, place: float) -> None:
        super().write(path, place)
        original = read_values(self.obj.data.attributes[ORIGINAL])
        write_positions(self.obj.data, original + self._offset(original, place))
        self.note_written()

    def show(self, place: float) -> None:
        mesh = self.obj.data
        touched = self._touched()
        original = read_values(mesh.attributes[ORIGINAL])
        shape = original + self._offset(original, place)
        shape[touched] = read_mesh_coordinates(mesh)[touched]
        write_positions(mesh, shape)
        mesh.adaptive_fairing.strength = place
        if touched.any():  # are found again by their places
            mesh.adaptive_fairing.checksum = f"{len(shape)}-"
        else:
            self.note_written()

    def original(self) -> SingleArray | None:
        if not self.has_original:
            return None
        original = read_values(self.obj.data.attributes[ORIGINAL])
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

    def compare(self) -> None:
        modifier.remove_split(self.obj)  # of a modifier that was applied by Blender
        if self.is_whole:
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
        super().write(path, place)
        if self.obj.data.shape_keys is None:
            write_positions(self.obj.data, path.original)
        self.note_written()
        modifier.add(self.obj, path.knots, place)

    def show(self, place: float) -> None:
        modifier.set_strength(self.obj, place)
        self.obj.data.adaptive_fairing.strength = place

    def original(self) -> SingleArray | None:
        return read_mesh_coordinates(self.obj.data)

    def shown(self) -> SingleArray:
        shown = self._behind
        return shown + self._offset(self.original(), self.place) if self.is_whole else shown

    @property
    def _behind(self) -> SingleArray:
        return super().shown()  # with the keys of the user

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

    def paint_group(self) -> bpy.types.VertexGroup:
        group = super().paint_group()
        modifier.set_group(self.obj, group.name)
        return group


class KeysDisplay(Display):
    """Absolute shape keys, one a step: `eval_time` moves through them."""

    name = "KEYS"
    slider = "evolution"
    _write_keys = staticmethod(write_absolute_keys)

    @property
    def is_whole(self) -> bool:
        return has_step_keys(self.obj.data)

    @property
    def has_original(self) -> bool:
        keys = self.obj.data.shape_keys
        return keys is not None and keys.reference_key.name == BASIS

    @property
    def has_strokes(self) -> bool:
        known = self.obj.data.adaptive_fairing.checksum
        return bool(known) and known != str(keys_checksum(self.obj.data.shape_keys))

    @property
    def place(self) -> float:
        return shown_step(self.obj.data.shape_keys) if self.is_whole else 0.0

    @property
    def unit(self) -> float:
        return last_step(self.obj.data.shape_keys) if self.is_whole else 1.0

    def continued(
        self, earlier: Display, path: StoredPath, place: float, weights: NDArray | None
    ) -> StoredPath:
        """Keep the original of the earlier result."""
        original = earlier.original()
        if np.array_equal(original, path.original):
            return path
        shapes = [path.original, *path.shapes]
        return StoredPath.through(original, (0.0, *path.knots), shapes)

    def write(self, path: StoredPath, place: float) -> None:
        mesh, has_basis_of_its_own = self.obj.data, path.knots[0] == 0
        start, *shapes = path.shapes if has_basis_of_its_own else [path.original, *path.shapes]
        write_positions(mesh, start)
        self._write_keys(self.obj, shapes, path.knots.index(place) - has_basis_of_its_own)
        self.obj.adaptive_fairing.result = self.name
        if has_basis_of_its_own:
            write_vectors(mesh, ORIGINAL, path.original)
        self.note_written()

    def note_written(self) -> None:
        mesh = self.obj.data
        mesh.adaptive_fairing.checksum = str(keys_checksum(mesh.shape_keys))

    def show(self, place: float) -> None:
        keys = self.obj.data.shape_keys
        show_step(keys, place)
        # Edit Mode shows the active key, and strokes in Sculpt Mode go to it: the nearest one.
        distances = [abs(block.frame - keys.eval_time) for block in keys.key_blocks]
        self.obj.active_shape_key_index = int(np.argmin(distances))

    def original(self) -> SingleArray | None:
        mesh = self.obj.data
        if not self.has_original:
            return None
        if ORIGINAL in mesh.attributes:
            return read_values(mesh.attributes[ORIGINAL])
        return read_key(mesh.shape_keys.reference_key)

    def clear(self) -> None:
        super().clear()
        remove_step_keys(self.obj)  # where there are keys of the user, too


class RelativeKeysDisplay(KeysDisplay):
    """Relative shape keys, one a step: their own values mix them."""

    slider = ""
    _write_keys = staticmethod(write_relative_keys)

    @property
    def place(self) -> float:
        return 0.0

    def show(self, place: float) -> None:
        write_positions(self.obj.data, self.shown())


_DISPLAYS = {
    **{each.name: each for each in (LiveDisplay, ModifierDisplay, KeysDisplay)},
    "ABSOLUTE_KEYS": KeysDisplay,
    "RELATIVE_KEYS": RelativeKeysDisplay,
    "FINAL_SHAPE": Display,
}


def display_of(obj: bpy.types.Object) -> Display:
    """Display of the result of a mesh object."""
    name, mesh = obj.adaptive_fairing.result, obj.data
    if obj.use_dynamic_topology_sculpting:  # the mesh that is shown cannot be written
        return Display(obj)
    if name == ModifierDisplay.name and modifier.find(obj) is None and ORIGINAL in mesh.attributes:
        return LiveDisplay(obj)  # Blender's own Apply has made it that
    if name == KeysDisplay.name and mesh.shape_keys is not None and mesh.shape_keys.use_relative:
        return RelativeKeysDisplay(obj)
    return _DISPLAYS.get(name, Display)(obj)


def new_display(obj: bpy.types.Object, way: str) -> Display:
    """Display for a new result, by the setting that chooses it, see `OutputProperties`."""
    return _DISPLAYS[way](obj)


def leaves_keys(way: str) -> bool:
    """Whether a result that is shown in this way leaves the mesh and its shape keys as they are."""
    return _DISPLAYS[way] is ModifierDisplay


def _is_off_line(moves: SingleArray, offsets: SingleArray, size: float) -> NDArray[np.bool_]:
    """Whether each move (n, 3) ends elsewhere than between the original and the offset (n, 3)."""
    lengths = np.maximum(np.einsum("id,id->i", offsets, offsets), np.finfo(np.float32).tiny)
    parts = np.clip(np.einsum("id,id->i", moves, offsets) / lengths, 0, 1)
    return np.abs(moves - parts[:, None] * offsets).max(axis=1) > ROUNDING * size
