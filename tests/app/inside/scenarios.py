"""What happens in Blender's window in each test. Runs inside Blender, see driver.py.

Usage: blender --python scenarios.py -- SCENARIO DIRECTORY
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable, Generator
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

sys.path.insert(0, str(Path(__file__).resolve().parent))

from driver import Scenario, Stage, play, xdotool
from meshes import (
    add_noisy,
    equal_to_core,
    key_names,
    key_positions,
    largest_gap,
    shown_evolution,
    shown_positions,
    vertex_positions,
)

BUTTON = "object.adaptive_fairing("  # other operators begin with the same words


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


def full_run(stage: Stage) -> Scenario:
    """Press the button, wait, move the Evolution slider, undo, redo, save and open again."""
    noisy = vertex_positions(add_noisy("ico_sphere", 0.01, subdivisions=6))
    seen = stage.results
    yield from stage.open_sidebar("Fairing")
    yield from stage.picture("before")
    yield from run_to_the_end(stage, 120)
    yield from stage.picture("after")

    obj = bpy.context.object
    keys = key_positions(obj)
    seen["keys"] = list(keys)
    seen["basis kept"] = bool(np.array_equal(keys["Basis"], noisy))
    seen["equal to core"] = equal_to_core(obj, noisy, list(keys.values())[1:])

    x, y = yield from stage.find_button("adaptive_fairing.evolution", "shift+ctrl+c")
    yield from stage.enter_value(x, y, 0.0)
    yield from stage.picture("slider-at-the-start")
    seen["slider at the start"] = shown_evolution(obj, keys)
    yield from stage.drag(x, y, 70)
    yield from stage.picture("slider-dragged")
    seen["slider dragged"] = shown_evolution(obj, keys)
    yield from stage.enter_value(x, y, 1.0)
    yield from stage.picture("slider-at-the-end")
    seen["slider at the end"] = shown_evolution(obj, keys)

    path = str(stage.directory / "saved.blend")
    with stage.context():
        bpy.ops.wm.save_as_mainfile(filepath=path)
        bpy.ops.wm.open_mainfile(filepath=path)
    yield 2.0
    reopened = key_positions(bpy.context.view_layer.objects.active)
    seen["same after reopening"] = {
        name: bool(np.array_equal(reopened.get(name), positions))
        for name, positions in keys.items()
    }
    yield from stage.picture("reopened")


def undo(stage: Stage) -> Scenario:
    """One undo takes a whole run back, one redo brings it again."""
    noisy = vertex_positions(add_noisy("ico_sphere", 0.01, subdivisions=4))
    yield from run_to_the_end(stage, 60)
    stage.results["after run"] = key_names()
    yield from stage.press_in_view("ctrl+z")
    stage.results["after undo"] = key_names()
    stage.results["vertices back"] = bool(
        np.array_equal(vertex_positions(bpy.context.object), noisy)
    )
    yield from stage.press_in_view("ctrl+shift+z")
    stage.results["after redo"] = key_names()


def escape(stage: Stage) -> Scenario:
    """Press Esc in a long run; the finished steps stay, and one undo removes them."""
    add_noisy("ico_sphere", 0.01, subdivisions=6)
    settings = bpy.context.scene.adaptive_fairing
    settings.steps, settings.tau = 1000, 0.0001
    stage.results["steps asked for"] = settings.steps
    yield from press_fairing(stage)
    yield 6.0
    yield from stage.picture("running")
    yield 4.0
    yield from stage.picture("running-later")
    yield from stage.press_in_view("Escape")
    yield stage.until(lambda: not stage.is_running(), 60, "end after Esc")
    yield 1.0
    yield from stage.picture("stopped")
    stage.results["after escape"] = key_names()
    yield from stage.press_in_view("ctrl+z")
    stage.results["after undo"] = key_names()


def automatic(stage: Stage) -> Scenario:
    """Esc ends a run of Denoise at once; after a whole one the slider, colours and buttons."""
    noisy = vertex_positions(add_noisy("ico_sphere", 0.002, "auto", subdivisions=8))
    yield from press_fairing(stage)
    yield 2.0
    yield from stage.picture("auto-running")
    before = finished_part()
    yield stage.until(lambda: finished_part() > before + 0.05, 120, "progress of the run")
    yield 1.0
    yield from stage.picture("auto-running-later")
    stage.results["running before escape"] = stage.is_running()
    yield from stage.press_in_view("Escape")
    yield stage.until(lambda: not stage.is_running(), 20, "end after Esc")
    left = vertex_positions(bpy.context.object)
    stage.results["unchanged after escape"] = bool(np.array_equal(left, noisy))

    obj = add_noisy("ico_sphere", 0.02, "auto", subdivisions=5)
    noisy = vertex_positions(obj)
    with stage.context():
        bpy.ops.view3d.view_selected()
    yield from stage.picture("auto-before")
    yield from run_to_the_end(stage, 200)
    yield from stage.picture("auto-after")
    denoised = vertex_positions(obj)
    stage.results["moved"] = float(np.abs(denoised - noisy).max())
    slider = 'objects["Icosphere"].adaptive_fairing.strength'
    x, y = yield from stage.find_button(slider, "shift+ctrl+alt+c")
    yield from stage.enter_value(x, y, 0.5)
    half = vertex_positions(obj)
    stage.results["moved at half"] = float(np.abs(half - noisy).max())
    yield from stage.enter_value(x, y, 1.0)
    stage.results["slider back"] = bool(np.array_equal(vertex_positions(obj), denoised))

    yield from stage.point_at_view()
    xdotool("keydown", "alt+b")
    yield 1.0
    stage.results["held"] = bool(np.array_equal(vertex_positions(obj), noisy))
    yield from stage.picture("auto-held")
    xdotool("keyup", "alt+b")
    yield 1.0
    stage.results["released"] = bool(np.array_equal(vertex_positions(obj), denoised))

    yield from stage.click_button("adaptive_fairing_split(")
    kept = (vertex_positions(obj) == noisy).all(axis=1).mean()
    stage.results["original in the split"] = float(kept)
    yield from stage.picture("auto-split")
    yield from stage.click_button("adaptive_fairing_split(")
    with stage.context():
        bpy.ops.object.adaptive_fairing_view(field="REMOVED")
    yield 1.0
    yield from stage.picture("auto-removed")
    stage.results["active colour"] = obj.data.attributes.active_color_name
    yield from stage.click_button("adaptive_fairing_discard(")
    stage.results["discarded"] = bool(np.array_equal(vertex_positions(obj), noisy))
    names = [name for name in obj.data.attributes.keys() if name.startswith("fairing")]
    stage.results["attributes left"] = names


def walk(stage: Stage) -> Scenario:
    """A new user: scan in, one press, slide, paint the nose back, apply, export, import again."""
    seen = stage.results
    scan = stage.directory / "scan.ply"
    with stage.context():
        to_viewer = bpy.context.region_data.view_rotation @ Vector((0.0, 0.0, 1.0))
        add_noisy("ico_sphere", 0.02, "auto", subdivisions=5, nose=to_viewer)
        bpy.ops.wm.ply_export(filepath=str(scan), export_uv=False)
        bpy.ops.object.delete()
        started = time.monotonic()
        bpy.ops.wm.ply_import(filepath=str(scan))
        bpy.ops.view3d.view_selected()
    obj = bpy.context.object
    noisy = vertex_positions(obj)
    yield from stage.open_sidebar("Fairing")
    yield from stage.picture("walk-scan")
    yield from run_to_the_end(stage, 200)
    slider = 'objects["scan"].adaptive_fairing.strength'
    x, y = yield from stage.find_button(slider, "shift+ctrl+alt+c")
    yield from stage.enter_value(x, y, 0.9)
    faired = vertex_positions(obj)
    seen["moved"] = float(np.abs(faired - noisy).max())
    yield from stage.picture("walk-faired")

    yield from stage.click_button("adaptive_fairing_paint(", 0.85)
    seen["mode"] = obj.mode
    take_brush(stage)
    x, y = stage.middle("WINDOW")
    for across in range(-40, 41, 20):
        yield from stage.drag(x - 40, y + across, 80)
    yield 1.0
    yield from stage.picture("walk-painted")
    yield from stage.click_button("adaptive_fairing_paint(", 0.85)
    seen["mode after"] = obj.mode
    weights = np.array([obj.vertex_groups["Fairing"].weight(i) for i in range(len(noisy))])
    painted = vertex_positions(obj)
    is_nose = noisy @ to_viewer > 1.25
    seen["nose back"] = bool(np.array_equal(painted[is_nose], noisy[is_nose]))
    seen["painted"] = float((weights < 1).mean())
    seen["rest faired"] = bool(np.array_equal(painted[weights == 1], faired[weights == 1]))

    yield from stage.click_button("adaptive_fairing_apply(", 0.3)
    seen["result left"] = obj.adaptive_fairing.result
    seen["shape kept"] = bool(np.array_equal(vertex_positions(obj), painted))
    yield from stage.picture("walk-applied")
    with stage.context():
        bpy.ops.wm.stl_export(filepath=str(stage.directory / "faired.stl"))
        bpy.ops.export_scene.gltf(filepath=str(stage.directory / "faired.glb"))
        seen["seconds"] = time.monotonic() - started
        bpy.ops.object.select_all(action="SELECT")
        bpy.ops.object.delete()
        bpy.ops.wm.stl_import(filepath=str(stage.directory / "faired.stl"))
        seen["stl"] = largest_gap(bpy.context.object, painted)
        bpy.ops.object.delete()
        bpy.ops.import_scene.gltf(filepath=str(stage.directory / "faired.glb"))
        (imported,) = [each for each in bpy.data.objects if each.type == "MESH"]
        seen["glb"] = largest_gap(imported, painted)


def take_brush(stage: Stage) -> None:
    """Take a brush with a hard edge in Weight Paint: Debian's Blender 4.3 comes without brushes."""
    brush = bpy.data.brushes.new("Hard", mode="WEIGHT_PAINT")
    names = ("curve_distance_falloff_preset", "curve_preset")  # since Blender 5.0, before
    setattr(brush, next(name for name in names if hasattr(brush, name)), "CONSTANT")
    brush.asset_mark()
    with stage.context():
        bpy.ops.brush.asset_activate(
            asset_library_type="LOCAL", relative_asset_identifier="Brush/Hard"
        )


