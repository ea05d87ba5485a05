"""Settings of a run as Blender properties: the same for the operator and for the panel.

`SolverProperties` and `OutputProperties` are mix-ins. The operator has them as its own properties,
so that scripts, the redo panel and undo work; the scene keeps another set that the panel edits,
presets store and the file saves.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from .choices import AUTO, FALLBACK_METHOD, LIVE, METHODS, RESULTS

if TYPE_CHECKING:
    from ..core import DenoiseSettings, FairingSettings

CONTEXT = "Adaptive Fairing"
"""Translation context of texts that Blender would translate by another meaning, or too long."""

DENOISE_NAMES = ("strength", "features", "boundary", "clean")
"""Settings of `denoise`, by their names in `DenoiseSettings`."""


class SolverProperties:
    """The algorithm, and the fields of the core's two settings under the same names."""

    method: EnumProperty(
        name="Method",
        description="How the smoothing follows the density of the mesh",
        items=METHODS,
        default=AUTO,
    )
    strength: FloatProperty(
        name="Strength",
        description=(
            "Factor of the noise that is estimated: more if noise is left, less if details go"
        ),
        default=1.0,
        min=0.01,
        soft_min=0.25,
        soft_max=4.0,
        max=99.0,
        step=5,
        precision=2,
    )
    features: EnumProperty(
        name="Edges",
        translation_context=CONTEXT,
        description="Whether the smoothing keeps sharp edges",
        items=(
            ("auto", "Automatic", "Decide in every part of the mesh what fits better"),
            ("sharp", "Keep Sharp", "The mesh has sharp edges, which stay where they can"),
            ("smooth", "Smooth", "The mesh has no sharp edges: what looks like one is noise"),
        ),
        default="auto",
    )
    clean: EnumProperty(
        name="Clean Meshes",
        description="What happens to a mesh that looks like a model without noise",
        items=(
            ("keep", "Leave Alone", "Change nothing, and say why"),
            (
                "detail",
                "Keep Fine Detail",
                "The same, and keep what looks like the smooth noise of a scanner: it is detail",
            ),
            ("denoise", "Denoise", "Take all that is rough for noise"),
        ),
        default="keep",
    )
    tau: FloatProperty(
        name="τ",
        description=(
            "Time of one step, with the mesh scaled to the box [-3, 3]³: "
            "larger values smooth over larger distances"
        ),
        default=0.016,
        min=0.0,
        soft_min=0.0001,
        soft_max=0.5,
        step=0.1,
        precision=4,
    )
    steps: IntProperty(
        name="Steps",
        translation_context=CONTEXT,
        description="How many steps to take; each one is kept",
        default=4,
        min=1,
        soft_max=20,
        max=1000,
    )
    density: EnumProperty(
        name="Measure",
        translation_context=CONTEXT,
        description="What the density of the mesh is measured by",
        items=(
            ("edge_length", "Edge Length", "Mean length of the edges at a vertex"),
            (
                "area",
                "Area",
                "Area of the triangles around a vertex; the smoothing radius is then the same "
                "number of edges everywhere",
            ),
        ),
        default="edge_length",
    )
    density_passes: IntProperty(
        name="Smoothing Passes",
        description="How often the measured density is smoothed before it is used",
        default=3,
        min=0,
        soft_max=10,
        max=100,
    )
    boundary: EnumProperty(
        name="Boundary",
        translation_context=CONTEXT,
        description="What happens to the rim of an open mesh",
        items=(
            ("fixed", "Fixed", "Boundary vertices stay exactly where they are"),
            ("free", "Free", "The boundary is smoothed along with the surface, and may shrink"),
        ),
        default="fixed",
    )
    stop_curvature: FloatProperty(
        name="Curvature Left",
        description=(
            "Stop once this part of the bending (curvature energy H) is left; 0 takes every step"
        ),
        default=0.0,
        min=0.0,
        soft_max=1.0,
        precision=3,
    )
    stop_rate: FloatProperty(
        name="Rate",
        description=(
            "Stop once the part of the bending changes by less than this per unit of time; "
            "0 takes every step"
        ),
        default=0.0,
        min=0.0,
        soft_max=10.0,
        precision=3,
    )
    cg_tolerance: FloatProperty(
        name="Solver Tolerance",
        description="Relative residual at which the linear system of a step counts as solved",
        default=1e-6,
        min=1e-12,
        max=0.1,
        precision=7,
        step=0.0001,
    )
    cg_max_iterations: IntProperty(
        name="Solver Iterations",
        description="Give up a step after this many iterations of the linear solver",
        default=5000,
        min=1,
        soft_max=10000,
    )
    quadrature_tolerance: FloatProperty(
        name="Integration Tolerance",
        description="Error of the integrals over the surface, relative to the largest",
        default=1e-3,
        min=1e-6,
        max=0.1,
        precision=6,
        step=0.01,
    )
    normalize: BoolProperty(
        name="Scale to Box",
        description=(
            "Scale the mesh to the box [-3, 3]³ for the solver, so that τ does not depend on its "
            "size; otherwise τ is in squared object units"
        ),
        default=True,
    )


