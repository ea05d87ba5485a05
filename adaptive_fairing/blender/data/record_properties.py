"""Properties of the record on an object, and its sliders; Blender saves and undoes them."""

from __future__ import annotations

from collections.abc import Callable

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

from .display import N_STRENGTHS, display_of
from .results import show_at
from .sculpt_undo import keep_slide

LARGEST_STRENGTH = 200.0
N_SWATCHES = 5


def swatch_name(number: int) -> str:
    """Name of the property for a colour of the legend, counted from low to high."""
    return f"swatch_{number}"


def _swatch(number: int) -> object:
    def color(record: FairingRecord) -> tuple[float, ...]:
        from .color_map import ANCHORS, DIVERGING_ANCHORS, SIGNED_FIELDS, colors_srgb

        anchors = DIVERGING_ANCHORS if record.view in SIGNED_FIELDS else ANCHORS
        return tuple(colors_srgb([number / (N_SWATCHES - 1)], 0.0, 1.0, anchors)[0])

    def ignore(record: FairingRecord, value: object) -> None:
        """Setter that does nothing; a colour without a setter would be drawn greyed out."""

    return FloatVectorProperty(subtype="COLOR_GAMMA", size=3, get=color, set=ignore)


class FairingShapeMeasures(bpy.types.PropertyGroup):
    """Measures of one shape of a run, at a step or a strength; the first shape is the input.

    `strength` is 0 for the steps of the paper's methods.
    """

    __slots__ = ()  # Blender 5.2 warns of groups without

    strength: FloatProperty()
    curvature_energy: FloatProperty()
    area: FloatProperty()
    volume: FloatProperty()
    displacement: FloatProperty()


class FairingSlotBefore(bpy.types.PropertyGroup):
    """Content of a material slot of the object before it got the colours of a field."""

    __slots__ = ()

    link: StringProperty()
    material: PointerProperty(type=bpy.types.Material, description="Of the slot of the object")


def _slider(name: str) -> dict[str, Callable]:
    """Getter and setter of the slider through a result: its place on the path, in units."""

    def place(record: FairingRecord) -> float:
        display = display_of(record.id_data)
        return display.place / display.unit if display.slider == name else 0.0

    def show(record: FairingRecord, value: float) -> None:
        display = display_of(record.id_data)
        if display.slider == name:
            keep_slide(record.id_data)
            show_at(record.id_data, value * display.unit)

    return {"get": place, "set": show}


class FairingShown(bpy.types.PropertyGroup):
    """Result that is written to a mesh; all objects that share the mesh show it.

    `checksum` is that of the coordinates or of the shape keys, as they were written.
    """

    __slots__ = ()

    strength: FloatProperty()
    checksum: StringProperty()


# No methods: the bpy module of Blender 4.2 crashes at its end after a group of properties that has
# some was unregistered.
class FairingRecord(bpy.types.PropertyGroup):
    """Runs on an object that are still in effect, and the measures of the last one.

    `result` is described in `display`. `shown` is the index of the shape that is the result of the
    last run. The properties from `noise` to `is_sharp` are for `denoise` only, see `DenoiseResult`.
    """

    __slots__ = ()

    result: StringProperty()
    surface: StringProperty(description="Identifier of SURFACES, or empty")
    control: PointerProperty(
        type=bpy.types.Mesh, description="Control mesh, while the object has a refined one"
    )
    refined_fingerprint: StringProperty(description="Of the refined mesh as it was made")
    checksum: StringProperty(description="In earlier files, see `earlier_files`")
    stored_strength: FloatProperty(description="In earlier files, see `earlier_files`")
    refined_print: StringProperty(description="In earlier files, see `earlier_files`")
    held: FloatProperty(default=-1.0, description="In earlier files, see `earlier_files`")
    steps: CollectionProperty(
        type=FairingShapeMeasures, description="In earlier files, see `earlier_files`"
    )
    chosen: IntProperty(description="In earlier files, see `earlier_files`")
    strengths: FloatVectorProperty(size=N_STRENGTHS)
    n_strengths: IntProperty()
    is_before: BoolProperty(description="Whether the original is shown for a moment")
    is_split: BoolProperty(description="Whether one half shows the original")
    split_normal: FloatVectorProperty(size=3)
    split_point: FloatVectorProperty(size=3)
    strength: FloatProperty(
        name="Strength",
        description=(
            "How much of the noise is removed: 0 is none, 1 what was estimated; works in real time"
        ),
        min=0.0,
        soft_max=2.0,
        max=LARGEST_STRENGTH,
        step=5,
        precision=2,
        **_slider("strength"),
    )
    shapes: CollectionProperty(type=FairingShapeMeasures)
    tau: FloatProperty()
    stop_reason: StringProperty()
    seconds: FloatProperty()
    iterations: IntProperty()
    notes: StringProperty(description="What was done to make the mesh solvable, one line each")
    shown: IntProperty()
    noise: FloatProperty()
    noise_length: FloatProperty()
    radius: FloatProperty()
    is_sharp: BoolProperty()
    keeps_density: BoolProperty(description="The density was asked for as a result, not only shown")
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
        description=(
            "Evolution of the surface: from the mesh before the run (0) to the last step (1)"
        ),
        subtype="FACTOR",
        min=0.0,
        max=1.0,
        precision=3,
        options=set(),
        **_slider("evolution"),
    )


_register_classes, _unregister_classes = bpy.utils.register_classes_factory(
    (FairingShapeMeasures, FairingSlotBefore, FairingShown, FairingRecord)
)


def register() -> None:
    """Give every object its record, and every mesh the note of what it shows."""
    _register_classes()
    bpy.types.Mesh.adaptive_fairing = bpy.props.PointerProperty(type=FairingShown)
    bpy.types.Object.adaptive_fairing = bpy.props.PointerProperty(type=FairingRecord)


def unregister() -> None:
    """Take the records back."""
    del bpy.types.Mesh.adaptive_fairing
    del bpy.types.Object.adaptive_fairing
    _unregister_classes()