def modifier(stage: Stage) -> Scenario:
    """The result as a modifier: slider, split, Ctrl Z, Discard."""
    seen = stage.results
    obj = add_noisy("ico_sphere", 0.02, "auto", subdivisions=5)
    bpy.context.scene.adaptive_fairing.result = "MODIFIER"
    noisy = vertex_positions(obj)
    with stage.context():
        bpy.ops.view3d.view_selected()
    yield from run_to_the_end(stage, 200)
    denoised = shown_positions(obj)
    seen["mesh stays"] = bool(np.array_equal(vertex_positions(obj), noisy))
    seen["moved"] = float(np.abs(denoised - noisy).max())
    yield from stage.picture("modifier-after")
    x, y = yield from stage.find_button(
        'objects["Icosphere"].adaptive_fairing.strength', "shift+ctrl+alt+c"
    )
    yield from stage.enter_value(x, y, 0.5)
    seen["moved at half"] = float(np.abs(shown_positions(obj) - noisy).max())
    yield from stage.enter_value(x, y, 1.0)
    yield from stage.click_button("adaptive_fairing_split(")
    shown = shown_positions(obj)
    seen["original in the split"] = float((shown == noisy).all(axis=1).mean())
    seen["modifiers in the split"] = obj.modifiers.keys()
    yield from stage.picture("modifier-split")
    yield from stage.press_in_view("ctrl+z")
    yield 1.0
    obj = bpy.context.view_layer.objects.active
    seen["modifiers after undo"] = obj.modifiers.keys()
    yield from stage.click_button("adaptive_fairing_discard(")
    obj = bpy.context.view_layer.objects.active
    seen["discarded"] = bool(np.array_equal(shown_positions(obj), noisy))
    seen["modifiers left"] = obj.modifiers.keys()


