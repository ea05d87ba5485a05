"""Scenarios of Denoise: runs, what is done with their result, Check Mesh."""

from __future__ import annotations

import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d
from driver import Scenario, Stage, xdotool
from meshes import add_noisy, shown_positions, vertex_positions
from steps import (
    BUTTON,
    add_in_view,
    find_strength,
    finished_part,
    open_panel,
    press_fairing,
    run_to_the_end,
    shading,
)


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

    obj = add_in_view(stage, 0.02, 5)
    noisy = vertex_positions(obj)
    yield from stage.picture("auto-before")
    yield from run_to_the_end(stage, 200)
    yield from stage.picture("auto-after")
    denoised = vertex_positions(obj)
    stage.results["moved"] = float(np.abs(denoised - noisy).max())
    x, y = yield from find_strength(stage)
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
    obj = add_in_view(stage, 0.02, 5)
    bpy.context.scene.adaptive_fairing.result = "MODIFIER"
    noisy = vertex_positions(obj)
    yield from run_to_the_end(stage, 200)
    denoised = shown_positions(obj)
    seen["mesh stays"] = bool(np.array_equal(vertex_positions(obj), noisy))
    seen["moved"] = float(np.abs(denoised - noisy).max())
    yield from stage.picture("modifier-after")
    x, y = yield from find_strength(stage)
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
    obj = add_in_view(stage, 0.05, 4)
    noisy = vertex_positions(obj)
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

    x, y = yield from find_strength(stage)
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


def check(stage: Stage) -> Scenario:
    """Check Mesh beside the window; Esc ends it, and another one says what was found."""
    noisy = vertex_positions(add_noisy("ico_sphere", 0.002, "DENOISE", subdivisions=8))
    open_panel("VIEW3D_PT_adaptive_fairing_check")
    yield from stage.open_sidebar("Fairing")
    yield from stage.click_button("adaptive_fairing_check(")
    yield stage.until(stage.is_running, 20, "start of the check")
    yield from stage.picture("check-running")
    yield from stage.press_in_view("Escape")
    yield stage.until(lambda: not stage.is_running(), 30, "end after Esc")
    yield from stage.picture("check-ended")
    left = vertex_positions(bpy.context.object)
    obj = add_noisy("ico_sphere", 0.02, "DENOISE", subdivisions=5)
    noisy = [noisy, vertex_positions(obj)]
    with stage.context():
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="DESELECT")
        bpy.ops.object.mode_set(mode="OBJECT")
        obj.data.polygons[0].select = True
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.delete(type="FACE")
        bpy.ops.object.mode_set(mode="OBJECT")
    yield from stage.click_button("adaptive_fairing_check(")
    yield stage.until(lambda: not stage.is_running(), 60, "end of the check")
    yield 1.0
    yield from stage.picture("check-found")
    after = [left, vertex_positions(obj)]
    stage.results["unchanged"] = [
        bool(np.array_equal(*each)) for each in zip(noisy, after, strict=True)
    ]


def split_line(stage: Stage) -> Scenario:
    """The line of a split: where it is drawn, dragged to the right and back by Ctrl Z.

    Before it the ring of a Noise Size.
    """
    seen = stage.results
    obj = add_in_view(stage, 0.02, 5)
    noisy = vertex_positions(obj)
    yield from stage.open_sidebar("Fairing")
    yield from stage.picture("ring-before")
    for name, size in (("given", 3.0), ("automatic", 0.0)):
        bpy.context.scene.adaptive_fairing.width = size
        yield 1.0  # the mesh is measured after the panel was drawn
        yield from stage.picture(f"ring-{name}")
    with stage.context():
        bpy.ops.object.adaptive_fairing()
    yield from stage.picture("split-before")
    yield from stage.click_button("adaptive_fairing_split(")

    def original() -> float:
        now = vertex_positions(bpy.context.object)
        return float((now == noisy).all(axis=1).mean())

    seen["half"] = original()
    yield from stage.picture("split-half")
    region, view = stage.region("WINDOW"), stage.view.spaces.active.region_3d
    middle = location_3d_to_region_2d(region, view, obj.matrix_world.translation)
    x, y = region.x + int(middle.x), region.y + int(middle.y)
    yield from stage.drag(x, y, 100)
    yield 0.5
    seen["dragged"] = original()
    seen["selected"] = [each.name for each in bpy.context.selected_objects] == [obj.name]
    yield from stage.picture("split-dragged")
    yield from stage.press_in_view("ctrl+z")
    yield 1.0
    seen["after undo"] = original()


def edit_slider(stage: Stage) -> Scenario:
    """In Edit Mode: a run on what is selected, two values of the slider, and a Ctrl Z for each."""
    seen = stage.results
    obj = add_in_view(stage, 0.05, 5)
    noisy = vertex_positions(obj)
    with stage.context():
        bpy.ops.object.mode_set("EXEC_DEFAULT", True, mode="EDIT")
        bpy.ops.mesh.select_all(action="DESELECT")
        bpy.ops.object.mode_set(mode="OBJECT")
        obj.data.vertices.foreach_set("select", noisy[:, 2] > 0)
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.ed.undo_push(message="Select")
    yield 0.5

    def moved() -> float:
        """How far the vertex is from where it was that has gone furthest."""
        edited = bpy.context.view_layer.objects.active
        edited.update_from_editmode()
        copy = edited.data.copy()
        positions = np.empty_like(noisy)
        copy.attributes["position"].data.foreach_get("vector", positions.ravel())
        bpy.data.meshes.remove(copy)
        return float(np.abs(positions - noisy).max())

    yield from run_to_the_end(stage, 100)
    seen["moved"] = moved()
    yield from stage.picture("edit-after")
    x, y = yield from find_strength(stage)
    yield from stage.enter_value(x, y, 0.5)
    yield 1.0
    seen["moved at half"] = moved()
    yield from stage.enter_value(x, y, 0.25)
    yield 1.0
    seen["moved at a quarter"] = moved()
    seen["mode"] = obj.mode
    yield from stage.picture("edit-quarter")
    for name in ("half", "whole"):
        yield from stage.press_in_view("ctrl+z")
        yield 1.0
        seen[f"undone to {name}"] = moved()
    record = bpy.context.view_layer.objects.active.adaptive_fairing
    seen["strength"], seen["mode after"] = record.strength, record.id_data.mode
