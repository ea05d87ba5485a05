"""Steps that several scenarios take. Runs inside Blender."""

from __future__ import annotations

import sys
from collections.abc import Generator

import bpy
from driver import Scenario, Stage
from meshes import add_noisy

BUTTON = "object.adaptive_fairing("  # other operators begin with the same words


def add_in_view(stage: Stage, noise: float, subdivisions: int) -> bpy.types.Object:
    """Add a noisy sphere for Denoise that fills the view."""
    obj = add_noisy("ico_sphere", noise, "DENOISE", subdivisions=subdivisions)
    with stage.context():
        bpy.ops.view3d.view_selected()
    return obj


def find_strength(stage: Stage) -> Generator[float, None, tuple]:
    """Find the slider of that sphere's strength."""
    slider = 'objects["Icosphere"].adaptive_fairing.strength'
    return (yield from stage.find_button(slider, "shift+ctrl+alt+c"))


def press_fairing(stage: Stage) -> Scenario:
    """Open the sidebar's tab, look for the button and press it."""
    yield from stage.open_sidebar("Fairing")
    x, y = yield from stage.find_button(BUTTON)
    stage.click(x, y)
    yield stage.until(stage.is_running, 20, "start of the modal run")


def finished_part() -> float:
    """Part of the run that is done, 1 if there is none."""
    (module,) = (each for name, each in sys.modules.items() if name.endswith(".modal_run"))
    progress = module.progress()
    return 1.0 if progress is None else progress.factor


def run_to_the_end(stage: Stage, seconds: float) -> Scenario:
    """Press the button and wait for the result, so many seconds at most."""
    yield from press_fairing(stage)
    yield stage.until(lambda: not stage.is_running(), seconds, "end of the run")
    yield 1.0


def shading(stage: Stage) -> list[str]:
    """How the 3D view draws: its type, where colours are from, its light."""
    shown = stage.view.spaces.active.shading
    return [shown.type, shown.color_type, shown.light]


def take_brush(stage: Stage, mode: str = "WEIGHT_PAINT") -> None:
    """Take a brush with a hard edge in a mode: Debian's Blender 4.3 comes without brushes."""
    brush = bpy.data.brushes.new("Hard", mode=mode)
    names = ("curve_distance_falloff_preset", "curve_preset")  # since Blender 5.0, before
    setattr(brush, next(name for name in names if hasattr(brush, name)), "CONSTANT")
    brush.asset_mark()
    with stage.context():
        bpy.ops.brush.asset_activate(
            asset_library_type="LOCAL", relative_asset_identifier="Brush/Hard"
        )


def open_panel(panel: str, is_open: bool = True) -> None:
    """Open a panel that is closed at first, or close it again, as a click on its header would."""
    (panel_class,) = [each for each in bpy.types.Panel.__subclasses__() if each.__name__ == panel]
    bpy.utils.unregister_class(panel_class)
    panel_class.bl_options = set() if is_open else {"DEFAULT_CLOSED"}
    # Blender remembers of a name whether its panel is closed.
    panel_class.bl_idname = f"{panel}_{'open' if is_open else 'closed'}"
    bpy.utils.register_class(panel_class)