def mask_back(stage: Stage) -> Scenario:
    """In Sculpt Mode: the slider, the original back where the mask is, and one Ctrl Z."""
    seen = stage.results
    obj = add_noisy("ico_sphere", 0.02, "auto", subdivisions=5)
    noisy = vertex_positions(obj)
    with stage.context():
        bpy.ops.view3d.view_selected()
    yield from run_to_the_end(stage, 200)
    denoised = vertex_positions(obj)
    is_masked = noisy[:, 2] > 0
    mask = obj.data.attributes.new(".sculpt_mask", "FLOAT", "POINT")
    mask.data.foreach_set("value", is_masked.astype(np.float32))
    with stage.context():
        bpy.ops.object.mode_set("EXEC_DEFAULT", True, mode="SCULPT")
    yield 1.0
    slider = 'objects["Icosphere"].adaptive_fairing.strength'
    x, y = yield from stage.find_button(slider, "shift+ctrl+alt+c")
    yield from stage.enter_value(x, y, 0.5)
    half = vertex_positions(obj)
    seen["moved at half"] = float(np.abs(half - noisy).max())
    yield from stage.enter_value(x, y, 1.0)
    seen["moved"] = float(np.abs(vertex_positions(obj) - noisy).max())
    yield from stage.click_button("adaptive_fairing_paint(", 0.85)
    seen["mode"] = obj.mode
    found = vertex_positions(obj)
    seen["masked"] = bool(np.array_equal(found[is_masked], noisy[is_masked]))
    seen["rest"] = bool(np.array_equal(found[~is_masked], denoised[~is_masked]))
    yield from stage.picture("mask-back")
    yield from stage.press_in_view("ctrl+z")
    yield 1.0
    obj = bpy.context.view_layer.objects.active
    seen["after undo"] = {
        "mode": obj.mode,
        "same": bool(np.array_equal(vertex_positions(obj), denoised)),
        "mask": obj.data.attributes[".sculpt_mask"].data[int(is_masked.argmax())].value,
    }


