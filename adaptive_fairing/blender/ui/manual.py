"""Links from buttons and fields to the manual, for Blender's *Online Manual*.

The manual has no address of its own yet. Until it has one, `MANUAL` is the listing's page, and the
part after the ``#`` only names the place; with the address of the manual the links lead there.
"""

from __future__ import annotations

import bpy

MANUAL = "https://extensions.blender.org/add-ons/adaptive-fairing/#"
"""Address before every place: the website of the manifest, or that of the published ``site/``."""

OPERATORS = {
    "": "clean-a-scan/#remove-the-noise",
    "_brush": "keep-a-region/#under-the-brush",
    "_check": "clean-a-scan/#look-before-you-denoise",
    "_stop": "clean-a-scan/#remove-the-noise",
    "_before": "clean-a-scan/#look-at-the-difference",
    "_split": "clean-a-scan/#look-at-the-difference",
    "_paint": "clean-a-scan/#bring-details-back",
    "_paint_swap": "clean-a-scan/#bring-details-back",
    "_apply": "clean-a-scan/#keep-it-or-not",
    "_discard": "clean-a-scan/#keep-it-or-not",
    "_forget": "clean-a-scan/#keep-it-or-not",
    "_take_keys": "clean-a-scan/#keep-it-or-not",
    "_slide": "clean-a-scan/#choose-the-strength",
    "_surface": "surface/#show-a-result-on-it",
    "_loop_subdivide": "surface/#refine-without-denoising",
    "_select_problems": "troubleshooting/#the-result",
    "_view": "colours/#what-the-colours-mean",
    "_view_end": "colours/#what-the-colours-mean",
    "_attribute": "colours/#fair-what-the-mesh-carries",
    "_material": "colours/#render-the-colours",
    "_material_end": "colours/#render-the-colours",
    "_sequence": "sequences/#in-blender",
    "_measure": "settings/#τ-and-the-smoothing-radius",
    "_play": "settings/#result",
    "_play_end": "settings/#result",
    "_animate": "settings/#result",
    "_animate_clear": "settings/#result",
    "_compare": "settings/#result",
    "_preset_add": "settings/#presets",
}
"""Place of an operator, by the part of its name after ``object.adaptive_fairing``."""

SETTINGS = {
    "algorithm": "settings/#method",
    "scheme": "settings/#method",
    "strength": "clean-a-scan/#choose-the-strength",
    "features": "hard-surface/#edges",
    "clean": "denoise/#clean-models-are-left-alone",
    "width": "denoise/#noise-of-a-size-that-you-know",
    "tau": "settings/#τ-and-the-smoothing-radius",
    "use_tau": "settings/#τ-and-the-smoothing-radius",
    "radius": "settings/#τ-and-the-smoothing-radius",
    "steps": "settings/#steps",
    "density": "settings/#density",
    "density_passes": "settings/#density",
    "keep_volume": "settings/#volume-and-deviation",
    "max_deviation": "settings/#volume-and-deviation",
    "boundary": "keep-a-region/#boundary-of-open-meshes",
    "stop_curvature": "settings/#stopping",
    "stop_rate": "settings/#stopping",
    "cg_tolerance": "settings/#accuracy",
    "cg_max_iterations": "settings/#accuracy",
    "quadrature_tolerance": "settings/#accuracy",
    "normalize": "settings/#accuracy",
    "use_region": "keep-a-region/#before-a-run",
    "vertex_group": "keep-a-region/#before-a-run",
    "invert_vertex_group": "keep-a-region/#before-a-run",
    "hold_sharp": "keep-a-region/#before-a-run",
    "from_original": "clean-a-scan/#other-kinds-of-result",
    "result": "clean-a-scan/#other-kinds-of-result",
    "output": "settings/#result",
    "existing_keys": "settings/#result",
    "store_density": "colours/#what-the-colours-mean",
    "show_energy": "settings/#result",
    "same_strength": "sequences/#in-blender",
    "frame_start": "settings/#result",
    "frame_end": "settings/#result",
}
"""Place of a setting of the panel."""

RECORD = {
    "strength": "clean-a-scan/#choose-the-strength",
    "evolution": "settings/#result",
    "swatch_*": "colours/#what-the-colours-mean",
}
"""Place of a value of a result in the panel."""

PREFERENCES = dict.fromkeys(("algorithm", "result", "threads"), "clean-a-scan/#preferences")
"""Place of a preference of the add-on."""


def manual_pages() -> tuple[str, tuple[tuple[str, str], ...]]:
    """Places in the manual for Blender: patterns of names in lower case, each with its place."""
    names = {f"bpy.ops.object.adaptive_fairing{name}": place for name, place in OPERATORS.items()}
    for owner, places in (
        ("fairingscenesettings", SETTINGS),
        ("fairingrecord", RECORD),
        ("fairingpreferences", PREFERENCES),
    ):
        names |= {f"bpy.types.{owner}.{name}": place for name, place in places.items()}
    return MANUAL, tuple(names.items())


def register() -> None:
    """Add the links to the manual."""
    bpy.utils.register_manual_map(manual_pages)


def unregister() -> None:
    """Unregister everything that `register` has added."""
    bpy.utils.unregister_manual_map(manual_pages)