class OutputProperties:
    """Where the smoothing works and what becomes of the result."""

    use_region: BoolProperty(
        name="Selection or Mask",
        description=(
            "In Edit Mode smooth the selected vertices only, if any are selected; "
            "in Sculpt Mode spare the masked ones"
        ),
        default=True,
    )
    vertex_group: StringProperty(
        name="Vertex Group",
        translation_context=CONTEXT,
        description="Smooth by the weights of this group; empty for the whole mesh",
    )
    invert_vertex_group: BoolProperty(
        name="Invert",
        description="Smooth where the weights of the group are small instead",
        default=False,
    )
    hold_sharp: BoolProperty(
        name="Hold Sharp Edges",
        description="Vertices of edges that are marked sharp stay where they are",
        default=False,
    )
    from_original: BoolProperty(
        name="From Original",
        description=(
            "Start from the shape before the first run, and discard what the runs have done since; "
            "otherwise start from the shape that is shown"
        ),
        default=False,
    )
    result: EnumProperty(
        name="Result",
        description="What the object gets",
        items=RESULTS,
        default=LIVE,
    )
    output: EnumProperty(
        name="Steps As",
        description="What the object gets",
        items=(
            (
                "ABSOLUTE_KEYS",
                "Evolution",
                "Every step as an absolute shape key: one slider runs through them",
            ),
            (
                "RELATIVE_KEYS",
                "Relative Shape Keys",
                "Every step as a relative shape key",
            ),
            ("FINAL_SHAPE", "Final Shape Only", "Move the vertices; no shape keys"),
        ),
        default="ABSOLUTE_KEYS",
    )
    existing_keys: EnumProperty(
        name="Other Shape Keys",
        description="What to do with an object that has shape keys of its own",
        items=(
            ("COPY", "Work on a Copy", "Leave the object as it is, hide it, and fair a copy"),
            ("REFUSE", "Refuse", "Leave the object as it is and say so"),
        ),
        default="COPY",
    )
    store_density: BoolProperty(
        name="Density Attribute",
        description=(
            "Store the density of the mesh as fairing_density and fairing_density_color; the "
            "paper's methods always do"
        ),
        default=False,
    )


def _set_tau(settings: FairingSceneSettings, context: bpy.types.Context) -> None:
    """Let τ follow the radius on the active mesh, where there is one."""
    is_asked = settings.method != AUTO and context.scene is settings.id_data
    if is_asked and bpy.ops.object.adaptive_fairing_suggest_tau.poll():
        bpy.ops.object.adaptive_fairing_suggest_tau()


class FairingSceneSettings(SolverProperties, OutputProperties, bpy.types.PropertyGroup):
    """What the panel shows, one set per scene."""

    __slots__ = ()  # Blender 5.2 warns of groups without

    radius: FloatProperty(
        name="Radius",
        description=(
            "Wanted smoothing radius in local edge lengths, all steps together: about 1 takes "
            "noise only, 3 and more takes shapes of that size as well"
        ),
        update=_set_tau,
        default=1.5,
        min=0.01,
        soft_min=0.2,
        soft_max=10.0,
        precision=2,
    )
    same_strength: BoolProperty(
        name="Same Strength",
        description="Smooth every frame as the first one, so that nothing flickers",
        default=True,
    )
    frame_start: IntProperty(
        name="From Frame", description="Frame that shows the mesh before the first step", default=1
    )
    frame_end: IntProperty(
        name="To Frame", description="Frame that shows the last step", default=100
    )


SOLVER_NAMES = tuple(SolverProperties.__annotations__)
OUTPUT_NAMES = tuple(OutputProperties.__annotations__)
FAIRING_NAMES = tuple(
    name for name in SOLVER_NAMES if name not in ("strength", "features", "clean")
)
"""Settings of the paper's methods, by their names in `FairingSettings`."""


def names_of(method: str) -> tuple[str, ...]:
    """Names of the settings that a method has, the method itself among them."""
    return ("method", *DENOISE_NAMES) if method == AUTO else FAIRING_NAMES


def solver_settings(properties: SolverProperties) -> DenoiseSettings | FairingSettings:
    """Make the core's settings of the algorithm that was chosen.

    Raises
    ------
    SettingsError
        A value makes no sense, such as τ = 0; or a script has given a setting that belongs to the
        other algorithm.
    """
    from ..core import DenoiseSettings, SettingsError

    names = names_of(properties.method)
    if isinstance(properties, bpy.types.Operator):
        for name in SOLVER_NAMES:
            if properties.properties.is_property_set(name) and name not in names:
                owner = "the paper's methods" if properties.method == AUTO else 'method="auto"'
                raise SettingsError(f"{name} belongs to {owner}, not to {properties.method!r}")
    if properties.method != AUTO:
        return fairing_settings(properties)
    return DenoiseSettings(**{name: _typed(getattr(properties, name)) for name in DENOISE_NAMES})


def fairing_settings(properties: SolverProperties) -> FairingSettings:
    """Make the settings of the paper's methods; beside "auto" those of its default method.

    Raises
    ------
    SettingsError
        A value makes no sense, such as τ = 0.
    """
    from ..core import FairingSettings

    values = {name: _typed(getattr(properties, name)) for name in FAIRING_NAMES}
    if values["method"] == AUTO:
        values["method"] = FALLBACK_METHOD
    for name in ("stop_curvature", "stop_rate"):
        values[name] = values[name] or None
    values["normalize"] = "box" if values["normalize"] else False
    return FairingSettings(**values)


def _typed(value: object) -> object:
    """Give back the number that was typed: Blender keeps float32, which has seven digits."""
    return float(f"{value:.7g}") if isinstance(value, float) else value


def copy_solver(
    source: SolverProperties, target: SolverProperties, method: str | None = None
) -> None:
    """Hand a method, by default the one of the source, and its settings on to a button."""
    copy_settings(source, target, names_of(method or source.method))
    target.method = method or source.method


def copy_settings(source: object, target: object, names: tuple[str, ...]) -> None:
    """Hand the named properties on."""
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