def question(stage: Stage) -> Scenario:
    """With undo turned off a run is asked for, and starts with the answer."""
    seen = stage.results
    add_noisy("ico_sphere", 0.02, "auto", subdivisions=5)
    bpy.context.preferences.edit.use_global_undo = False
    yield from stage.open_sidebar("Fairing")
    yield from stage.picture("question-before")
    yield from stage.click_button(BUTTON)
    seen["running without an answer"] = stage.is_running()
    yield from stage.picture("question-asked")
    stage.press("Escape")
    yield 1.0
    seen["running after Esc"] = stage.is_running()
    yield from stage.click_button(BUTTON)
    stage.press("Down", "Return")
    yield stage.until(stage.is_running, 20, "start after the answer")
    yield stage.until(lambda: not stage.is_running(), 200, "end of the run")
    yield 1.0
    seen["result"] = bpy.context.object.adaptive_fairing.result


def refined_surface(stage: Stage) -> Scenario:
    """Choose a refined surface in the panel; the slider, undo, a view and Discard work on it."""
    obj = add_noisy("ico_sphere", 0.05, "auto", subdivisions=4)
    noisy = vertex_positions(obj)
    with stage.context():
        bpy.ops.view3d.view_selected()
    yield from run_to_the_end(stage, 100)
    yield from stage.picture("surface-control")
    denoised = vertex_positions(obj)
    x, y = yield from stage.find_button("adaptive_fairing_discard(")
    row = int(24 * bpy.context.preferences.system.ui_scale)  # the menu is in the row above
    yield from stage.point_at_view()
    stage.point(x, y + row)
    yield 0.5
    stage.click(x, y + row)
    yield 1.0
    yield from stage.picture("surface-menu")
    stage.press("4")  # Blender's menus take the number of an entry
    yield 2.0
    stage.results["triangles"] = len(obj.data.polygons)
    stage.results["surface"] = obj.adaptive_fairing.surface
    refined = vertex_positions(obj)
    yield from stage.picture("surface-refined")

    slider = 'objects["Icosphere"].adaptive_fairing.strength'
    x, y = yield from stage.find_button(slider, "shift+ctrl+alt+c")
    yield from stage.enter_value(x, y, 0.0)
    original = vertex_positions(obj)
    yield from stage.picture("surface-original")
    yield from stage.drag(x, y, 40)
    dragged = obj.adaptive_fairing.strength
    stage.results["strength dragged"] = dragged
    stage.results["moved when dragged"] = float(np.abs(vertex_positions(obj) - original).max())
    yield from stage.enter_value(x, y, 1.0)
    difference = np.abs(vertex_positions(obj) - refined).max()
    stage.results["slider back"] = bool(difference == 0.0)
    with stage.context():
        bpy.ops.object.adaptive_fairing_view(field="CURVATURE")
    yield 1.0
    yield from stage.picture("surface-curvature")
    with stage.context():
        bpy.ops.object.adaptive_fairing_view_end()
        bpy.ops.ed.undo_push(message="view ended")

    with stage.context():
        bpy.ops.object.adaptive_fairing_surface("EXEC_DEFAULT", True, surface="CONTROL")
    yield 1.0
    stage.results["back"] = bool(np.array_equal(vertex_positions(obj), denoised))
    yield from stage.press_in_view("ctrl+z")
    yield 1.0
    obj = bpy.context.object
    stage.results["refined after undo"] = bool(np.array_equal(vertex_positions(obj), refined))
    x, y = yield from stage.find_button("adaptive_fairing_discard(")
    yield from stage.point_at_view()
    stage.click(x, y)
    yield 1.0
    obj = bpy.context.object
    stage.results["discarded"] = bool(np.array_equal(vertex_positions(obj), noisy))
    yield from stage.picture("surface-discarded")


