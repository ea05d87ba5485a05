"""Results on objects: stored, shown at a place of their path, compared, measured, and ended.

A `display` holds the result. The record of an object, with its sliders, is in `record_properties`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from types import SimpleNamespace
from typing import TYPE_CHECKING

import bpy
import numpy as np
from bpy.app.translations import pgettext_rpt as rpt_

from .coloring import (
    COMPARED_FIELDS,
    color_by_field,
    end_view,
    pause_view,
    remove_density,
    resume_view,
)
from .display import display_of, new_display
from .mesh_arrays import write_positions
from .object_mode import object_mode
from .shape_keys import animate_evolution, animated_frames
from .shown_surface import CONTROL, refine_result, show_control
from .stored_path import StoredPath
from .targets import remove_mesh
from .vertex_groups import have_weights_changed

if TYPE_CHECKING:  # enabling the add-on does not load the core
    from numpy.typing import NDArray

    from ...core import FairingSettings


MEASURES = ("curvature_energy", "area", "volume", "displacement")
"""Measures of a shape in the record."""


def store(
    obj: bpy.types.Object,
    path: StoredPath,
    place: float,
    way: str,
    *,
    weights: NDArray[np.floating] | None = None,
    from_original: bool = False,
) -> None:
    """Store the path of a run and show it.

    A second run continues the first: 0 stays the first original. A run of `denoise` adds the first
    run's offset at each strength. Where vertices were moved by hand in between, strength 0 is that
    shape. A run on a region has a strength of its own: outside of the region the shape shown now
    stays, at strength 0 too.

    Parameters
    ----------
    obj
        Object that may be written, see `writable_object`.
    path
        From the positions that the run started from.
    place
        Knot of the path to show.
    way
        How to show it: an identifier of `OutputProperties.result` or `OutputProperties.output`.
    weights
        (n,) of the run, if it was on a region: 0 outside, 1 inside.
    from_original
        Whether the run started from the original, so that earlier ones do not count.
    """
    earlier, display, frames = display_of(obj), new_display(obj, way), animated_frames(obj)
    if not from_original and display.continues(earlier):
        path = display.continued(earlier, path, place, weights)
    clear(obj)
    display.write(path, place)
    if frames is not None and display.slider == "evolution":
        animate_evolution(obj, *frames)


@dataclass
class Shown:
    """Objects that `on_control` shows; what `show_control` and `refine_result` return of them."""

    objects: set[bpy.types.Object]
    kept: str | None = None
    notes: tuple[str, ...] = ()


@contextmanager
def on_control(
    obj: bpy.types.Object, settings: FairingSettings | None = None, *, for_run: bool = False
) -> Iterator[Shown]:
    """Give an object in Object Mode its control mesh, without colours, for the body.

    After it the objects of `Shown`, to which the body may add copies, show what they have by then
    on the surface of their record, and in the same colours.

    Parameters
    ----------
    obj
    settings
        As in `color_by_field`.
    for_run
        Whether a run is to write to the object. It takes a refined mesh that somebody has changed
        for the control mesh, since it has read that.

    Raises
    ------
    FairingError
        As `refine_result`.
    """
    shown, view, display = Shown({obj}), pause_view(obj), display_of(obj)
    if for_run and not display.is_refined:
        obj.adaptive_fairing.surface = CONTROL
    else:
        shown.kept = show_control(display)
    try:
        yield shown
    finally:
        for each in shown.objects:
            shown.notes += refine_result(display_of(each))
            resume_view(each, view, settings)


def show_at(obj: bpy.types.Object, place: float) -> None:
    """Show a result at a place of its path, if it is still whole, and update its colours."""
    with _mesh_writable(obj):
        if display_of(obj).is_whole:
            show_before(obj, False)
            display_of(obj).show(place)


def follow_weights(obj: bpy.types.Object) -> None:
    """Show a result with its painted weights, unless it does already."""
    display = display_of(obj)
    if have_weights_changed(obj) and display.is_whole:
        display.show(display.place)


def show_before(obj: bpy.types.Object, is_before: bool) -> None:
    """Show the original, or the result again, whatever the slider says."""
    record = obj.adaptive_fairing
    if record.is_before != is_before:
        record.is_before = is_before
        with _mesh_writable(obj):
            display_of(obj).compare()


def show_split(obj: bpy.types.Object, normal: Sequence[float], point: Sequence[float]) -> None:
    """Show the original behind a plane, given in object space; in Object Mode."""
    record = obj.adaptive_fairing
    record.is_split, record.split_normal, record.split_point = True, normal, point
    display_of(obj).compare()


def end_comparison(obj: bpy.types.Object) -> None:
    """Show the whole result again; in Object Mode."""
    record = obj.adaptive_fairing
    if record.is_before or record.is_split:
        record.is_before = record.is_split = False
        display_of(obj).compare()


@contextmanager
def _mesh_writable(obj: bpy.types.Object) -> Iterator[None]:
    """Leave Edit Mode for the body, and update the colours that depend on the shape after it."""
    with object_mode(bpy.context) if obj.data.is_editmode else nullcontext():
        yield
        view = obj.adaptive_fairing.view
        # They tell the shape that is shown from the original.
        if view in COMPARED_FIELDS and display_of(obj).is_whole:
            color_by_field(obj, view)


def is_of_strengths(record: bpy.types.PropertyGroup) -> bool:
    """Whether the run was `denoise`, whose shapes are strengths; those of `fair` are steps."""
    return any(shape.strength > 0 for shape in record.shapes)


def result_measures(record: bpy.types.PropertyGroup) -> SimpleNamespace:
    """Interpolate the measures at the slider's place; without a slider take those of the result."""
    shapes, display = record.shapes, display_of(record.id_data)
    place, numbers = display.place, range(len(shapes))
    if not display.is_whole or not display.slider:
        place = record.shown
    elif display.slider == "strength":
        place = np.interp(place, [each.strength for each in shapes], numbers)
    values = {name: [getattr(each, name) for each in shapes] for name in MEASURES}
    return SimpleNamespace(**{name: np.interp(place, numbers, values[name]) for name in MEASURES})


