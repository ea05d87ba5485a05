"""Properties of the record on an object, and its sliders: saved and undone with the file."""

from __future__ import annotations

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from . import modifier
from .field_attributes import COMPARED_FIELDS
from .record_functions import N_STRENGTHS, NOT_HELD, evolution_keys
from .stored_offsets import is_current, shown_by, write_shown

LARGEST_STRENGTH = 200.0
N_SWATCHES = 5


def swatch_name(number: int) -> str:
    """Name of the property with a colour of the legend, from low to high."""
    return f"swatch_{number}"


def _swatch(number: int) -> object:
    def color(record: FairingRecord) -> tuple[float, ...]:
        from .color_map import ANCHORS, DIVERGING_ANCHORS, SIGNED_FIELDS, colors_srgb

        anchors = DIVERGING_ANCHORS if record.view in SIGNED_FIELDS else ANCHORS
        return tuple(colors_srgb([number / (N_SWATCHES - 1)], 0.0, 1.0, anchors)[0])

    def ignore(record: FairingRecord, value: object) -> None:
        """Leave the legend as it is; a colour without a setter would be drawn greyed out."""

    return FloatVectorProperty(subtype="COLOR_GAMMA", size=3, get=color, set=ignore)


class FairingShapeMeasures(bpy.types.PropertyGroup):
    """Measures of one shape of a run: its step or strength; the first is the input.

    `strength` is 0 for the steps of the paper's methods.
    """

    __slots__ = ()  # Blender 5.2 warns of groups without

    strength: FloatProperty()
    curvature_energy: FloatProperty()
    area: FloatProperty()
    volume: FloatProperty()
    displacement: FloatProperty()


class FairingSlotBefore(bpy.types.PropertyGroup):
    """What a material slot of the object had before it got the colours of a field."""

    __slots__ = ()

    link: StringProperty()
    material: PointerProperty(type=bpy.types.Material, description="Of the slot of the object")


def _shown_evolution(record: FairingRecord) -> float:
    keys = evolution_keys(record.id_data)
    if keys is None:
        return 0.0
    last = keys.key_blocks[-1].frame
    return min(max(keys.eval_time / last, 0.0), 1.0) if last > 0 else 0.0


def _show_evolution(record: FairingRecord, value: float) -> None:
    keys = evolution_keys(record.id_data)
    if keys is not None and record.id_data.mode != "EDIT":
        from .shape_keys import show_time  # needs the core, which enabling the add-on does not load

        record.held = NOT_HELD
        show_time(keys, value * keys.key_blocks[-1].frame)
        _color_anew(record)


def _strength(record: FairingRecord) -> float:
    if record.result == "MODIFIER":
        return modifier.strength_of(record.id_data)
    return record.stored_strength


def _set_strength(record: FairingRecord, value: float) -> None:
    if is_current(record.id_data):
        record.held = NOT_HELD
        _show_strength(record, value)


def _show_strength(record: FairingRecord, strength: float) -> None:
    """Show a stored result at a strength. It must be current."""
    obj = record.id_data
    record.stored_strength = strength
    if record.result == "MODIFIER":
        modifier.set_strength(obj, strength)
    else:
        write_shown(obj, shown_by(obj))
    _color_anew(record)


def _color_anew(record: FairingRecord) -> None:
    """Let the colours follow the shape that is shown, where they tell it from the original."""
    if record.view in COMPARED_FIELDS:
        from ...core import FairingSettings
        from .coloring import color_by_field

        color_by_field(record.id_data, record.view, FairingSettings())


# No methods: the bpy module of Blender 4.2 crashes at its end after a group of properties that has
# some was unregistered.
class FairingRecord(bpy.types.PropertyGroup):
    """The runs on an object that still count, and the measures of the last one.

    `result` is described in `results`. `shown` is the number of the shape that is the result of
    the last run. From `noise` to `is_sharp` all is known of `denoise` only, see `DenoiseResult`.
    """

    __slots__ = ()

    result: StringProperty()
    surface: StringProperty(description="Identifier of SURFACES in `shown_surface`, or empty")
    control: PointerProperty(
        type=bpy.types.Mesh, description="Control mesh, while the object has a refined one"
    )
    refined_fingerprint: StringProperty(description="Of the refined mesh as it was made")
    checksum: StringProperty(description="Of the coordinates that belong to the stored result")
    strengths: FloatVectorProperty(size=N_STRENGTHS)
    n_strengths: IntProperty()
    stored_strength: FloatProperty()
    held: FloatProperty(default=NOT_HELD, description="Of the slider, while the original is shown")
    is_split: BoolProperty(description="Whether one half shows the original")
    split_normal: FloatVectorProperty(size=3)
    split_point: FloatVectorProperty(size=3)
    strength: FloatProperty(
        name="Strength",
        description=(
            "How much of the noise is removed: 0 is the original, 1 what was estimated; works in "
            "real time"
        ),
        min=0.0,
        soft_max=2.0,
        max=LARGEST_STRENGTH,
        step=5,
        precision=2,
        get=_strength,
        set=_set_strength,
    )
    shapes: CollectionProperty(type=FairingShapeMeasures)
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
    keeps_density: BoolProperty(description="The density is a result, not only looked at")
    view: StringProperty()
    view_range: FloatVectorProperty(size=2, description="Values at the ends of the legend")
    view_power: IntProperty(description="They are object units of length to this power")
    wants_material: BoolProperty(description="Renders have the colours of the view")
    slots_before: CollectionProperty(type=FairingSlotBefore)
    has_new_slot: BoolProperty(description="The mesh had no material slot")
    swatch_0: _swatch(0)
    swatch_1: _swatch(1)
    swatch_2: _swatch(2)
    swatch_3: _swatch(3)
    swatch_4: _swatch(4)
    evolution: FloatProperty(
        name="Evolution",
        description=("Run through the smoothing: from the mesh before (0) to the last step (1)"),
        subtype="FACTOR",
        min=0.0,
        max=1.0,
        precision=3,
        get=_shown_evolution,
        set=_show_evolution,
        options=set(),
    )


_register_classes, _unregister_classes = bpy.utils.register_classes_factory(
    (FairingShapeMeasures, FairingSlotBefore, FairingRecord)
)


def register() -> None:
    """Give every object a record."""
    _register_classes()
    bpy.types.Object.adaptive_fairing = bpy.props.PointerProperty(type=FairingRecord)


def unregister() -> None:
    """Take the records back."""
    del bpy.types.Object.adaptive_fairing
    _unregister_classes()
