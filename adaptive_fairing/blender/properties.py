"""Settings of a scene, and the core's settings made from them or from an operator's."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import bpy
from bpy.props import BoolProperty, IntProperty

from .choices import DENOISE, FAIR
from .run_properties import CONTEXT, OutputProperties, SolverProperties

if TYPE_CHECKING:
    from ..core import DenoiseSettings, FairingSettings


class FairingSceneSettings(SolverProperties, OutputProperties, bpy.types.PropertyGroup):
    """Settings in the panel, one set per scene."""

    __slots__ = ()  # Blender 5.2 warns of groups without

    same_strength: BoolProperty(
        name="Same Strength",
        description="Smooth every frame as strongly as the first one, so that nothing flickers",
        default=True,
    )
    show_energy: BoolProperty(
        name="H",
        translation_context=CONTEXT,  # Blender's own H is that of a hue
        description="Show the curvature energy H of every step, as bars",
        default=False,
    )
    frame_start: IntProperty(
        name="From Frame", description="Frame that shows the mesh before the first step", default=1
    )
    frame_end: IntProperty(
        name="To Frame", description="Frame that shows the last step", default=100
    )


SOLVER_NAMES = tuple(SolverProperties.__annotations__)
OUTPUT_NAMES = tuple(OutputProperties.__annotations__)

DENOISE_NAMES = ("strength", "features", "boundary", "clean", "width", "max_deviation")
"""Settings of `denoise`, by their names in `DenoiseSettings`."""

FAIRING_NAMES = tuple(
    name
    for name in SOLVER_NAMES
    if name not in ("algorithm", "strength", "features", "clean", "width")
)
"""Settings of `fair`, by their names in `FairingSettings`; there the scheme is the method."""


def names_of(algorithm: str) -> tuple[str, ...]:
    """Names of the settings of an algorithm, including the choice of the algorithm."""
    return ("algorithm", *(DENOISE_NAMES if algorithm == DENOISE else FAIRING_NAMES))


def solver_settings(properties: SolverProperties) -> DenoiseSettings | FairingSettings:
    """Make the core's settings for the chosen algorithm.

    Raises
    ------
    SettingsError
        A value is invalid, such as τ = 0, or a script has given a setting of the other algorithm.
    """
    from ..core import DenoiseSettings, SettingsError

    algorithm = properties.algorithm
    for name in SOLVER_NAMES:
        if _is_given(properties, name) and name not in names_of(algorithm):
            owner = FAIR if algorithm == DENOISE else DENOISE
            raise SettingsError(f"{name} belongs to algorithm={owner!r}, not to {algorithm!r}")
    if algorithm == FAIR:
        return fairing_settings(properties)
    return DenoiseSettings(**_values(properties, DENOISE_NAMES))


def fairing_settings(properties: SolverProperties) -> FairingSettings:
    """Make the settings of `fair`.

    Raises
    ------
    SettingsError
        A value is invalid, such as τ = 0.
    """
    from ..core import FairingSettings
    from ..core.diffusion.settings import DENSITIES, SCHEMES

    values = _values(properties, FAIRING_NAMES)
    del values["use_tau"]
    if not uses_tau(properties):
        values["tau"] = None
    values["method"] = SCHEMES[values.pop("scheme").lower()]
    values["density"] = DENSITIES[values["density"].lower()]
    values["normalize"] = values["normalize"] != "NONE" and values["normalize"].lower()
    return FairingSettings(**values)


def way_of(properties: OutputProperties) -> str:
    """How a result of the chosen algorithm is shown, see `data.display.new_display`."""
    return properties.result if properties.algorithm == DENOISE else properties.output


def uses_tau(properties: SolverProperties) -> bool:
    """Whether τ counts instead of the radius: it was chosen, or a script has given only τ."""
    is_implied = _is_given(properties, "tau") and not _is_given(properties, "use_tau")
    return properties.use_tau or is_implied


def has_width(properties: SolverProperties) -> bool:
    """Whether the width of the noise was given, so that it is not estimated."""
    return properties.width >= 1


def in_object_units(
    settings: DenoiseSettings | FairingSettings, obj: bpy.types.Object
) -> DenoiseSettings | FairingSettings:
    """Convert the largest deviation from a length in the world to the units of a scaled object."""
    deviation = settings.max_deviation
    if deviation is None:
        return settings
    return replace(settings, max_deviation=deviation / obj.matrix_world.median_scale)


def _is_given(properties: SolverProperties, name: str) -> bool:
    """Whether a script or a button has set a property of an operator."""
    is_operator = isinstance(properties, bpy.types.Operator)
    return is_operator and properties.properties.is_property_set(name)


def _values(properties: SolverProperties, names: tuple[str, ...]) -> dict[str, object]:
    """Read settings; 0 becomes None where it means "no limit", and a width below 1 "auto"."""
    values = {name: _typed(getattr(properties, name)) for name in names}
    for name in {"max_deviation", "stop_curvature", "stop_rate"} & values.keys():
        values[name] = values[name] or None
    if "width" in values and not has_width(properties):
        values["width"] = "auto"
    return values


def _typed(value: object) -> object:
    """Recover the number that was typed; Blender stores float32, which has seven digits."""
    return float(f"{value:.7g}") if isinstance(value, float) else value


def copy_solver(
    source: SolverProperties, target: SolverProperties, algorithm: str | None = None
) -> None:
    """Copy an algorithm, by default that of the source, and its settings to a button."""
    copy_settings(source, target, names_of(algorithm or source.algorithm))
    target.algorithm = algorithm or source.algorithm


def copy_settings(source: object, target: object, names: tuple[str, ...]) -> None:
    """Copy the named properties."""
    for name in names:
        setattr(target, name, getattr(source, name))


_register_classes, _unregister_classes = bpy.utils.register_classes_factory((FairingSceneSettings,))


def register() -> None:
    """Give every scene a set of settings."""
    _register_classes()
    bpy.types.Scene.adaptive_fairing = bpy.props.PointerProperty(type=FairingSceneSettings)


def unregister() -> None:
    """Take the settings back."""
    del bpy.types.Scene.adaptive_fairing
    _unregister_classes()
