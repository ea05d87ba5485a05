"""What a run did to an object, kept on the object: saved with the file, undone with the run."""

from __future__ import annotations

import bpy
import numpy as np
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    StringProperty,
)

from ..properties import AUTO


class FairingShapeMeasures(bpy.types.PropertyGroup):
    """Measures of one shape of a run: its step or strength; the first is the input.

    `strength` is 0 for the steps of the paper's methods.
    """

    strength: FloatProperty()
    curvature_energy: FloatProperty()
    area: FloatProperty()
    volume: FloatProperty()
    displacement: FloatProperty()


def _shown_evolution(record: FairingRecord) -> float:
    keys = evolution_keys(record.id_data)
    if keys is None:
        return 0.0
    last = keys.key_blocks[-1].frame
    return min(max(keys.eval_time / last, 0.0), 1.0) if last > 0 else 0.0


def _show_evolution(record: FairingRecord, value: float) -> None:
    keys = evolution_keys(record.id_data)
    if keys is not None:
        keys.eval_time = value * keys.key_blocks[-1].frame


class FairingRecord(bpy.types.PropertyGroup):
    """A finished run.

    `shown` is the number of the shape that is its result. From `noise` to `is_sharp` all
    is known of `denoise` only, see `DenoiseResult`.
    """

    shapes: CollectionProperty(type=FairingShapeMeasures)
    method: StringProperty()
    tau: FloatProperty()
    stop_reason: StringProperty()
    seconds: FloatProperty()
    iterations: IntProperty()
    notes: StringProperty(description="What had to be done to make the mesh solvable, in lines")
    shown: IntProperty()
    noise: FloatProperty()
    noise_length: FloatProperty()
    radius: FloatProperty()
    is_sharp: BoolProperty()
    view: StringProperty()
    view_range: FloatVectorProperty(size=2)
    evolution: FloatProperty(
        name="Evolution",
        description=(
            "Run through the smoothing: from the mesh before (0) to the last step, or to the "
            "largest strength (1)"
        ),
        subtype="FACTOR",
        min=0.0,
        max=1.0,
        precision=3,
        get=_shown_evolution,
        set=_show_evolution,
        options=set(),
    )


def is_of_strengths(record: FairingRecord) -> bool:
    """Whether a run was one of `denoise`, whose shapes are strengths."""
    return record.method == AUTO


def shown_strength(record: FairingRecord) -> float:
    """Strength that the Evolution slider stands at, which is 0 at the mesh before."""
    strengths = [shape.strength for shape in record.shapes]
    place = record.evolution * (len(strengths) - 1)
    return float(np.interp(place, range(len(strengths)), strengths))


def result_measures(record: FairingRecord) -> FairingShapeMeasures:
    """Take the measures of the result: of the strength asked for, otherwise of the last step."""
    return record.shapes[record.shown]


def evolution_keys(obj: bpy.types.Object) -> bpy.types.Key | None:
    """Return the absolute shape keys of an object, which the Evolution slider moves through."""
    keys = getattr(obj.data, "shape_keys", None)
    return keys if keys is not None and not keys.use_relative else None


_register_classes, _unregister_classes = bpy.utils.register_classes_factory(
    (FairingShapeMeasures, FairingRecord)
)


def register() -> None:
    """Give every object a record."""
    _register_classes()
    bpy.types.Object.adaptive_fairing = bpy.props.PointerProperty(type=FairingRecord)


def unregister() -> None:
    """Take the records back."""
    del bpy.types.Object.adaptive_fairing
    _unregister_classes()
