"""Functions of the record: strengths, measures, comparison with the original.

The record itself, with the sliders, is in `record_properties`.
"""

from __future__ import annotations

from contextlib import nullcontext
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

NOT_HELD = -1.0


def forget(record: Record) -> None:
    """Forget the runs, with their measures."""
    record.result, record.notes, record.keeps_density = "", "", False
    record.shapes.clear()
    record.steps.clear()


def has_slider(record: Record) -> bool:
    """Whether a slider runs from the original to the result."""
    return bool(display_of(record.id_data).slider)


def show_at(record: Record, place: float) -> None:
    """Show a result at a place of its path, if it is still whole, and update its colours."""
    obj = record.id_data
    with object_mode(bpy.context) if obj.data.is_editmode else nullcontext():
        display = display_of(obj)
        if not display.is_whole:
            return
        record.held = NOT_HELD
        display.show(place)
        if record.view in COMPARED_FIELDS:  # tell the shape that is shown from the original
            from ...core import FairingSettings
            from .coloring import color_by_field

            color_by_field(obj, record.view, FairingSettings())


def toggle_before(record: Record) -> None:
    """Switch between the original and the result."""
    if record.held != NOT_HELD:
        end_before(record)
        return
    held = display_of(record.id_data).place
    show_at(record, 0.0)
    record.held = held


def end_before(record: Record) -> None:
    """Show the result again if the original is shown."""
    if record.held != NOT_HELD:
        show_at(record, record.held)
        record.held = NOT_HELD


def end_comparison(record: Record) -> None:
    """Show the whole result again; in Object Mode."""
    end_before(record)
    if record.is_split:
        record.is_split = False
        split.remove(record.id_data)
        update_shown(record.id_data)


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
