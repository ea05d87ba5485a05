"""Interface of the displays of a result, see `display`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
import numpy as np

from . import modifier
from .mesh_arrays import remove_attributes, write_positions
from .shape_keys import has_foreign_keys, remove_fairing_keys, shown_positions
from .stored_path import StoredPath, stored_names
from .vertex_groups import made_paint_group, remove_paint_group

if TYPE_CHECKING:  # enabling the add-on does not load the core
    from numpy.typing import NDArray

    from ...core.runtime.arrays import SingleArray


SHARED = (
    *("result", "strengths", "n_strengths", "keeps_density"),
    *("surface", "control", "refined_fingerprint"),
)
"""Properties of the record that all objects with one mesh have in common."""


class Display:
    """Display of an object that has no result: it shows its mesh, or its shape keys.

    Attributes
    ----------
    obj
    slider
        Name of the record's property that moves through the result; empty for none.
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
        """Whether the whole result is still stored, so that the slider works."""
        return False

    @property
    def has_original(self) -> bool:
        """Whether the original can be restored, even if the result is no longer whole."""
        return self.is_whole

    @property
    def has_strokes(self) -> bool:
        """Whether vertices were moved by hand since the result was written."""
        return False

    @property
    def goes_on(self) -> bool:
        """Whether the stored original still belongs to the shape shown: the mesh is unchanged."""
        return self.is_whole

    @property
    def has_control(self) -> bool:
        """Whether a mesh other than the control mesh shows the result, see `shown_surface`."""
        return self.obj.adaptive_fairing.control not in (None, self.obj.data)

    @property
    def is_refined(self) -> bool:
        """Whether a refined mesh shows the result, and nobody has changed it."""
        return self.has_control and self.is_whole and not self.has_strokes

    @property
    def place(self) -> float:
        """Knot of the path that is shown, or a number between two: a strength or a step."""
        return 0.0

    @property
    def unit(self) -> float:
        """Place on the path where the slider is 1."""
        return 1.0

    def so_far(
        self, start: SingleArray, parts: list[float]
    ) -> tuple[SingleArray, list[SingleArray]]:
        """Original and offsets to which a further run of `denoise` adds its own offsets.

        Parameters
        ----------
        start
            (n, 3) positions that are shown.
        parts
            Fractions of the strength that is shown.

        Returns
        -------
        array, list of array
            (n, 3) original, and for each fraction the offset (n, 3) from it.
        """
        original = self.original()
        move = start - original
        return original, [np.float32(min(part, 1.0)) * move for part in parts]

    def continues(self, earlier: Display) -> bool:
        """Whether a result that is stored in this way continues an earlier one."""
        return earlier.goes_on

    def continued(
        self, earlier: Display, path: StoredPath, place: float, weights: NDArray | None
    ) -> StoredPath:
        """Let the path of a run continue an earlier result, see `results.store`."""
        return path

    def write(self, path: StoredPath, place: float) -> None:
        """Store a path on an object without a result, and show it at one of its knots."""
        write_positions(self.obj.data, path.original + path.offset_at(path.knots.index(place)))

    def show(self, place: float) -> None:
        """Show the path at a place, with the present weights and split."""

    def original(self) -> SingleArray | None:
        """Positions (n, 3) before the first run that still counts; None if they are not known."""
        return None

    def shown(self) -> SingleArray:
        """Positions (n, 3) that the object shows, other modifiers aside; not in Edit Mode."""
        return shown_positions(self.obj.data)

    def apply(self) -> None:
        """Keep the shape that is shown, and remove everything else of the result."""
        shown = self.shown()
        self.clear()
        write_positions(self.obj.data, shown)

    def forget(self) -> None:
        """Remove the stored result; the mesh keeps its shape."""
        modifier.remove(self.obj)
        if self.obj.adaptive_fairing.result:
            remove_paint_group(self.obj)
        self.obj.adaptive_fairing.result = ""
        self.obj.data.property_unset("adaptive_fairing")
        remove_attributes(self.obj.data, stored_names(self.obj.data))

    def clear(self) -> None:
        """Remove the result; the coordinates stay, or the Basis."""
        self.forget()
        if not has_foreign_keys(self.obj.data):
            remove_fairing_keys(self.obj)

    def note_written(self) -> None:
        """Note that the present shapes of the mesh are the result."""

    def share(self, other: bpy.types.Object) -> None:
        """Let another object, whose mesh was the same before the run, show the same result."""
        modifier.remove(other)
        other.data = self.obj.data
        other.active_shape_key_index = self.obj.active_shape_key_index
        for name in SHARED:
            setattr(other.adaptive_fairing, name, getattr(self.obj.adaptive_fairing, name))

    def compare(self) -> None:
        """Show the original where the record says so, and the result elsewhere."""
        record, behind = self.obj.adaptive_fairing, self._behind
        modifier.remove_split(self.obj)
        if behind is not None and (record.is_before or record.is_split):
            modifier.add_split(self.obj, behind, is_behind(behind, record))

    @property
    def _behind(self) -> SingleArray | None:
        """Positions (n, 3) that a comparison shows in place of the result."""
        return self.original()

    def paint_group(self) -> bpy.types.VertexGroup:
        """Return the vertex group that scales the result, and make it take effect."""
        return made_paint_group(self.obj)


def is_behind(original: SingleArray, record: bpy.types.PropertyGroup) -> NDArray[np.bool_]:
    """Whether each vertex is on the side of the split that shows the original, (n,)."""
    if record.is_before:
        return np.ones(len(original), dtype=bool)
    return (original - np.float32(record.split_point)) @ np.float32(record.split_normal) < 0