def undo_in_modes(stage: Stage) -> Scenario:
    """One Ctrl Z takes a run back in every mode, and leaves the mode and the mask."""
    for mode in ("OBJECT", "EDIT", "SCULPT"):
        noisy = vertex_positions(add_noisy("ico_sphere", 0.02, "auto", subdivisions=4))
        with stage.context():
            if mode != "OBJECT":
                bpy.ops.object.mode_set("EXEC_DEFAULT", True, mode=mode)
            if mode == "SCULPT":
                for value in (0.25, 0.5):
                    bpy.ops.paint.mask_flood_fill("EXEC_DEFAULT", True, mode="VALUE", value=value)
        yield 0.5
        yield from run_to_the_end(stage, 60)
        after_run = present_state(noisy)
        yield from stage.press_in_view("ctrl+z")
        yield 1.0
        stage.results[mode] = {"after run": after_run, "after undo": present_state(noisy)}
        with stage.context():
            if bpy.context.object.mode != "OBJECT":
                bpy.ops.object.mode_set(mode="OBJECT")


def present_state(noisy: np.ndarray) -> dict:
    """Mode and mask of the active object, how far it is from the noisy one, what runs left."""
    obj = bpy.context.view_layer.objects.active
    if obj.mode == "EDIT":
        obj.update_from_editmode()
    mask = obj.data.attributes.get(".sculpt_mask")
    return {
        "mode": obj.mode,
        "moved": float(np.abs(vertex_positions(obj) - noisy).max()),
        "mask": None if mask is None else mask.data[0].value,
        "result": obj.adaptive_fairing.result if obj.mode != "EDIT" else "",
    }


def delete_object(stage: Stage) -> Scenario:
    """Delete the object while it is being faired; afterwards another one can be faired."""
    obj = add_noisy("ico_sphere", 0.01, subdivisions=6)
    bpy.context.scene.adaptive_fairing.steps = 1000
    yield from press_fairing(stage)
    yield 2.0
    bpy.data.objects.remove(obj)
    yield 2.0
    yield from stage.picture("deleted")
    if stage.is_running():
        yield from stage.press_in_view("Escape")
    yield stage.until(lambda: not stage.is_running(), 60, "end without the object")
    yield from run_once_more(stage)


def load_file(stage: Stage) -> Scenario:
    """Load a new file during a run; afterwards another mesh can be faired."""
    add_noisy("ico_sphere", 0.01, subdivisions=6)
    bpy.context.scene.adaptive_fairing.steps = 1000
    yield from press_fairing(stage)
    yield 2.0
    with stage.context():
        bpy.ops.wm.read_homefile()
    yield 3.0
    stage.results["running after load"] = stage.is_running()
    stage.results["objects after load"] = sorted(obj.name for obj in bpy.data.objects)
    stage.results["keys in the loaded file"] = len(bpy.data.shape_keys)
    yield from stage.picture("loaded")
    yield from run_once_more(stage)