def apply(obj: bpy.types.Object) -> None:
    """Keep the shape that is shown, and remove everything else of the runs.

    Raises
    ------
    InputError
        There is no result, or part of it is lost.
    """
    _require(display_of(obj).is_whole)
    display_of(obj).apply()
    clear(obj)


def discard(obj: bpy.types.Object) -> str | None:
    """Restore an object as it was before the first run that is still in effect.

    Returns as `show_control`.

    Raises
    ------
    InputError
        There is no result.
    """
    end_view(obj)
    display = display_of(obj)
    kept, original = show_control(display), display.original()
    _require(original is not None)
    clear(obj)
    if obj.data.shape_keys is None:
        write_positions(obj.data, original)
    return kept


def _require(has_result: bool) -> None:
    if not has_result:
        from ...core import InputError

        raise InputError(rpt_("there is no result on this object"))


def clear(obj: bpy.types.Object) -> None:
    """Remove everything that runs have left on an object; its coordinates or its Basis stay.

    Objects that share its mesh have the same result, which ends for them too.
    """
    display_of(obj).clear()
    forget(obj)


def forget(obj: bpy.types.Object) -> None:
    """Remove what runs have left, except shape keys; the coordinates stay. See `clear`."""
    for each in bpy.data.objects:
        if each.data != obj.data or not each.is_editable:
            continue
        record = each.adaptive_fairing
        if record.view:  # else it may be paused, see `pause_view`
            end_view(each)
        display_of(each).forget()
        control, record.control = record.control, None
        if control is not None:
            remove_mesh(control)
        if record.keeps_density:
            remove_density(each.data)
        record.notes, record.keeps_density = "", False
        record.shapes.clear()
        record.steps.clear()
