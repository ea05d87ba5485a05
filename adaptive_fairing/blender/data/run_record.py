"""What a run did to an object, kept on the object: saved with the file, undone with the run."""

from __future__ import annotations

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    StringProperty,
)


class FairingStepRecord(bpy.types.PropertyGroup):
    """Measures of the surface after one step; the first record is the input.

    `strength` is 0 but for the method "auto", whose steps have one each.
    """

    curvature_energy: FloatProperty()
    area: FloatProperty()
    volume: FloatProperty()
    iterations: IntProperty()
    displacement: FloatProperty()
    strength: FloatProperty()


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

    `chosen` is the number of the step that is its result. What follows it is known of the method
    "auto" only, see the core's `AutoEstimate`.
    """

    steps: CollectionProperty(type=FairingStepRecord)
    method: StringProperty()
    tau: FloatProperty()
    stop_reason: StringProperty()
    seconds: FloatProperty()
    notes: StringProperty(description="What had to be done to make the mesh solvable, in lines")
    chosen: IntProperty()
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
    """Whether the steps of a run are strengths of the method "auto"."""
    return record.steps[-1].strength > 0


def shown_strength(record: FairingRecord) -> float:
    """Strength that the Evolution slider stands at, which is 0 at the mesh before."""
    steps = record.steps
    place = record.evolution * (len(steps) - 1)
    below = min(int(place), len(steps) - 2)
    low, high = steps[below].strength, steps[below + 1].strength
    return low + (place - below) * (high - low)


def result_step(record: FairingRecord) -> FairingStepRecord:
    """Take the measures of the result: of the chosen strength, otherwise of the last step."""
    # A file of a version that did not know "auto" has no number here.
    return record.steps[record.chosen or -1]


def evolution_keys(obj: bpy.types.Object) -> bpy.types.Key | None:
    """Return the absolute shape keys of an object, which the Evolution slider moves through."""
    keys = getattr(obj.data, "shape_keys", None)
    return keys if keys is not None and not keys.use_relative else None


_register_classes, _unregister_classes = bpy.utils.register_classes_factory(
    (FairingStepRecord, FairingRecord)
)


def register() -> None:
    """Give every object a record."""
    _register_classes()
    bpy.types.Object.adaptive_fairing = bpy.props.PointerProperty(type=FairingRecord)


def unregister() -> None:
    """Take the records back."""
    del bpy.types.Object.adaptive_fairing
    _unregister_classes()