def run_once_more(stage: Stage) -> Scenario:
    """Fair another mesh, to see that the add-on is still in order."""
    add_noisy("ico_sphere", 0.01, subdivisions=3)
    bpy.context.scene.adaptive_fairing.steps = 2
    yield 1.0
    yield from run_to_the_end(stage, 60)
    stage.results["second run"] = key_names()


def quit_program(stage: Stage) -> Scenario:
    """Quit Blender during a run."""
    add_noisy("ico_sphere", 0.01, subdivisions=6)
    bpy.context.scene.adaptive_fairing.steps = 1000
    yield from press_fairing(stage)
    yield 2.0
    stage.results["running at the end"] = stage.is_running()


def sequence(stage: Stage) -> Scenario:
    """Press the button for frames; Esc in a second run keeps the frames that are finished."""
    obj = add_noisy("ico_sphere", 0.01, subdivisions=5)
    wave = obj.modifiers.new("Wave", "WAVE")
    wave.height, wave.width, wave.narrowness, wave.time_offset = 0.3, 1.0, 2.0, -20
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, 5
    scene.adaptive_fairing.steps = 2
    open_panel("VIEW3D_PT_adaptive_fairing_sequence")
    yield from stage.open_sidebar("Fairing")
    x, y = yield from stage.find_button("object.adaptive_fairing_sequence(")
    yield from stage.picture("sequence-before")
    stage.click(x, y)
    yield stage.until(stage.is_running, 20, "start of the modal run")
    yield from stage.picture("sequence-running")
    yield stage.until(lambda: not stage.is_running(), 120, "end of the run")
    yield 1.0
    result = bpy.context.object
    stage.results["result"] = result.name
    stage.results["keys"] = key_names()
    stage.results["hidden"] = not obj.visible_get()
    stage.results["eval_time"] = []
    for frame in range(1, 6):
        scene.frame_set(frame)
        stage.results["eval_time"].append(result.data.shape_keys.eval_time)
    stage.results["frames of the keys"] = [key.frame for key in result.data.shape_keys.key_blocks]
    yield from stage.picture("sequence-after")
    yield from stage.press_in_view("ctrl+z")
    stage.results["after undo"] = sorted(each.name for each in bpy.data.objects)

    obj = bpy.data.objects[0]
    bpy.context.view_layer.objects.active = obj
    scene = bpy.context.scene
    scene.frame_end = 200
    x, y = yield from stage.find_button("object.adaptive_fairing_sequence(")
    stage.click(x, y)
    yield stage.until(stage.is_running, 60, "start of the second run")
    yield 3.0
    yield from stage.press_in_view("Escape")
    yield stage.until(lambda: not stage.is_running(), 60, "end after Esc")
    yield 1.0
    stage.results["kept after escape"] = key_names()


def languages(stage: Stage) -> Scenario:
    """Show every panel in other languages, before and after runs of both kinds."""
    view = bpy.context.preferences.view
    for panel in ("options", "advanced", "animation", "view", "statistics", "compare", "sequence"):
        open_panel(f"VIEW3D_PT_adaptive_fairing_{panel}")
    for language in ("de_DE", "es"):
        view.language = language
        view.use_translate_interface = True
        translated = bpy.app.translations.pgettext
        stage.results[language] = [translated("Paint Back", each) for each in ("*", "Operator")]
        for method in ("auto", "adaptive_timestep"):
            add_noisy("ico_sphere", 0.02, method, subdivisions=4)
            yield from stage.open_sidebar("Fairing")
            yield 0.5
            yield from stage.picture(f"{language}-{method}-before")
            with stage.context():
                bpy.ops.object.adaptive_fairing(method=method)
            yield 0.5
            yield from stage.picture(f"{language}-{method}-after")
            stage.scroll_down("UI")
            yield 0.5
            yield from stage.picture(f"{language}-{method}-below")


