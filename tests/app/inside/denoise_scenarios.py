"""Scenarios of Denoise: what is done with its result in every mode."""

from __future__ import annotations

import bpy
import numpy as np
from driver import Scenario, Stage, xdotool
from meshes import add_noisy, shown_positions, vertex_positions
from steps import BUTTON, finished_part, press_fairing, run_to_the_end, shading


def automatic(stage: Stage) -> Scenario:
    """Esc ends a run of Denoise at once; after a whole one the slider, colours and buttons."""
    noisy = vertex_positions(add_noisy("ico_sphere", 0.002, "DENOISE", subdivisions=8))
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

    obj = add_noisy("ico_sphere", 0.02, "DENOISE", subdivisions=5)
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
    stage.results["active colour left"] = obj.data.attributes.active_color_name
    stage.results["shading left"] = shading(stage)
    stage.results["discarded"] = bool(np.array_equal(vertex_positions(obj), noisy))
    names = [name for name in obj.data.attributes.keys() if "fairing" in name]
    stage.results["attributes left"] = names


def modifier(stage: Stage) -> Scenario:
    """The result as a modifier: slider, split, Ctrl Z, Discard."""
    seen = stage.results
    obj = add_noisy("ico_sphere", 0.02, "DENOISE", subdivisions=5)
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
    obj = add_noisy("ico_sphere", 0.02, "DENOISE", subdivisions=5)
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
    add_noisy("ico_sphere", 0.02, "DENOISE", subdivisions=5)
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
    obj = add_noisy("ico_sphere", 0.05, "DENOISE", subdivisions=4)
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
        noisy = vertex_positions(add_noisy("ico_sphere", 0.02, "DENOISE", subdivisions=4))
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
