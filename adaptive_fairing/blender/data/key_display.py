"""The steps of `fair` as shape keys."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .display_base import ResultDisplay
from .mesh_arrays import read_key, write_positions
from .shape_keys import (
    BASIS,
    has_step_keys,
    keys_checksum,
    remove_step_keys,
    show_step,
    shown_step,
    write_absolute_keys,
    write_relative_keys,
)
from .stored_path import ORIGINAL, StoredPath, read_vectors

if TYPE_CHECKING:  # enabling the add-on does not load the core
    from ...core.runtime.arrays import SingleArray


class KeysDisplay(ResultDisplay):
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
        return shown_step(self.obj.data.shape_keys)

    def write(self, path: StoredPath, place: float) -> None:
        shapes = [path.original + path.offset_at(index) for index in range(len(path.knots))]
        self._write_keys(self.obj, shapes, path.knots.index(place))
        self.obj.adaptive_fairing.result = self.name
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
            return read_vectors(mesh, ORIGINAL)
        return read_key(mesh.shape_keys.reference_key)

    def clear(self) -> None:
        super().clear()
        remove_step_keys(self.obj)  # where there are keys of the user, too

    def so_far(
        self, start: SingleArray, parts: list[float]
    ) -> tuple[SingleArray, list[SingleArray]]:
        original = self.original()
        move = start - original
        return original, [np.float32(min(part, 1.0)) * move for part in parts]


class RelativeKeysDisplay(KeysDisplay):
    """Relative shape keys, one a step: their own values mix them."""

    slider = ""
    _write_keys = staticmethod(write_relative_keys)

    @property
    def place(self) -> float:
        return 0.0

    def show(self, place: float) -> None:
        write_positions(self.obj.data, self.shown())
