"""Functions of the record: strengths, measures, the look at the original.

The record itself, with the sliders, is in `record_properties`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, TypeAlias

import bpy
import numpy as np

from . import split
from .mesh_arrays import read_mesh_coordinates
from .stored_offsets import checksum, update_shown

Record: TypeAlias = Any
"""A `record_properties.FairingRecord`: Blender makes its properties, no type checker sees them."""

NOT_HELD = -1.0
N_STRENGTHS = 8
"""Room for strengths in a record: a vector property has a fixed size."""


def forget(record: Record) -> None:
    """Forget the runs, with their measures."""
    record.result, record.notes, record.keeps_density = "", "", False
    record.shapes.clear()


def set_strengths(record: Record, strengths: Sequence[float], shown: float) -> None:
    """Note the strengths of the stored offsets, and which one is shown."""
    record.n_strengths = len(strengths)
    record.strengths = [*strengths, *[0.0] * (N_STRENGTHS - len(strengths))]
    record.stored_strength = shown


def has_slider(record: Record) -> bool:
    """Whether a slider runs from the original to the result."""
    return record.result in ("LIVE", "MODIFIER") or evolution_keys(record.id_data) is not None


def toggle_before(record: Record) -> None:
    """Show the original, or the result again."""
    name = "evolution" if record.result == "KEYS" else "strength"
    if record.held != NOT_HELD:
        end_before(record)
        return
    held = getattr(record, name)
    setattr(record, name, 0.0)
    record.held = held


def split_along(record: Record, normal: Sequence[float], point: Sequence[float]) -> None:
    """Note the plane, given in object space, behind which the original is shown."""
    record.is_split, record.split_normal, record.split_point = True, normal, point
    update_shown(record.id_data)


def end_before(record: Record) -> None:
    """Show the result again after the original."""
    if record.held != NOT_HELD:
        setattr(record, "evolution" if record.result == "KEYS" else "strength", record.held)


def end_comparison(record: Record) -> None:
    """Show the whole result again; in Object Mode."""
    end_before(record)
    if record.is_split:
        record.is_split = False
        split.remove(record.id_data)
        update_shown(record.id_data)


def remember_coordinates(record: Record) -> None:
    """Note that the coordinates of the mesh belong to the stored result."""
    record.checksum = checksum(read_mesh_coordinates(record.id_data.data))


def is_of_strengths(record: Record) -> bool:
    """Whether a run was one of `denoise`, whose shapes are strengths; of `fair` they are steps."""
    return any(shape.strength > 0 for shape in record.shapes)


@dataclass(frozen=True)
class ShownMeasures:
    """Measures of the shape that the slider shows."""

    curvature_energy: float
    area: float
    volume: float
    displacement: float


def result_measures(record: Record) -> ShownMeasures:
    """Interpolate the measures where the slider stands; without a slider take the result's."""
    shapes = record.shapes
    if record.result in ("LIVE", "MODIFIER"):
        place = np.interp(record.strength, [each.strength for each in shapes], range(len(shapes)))
    elif record.result == "KEYS" and evolution_keys(record.id_data) is not None:
        place = record.evolution * (len(shapes) - 1)
    else:
        place = record.shown

    def at_place(name: str) -> float:
        return float(np.interp(place, range(len(shapes)), [getattr(each, name) for each in shapes]))

    return ShownMeasures(*(at_place(each.name) for each in fields(ShownMeasures)))


def evolution_keys(obj: bpy.types.Object) -> bpy.types.Key | None:
    """Return the absolute shape keys of an object, which the Evolution slider moves through."""
    keys = getattr(obj.data, "shape_keys", None)
    return keys if keys is not None and not keys.use_relative else None
