"""Functions of the record: strengths, measures, comparison with the original.

The record itself, with the sliders, is in `record_properties`.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, fields
from typing import Any, TypeAlias

import bpy
import numpy as np

from . import split
from .display import display_of
from .field_attributes import COMPARED_FIELDS
from .object_mode import object_mode

Record: TypeAlias = Any
"""A `record_properties.FairingRecord`; Blender makes its properties, unseen by type checkers."""


def forget(record: Record) -> None:
    """Forget the runs, with their measures."""
    record.result, record.notes, record.keeps_density = "", "", False
    record.shapes.clear()
    record.steps.clear()


@contextmanager
def _mesh_writable(obj: bpy.types.Object) -> Iterator[None]:
    """Leave Edit Mode for the body, and update the colours that depend on the shape after it."""
    with object_mode(bpy.context) if obj.data.is_editmode else nullcontext():
        yield
        view = obj.adaptive_fairing.view
        if (
            view in COMPARED_FIELDS and display_of(obj).is_whole
        ):  # tell the shape that is shown from the original
            from ...core import FairingSettings
            from .coloring import color_by_field

            color_by_field(obj, view, FairingSettings())


def show_at(record: Record, place: float) -> None:
    """Show a result at a place of its path, if it is still whole, and update its colours."""
    obj = record.id_data
    with _mesh_writable(obj):
        if display_of(obj).is_whole:
            end_before(record)
            display_of(obj).show(place)


def show_before(record: Record, is_before: bool) -> None:
    """Show the original, or the result again, whatever the slider says."""
    if record.is_before != is_before:
        record.is_before = is_before
        with _mesh_writable(record.id_data):
            _compare(record.id_data)


def end_before(record: Record) -> None:
    """Show the result again after the original."""
    show_before(record, False)


def end_comparison(record: Record) -> None:
    """Show the whole result again; in Object Mode."""
    if record.is_before or record.is_split:
        record.is_before = record.is_split = False
        _compare(record.id_data)


def _compare(obj: bpy.types.Object) -> None:
    """Show the original where the record says so, and the result elsewhere."""
    display, record = display_of(obj), obj.adaptive_fairing
    original = display.original() if record.is_before or record.is_split else None
    if original is None:
        split.remove(obj)
        update_shown(obj)
    else:
        display.add_split(original)


def update_shown(obj: bpy.types.Object) -> None:
    """Show a result with the present weights and split."""
    display = display_of(obj)
    if display.is_whole:
        display.show(display.place)


def is_of_strengths(record: Record) -> bool:
    """Whether the run was `denoise`, whose shapes are strengths; those of `fair` are steps."""
    return any(shape.strength > 0 for shape in record.shapes)


@dataclass(frozen=True)
class ShownMeasures:
    """Measures of the shape that the slider shows."""

    curvature_energy: float
    area: float
    volume: float
    displacement: float


def result_measures(record: Record) -> ShownMeasures:
    """Interpolate the measures at the slider's place; without a slider take those of the result."""
    shapes = record.shapes
    display = display_of(record.id_data)
    if not display.is_whole or not display.slider:
        place = record.shown
    elif display.slider == "strength":
        place = np.interp(display.place, [each.strength for each in shapes], range(len(shapes)))
    else:
        place = display.place

    def at_place(name: str) -> float:
        return float(np.interp(place, range(len(shapes)), [getattr(each, name) for each in shapes]))

    return ShownMeasures(*(at_place(each.name) for each in fields(ShownMeasures)))
