"""Results on an object, from storing to removing them; `display` shows them."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np
from bpy.app.translations import pgettext_rpt as rpt_
from numpy.typing import NDArray

from ...core import InputError
from ...core.runtime.arrays import SingleArray
from .coloring import end_view
from .display import display_of, new_display
from .field_attributes import remove_density
from .mesh_arrays import write_positions
from .record_functions import forget as forget_record
from .rollback import remove_mesh
from .shape_keys import animate_evolution, animated_frames, write_final_shape
from .stored_path import ORIGINAL, StoredPath, write_vectors


def store_strengths(
    obj: bpy.types.Object,
    start: SingleArray,
    shapes: list[SingleArray],
    strengths: list[float],
    strength: float,
    way: str,
    *,
    weights: NDArray[np.floating] | None = None,
    from_original: bool = False,
) -> None:
    """Store the result of `denoise` and show it.

    A second run continues the first: strength 0 stays the first original, and the first run's
    offset at each strength is added. Where vertices were moved by hand in between, strength 0 is
    that shape. A run on a region has a strength of its own: outside of the region the shape shown
    now stays, at strength 0 too.

    Parameters
    ----------
    obj
        Object that may be written, see `writable_object`.
    start
        (n, 3) positions that the run started from.
    shapes, strengths
        (n, 3) positions at each strength.
    strength
        Strength to show.
    way
        "LIVE" or "MODIFIER".
    weights
        (n,) of the run, if it was on a region: 0 outside, 1 inside.
    from_original
        Whether the run started from the original, so that earlier ones do not count.
    """
    earlier = display_of(obj)
    path = StoredPath.through(start, strengths, shapes)
    if earlier.is_whole and not from_original:
        parts = [1.0, *(each / strength for each in strengths)]
        original, (kept, *moves) = earlier.so_far(start, parts)
        if weights is not None:
            inside = np.float32(weights)[:, None]
            moves = [kept + inside * (each - kept) for each in (np.zeros_like(kept), *moves)]
            strengths, shapes = [0.0, *strengths], [start, *shapes]
        path = StoredPath(
            original, tuple(strengths), lambda index: moves[index] + (shapes[index] - start)
        )
    clear(obj)
    new_display(obj, way).write(path, strength)


def store_steps(
    obj: bpy.types.Object, start: SingleArray, shapes: list[SingleArray], output: str
) -> None:
    """Store the steps of the paper's methods as shape keys, or move the vertices.

    Parameters
    ----------
    obj, start, shapes
        As in `store_strengths`.
    output
        Identifier of `OutputProperties.output`.
    """
    earlier = display_of(obj)
    original = earlier.original() if earlier.goes_on else start
    frames = animated_frames(obj)
    clear(obj)
    write_positions(obj.data, start)
    if output == "FINAL_SHAPE":
        write_final_shape(obj, shapes[-1])
        return
    display = new_display(obj, output)
    steps = range(1, len(shapes) + 1)
    display.write(StoredPath.through(start, steps, shapes), steps[-1])
    if frames is not None and display.slider:
        animate_evolution(obj, *frames)
    if not np.array_equal(original, start):
        write_vectors(obj.data, ORIGINAL, original)


def apply(obj: bpy.types.Object) -> None:
    """Keep the shape that is shown, and remove everything else of the runs.

    Raises
    ------
    InputError
        There is no result, or part of it is lost.
    """
    if not display_of(obj).is_whole:
        raise InputError(rpt_("there is no result on this object"))
    display_of(obj).apply()
    clear(obj)


def discard(obj: bpy.types.Object) -> None:
    """Restore an object as it was before the first run that is still in effect.

    Raises
    ------
    InputError
        There is no result.
    """
    original = _original(obj)
    clear(obj)
    if obj.data.shape_keys is None:
        write_positions(obj.data, original)


def show_split(obj: bpy.types.Object, normal: Sequence[float], point: Sequence[float]) -> None:
    """Show the original behind a plane, given in object space.

    Raises
    ------
    InputError
        There is no result.
    """
    original, record = _original(obj), obj.adaptive_fairing
    record.is_split, record.split_normal, record.split_point = True, normal, point
    display_of(obj).add_split(original)


def _original(obj: bpy.types.Object) -> SingleArray:
    original = display_of(obj).original()
    if original is None:
        raise InputError(rpt_("there is no result on this object"))
    return original


def drop_control(obj: bpy.types.Object) -> None:
    """Forget the control mesh of a refined one."""
    record = obj.adaptive_fairing
    control, record.control = record.control, None
    if control is not None:
        remove_mesh(control)


def clear(obj: bpy.types.Object) -> None:
    """Remove everything that runs have left on an object; its coordinates or its Basis stay.

    Objects that share its mesh have the same result, which ends for them too.
    """
    display_of(obj).clear()
    forget(obj)


def forget(obj: bpy.types.Object) -> None:
    """Remove what runs have left, except shape keys; the coordinates stay. See `clear`."""
    for each in bpy.data.objects:
        if each.data == obj.data and each.is_editable:
            if each.adaptive_fairing.view:  # else it may be paused, see `pause_view`
                end_view(each)
            display_of(each).forget()
            drop_control(each)
            if each.adaptive_fairing.keeps_density:
                remove_density(each.data)
            forget_record(each.adaptive_fairing)