def manual(stage: Stage) -> Scenario:
    """Take the pictures of assets/screenshots, with the sample head."""
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    assets = Path(__file__).resolve().parents[3] / "assets"
    bpy.context.preferences.system.viewport_aa = "8"
    with stage.context():
        bpy.ops.wm.ply_import(filepath=str(assets / "head_noisy.ply"))
        bpy.ops.view3d.view_selected()
    obj = bpy.context.object
    yield from stage.open_sidebar("Fairing")
    yield from stage.picture("before")
    yield from press_fairing(stage)
    yield stage.until(lambda: finished_part() > 0.3, 120, "progress of the run")
    yield from stage.picture("running")
    yield stage.until(lambda: not stage.is_running(), 120, "end of the run")
    yield from stage.point_at_view()
    yield 1.0
    yield from stage.picture("after")
    with stage.context():
        bpy.ops.object.adaptive_fairing_split()
    yield from stage.picture("split")
    with stage.context():
        bpy.ops.object.adaptive_fairing_split()
        bpy.ops.object.adaptive_fairing_view(field="REMOVED")
    yield from stage.picture("removed")
    stage.results["shows"] = obj.adaptive_fairing.view
    with stage.context():
        bpy.ops.object.adaptive_fairing_view_end()
        bpy.ops.object.adaptive_fairing_paint()
    positions = vertex_positions(obj)
    nose = positions[positions[:, 1].argmin()]
    distance = np.linalg.norm(positions - nose, axis=1) / np.ptp(positions[:, 2])
    for index in np.flatnonzero(distance < 0.14):
        weight = float(np.clip((distance[index] - 0.1) / 0.04, 0, 1))
        obj.vertex_groups["Fairing"].add([int(index)], weight, "REPLACE")
    obj.data.update()
    yield 1.0
    yield from stage.picture("paint")
    with stage.context():
        bpy.ops.object.adaptive_fairing_paint()
        bpy.ops.object.adaptive_fairing_discard()
        bpy.ops.object.adaptive_fairing(result="MODIFIER")  # what the run found is still known
    for area in stage.window.screen.areas:
        if area.type == "PROPERTIES":
            area.spaces.active.context = "MODIFIER"
    yield 1.0
    yield from stage.picture("modifier")
    open_panel("VIEW3D_PT_adaptive_fairing_statistics")
    yield 1.0
    yield from stage.picture("statistics")
    parts = {"modifier": "1260x655+340+81", "statistics": "982x720+340+81"}
    for name in stage.pictures:
        path = stage.directory / f"{name}.png"
        part = ["-crop", parts.get(name, "982x655+340+81"), "+repage", "-resize", "748x"]
        subprocess.run(["convert", path, *part, path.with_name(f"manual-{name}.png")], check=True)


def open_panel(panel: str) -> None:
    """Open a panel that is closed at first, as a click on its header would."""
    panel_class = getattr(bpy.types, panel)
    bpy.utils.unregister_class(panel_class)
    panel_class.bl_options = set()
    panel_class.bl_idname = f"{panel}_open"  # Blender remembers which panels are closed
    bpy.utils.register_class(panel_class)


def large_mesh(stage: Stage) -> Scenario:
    """Fair 200 000 triangles, and count how often the window is drawn meanwhile."""
    obj = add_noisy("grid", 0.0005, x_subdivisions=320, y_subdivisions=320)
    obj.data.calc_loop_triangles()
    stage.results["triangles"] = len(obj.data.loop_triangles)
    yield from stage.open_sidebar("Fairing")
    idle_until = time.monotonic() + 5.0
    stage.results["idle"] = yield from draws_while(
        stage, lambda: time.monotonic() < idle_until, seconds=60
    )

    yield from press_fairing(stage)
    stage.results["run"] = yield from draws_while(stage, stage.is_running, 400)
    yield 2.0
    stage.results["keys"] = key_names()
    yield from stage.picture("large-after")


def draws_while(
    stage: Stage, running: Callable[[], bool], seconds: float
) -> Generator[float, None, dict]:
    """Ask for a drawing at every tick while `running`, and measure how many there are."""
    stage.draws.clear()
    start = time.monotonic()
    while running():
        if time.monotonic() - start > seconds:
            raise TimeoutError(f"still running after {seconds} s")
        stage.view.tag_redraw()
        yield 0.0
    times = np.array([start, *stage.draws, time.monotonic()])
    return {
        "seconds": float(times[-1] - start),
        "draws": len(stage.draws),
        "longest gap": float(np.diff(times).max()),
    }


if __name__ == "__main__":
    name, directory = sys.argv[sys.argv.index("--") + 1 :]
    play(globals()[name], Path(directory))
