"""Interface of the ways to show a result, see `display`."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

import bpy
import numpy as np

from . import modifier, split
from .mesh_arrays import read_mesh_coordinates, write_positions
from .paint_group import made_paint_group, remove_paint_group
from .shape_keys import has_foreign_keys, mixed_keys, remove_fairing_keys
from .stored_path import StoredPath, remove_path

if TYPE_CHECKING:  # enabling the add-on does not load the core
    from numpy.typing import NDArray

    from ...core.runtime.arrays import SingleArray


class Display:
    """Display of an object that has no result: it shows its mesh, or its shape keys.

    Attributes
    ----------
    obj
    slider
        Name of the property of the record that moves through the result; empty without.
    has_weights
        Whether painted weights scale the result.
    """

    name = ""
    slider = ""
    has_weights = False

    def __init__(self, obj: bpy.types.Object) -> None:
        self.obj = obj

    @property
    def is_whole(self) -> bool:
        """Whether all of the result is still there, and the slider can move something."""
        return False

    @property
    def has_original(self) -> bool:
        """Whether the original can be brought back; it may be where the result is not whole."""
        return self.is_whole

    @property
    def has_strokes(self) -> bool:
        """Whether somebody has moved vertices since the result was written."""
        return False

    @property
    def goes_on(self) -> bool:
        """Whether the original still is that of all that is shown: nobody has changed the mesh."""
        return self.is_whole

    @property
    def place(self) -> float:
        """Strength, or number of the step, that is shown."""
        return 0.0

    def show(self, place: float) -> None:
        """Show the path at a place, by the weights and the split of now."""

    def original(self) -> SingleArray | None:
        """Positions (n, 3) before the first run that still counts; None if they are not known."""
        return None

    def shown(self) -> SingleArray:
        """Positions (n, 3) that the object shows, other modifiers aside; not in Edit Mode."""
        mesh = self.obj.data
        if mesh.shape_keys is not None:
            return mixed_keys(mesh.shape_keys)
        return read_mesh_coordinates(mesh)

    def apply(self) -> None:
        """Keep what is shown, and nothing else of the result."""
        shown = self.shown()
        self.clear()
        write_positions(self.obj.data, shown)

    def forget(self) -> None:
        """Remove what stores the result, without what it has made of the mesh."""
        modifier.remove(self.obj)
        if self.obj.adaptive_fairing.result:
            remove_paint_group(self.obj)
        self.obj.adaptive_fairing.result = ""
        self.obj.data.property_unset("adaptive_fairing")
        remove_path(self.obj.data)

    def clear(self) -> None:
        """Remove the result; the coordinates stay, or the Basis."""
        self.forget()
        if not has_foreign_keys(self.obj.data):
            remove_fairing_keys(self.obj)

    def note_written(self) -> None:
        """Note that the shapes of the mesh are the result, however they came there."""

    def add_split(self, original: SingleArray) -> None:
        """Show these positions (n, 3) behind the plane of the record."""
        record = self.obj.adaptive_fairing
        split.add(self.obj, original, is_behind(original, record))

    def paint_group(self) -> bpy.types.VertexGroup:
        """Give the vertex group that scales the result, and let it count."""
        return made_paint_group(self.obj)


class ResultDisplay(Display, ABC):
    """Display of a result: what stores it, and lets another run go on from it."""

    @abstractmethod
    def write(self, path: StoredPath, place: float) -> None:
        """Store a path on an object that has no result, and show a place of it."""

    @abstractmethod
    def so_far(
        self, start: SingleArray, parts: list[float]
    ) -> tuple[SingleArray, list[SingleArray]]:
        """Give what another run of `denoise`, from the shown shape, adds its own offsets to.

        Parameters
        ----------
        start
            (n, 3) that is shown.
        parts
            Fractions of the place that is shown.

        Returns
        -------
        array, list of array
            (n, 3) original, and for every part the offset (n, 3) from it.
        """


def is_behind(original: SingleArray, record: bpy.types.PropertyGroup) -> NDArray[np.bool_]:
    """Which vertices (n,) are on the side of the split that shows the original."""
    return (original - np.float32(record.split_point)) @ np.float32(record.split_normal) < 0
