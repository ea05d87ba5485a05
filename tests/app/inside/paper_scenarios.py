"""Scenarios of the paper's method: keys, undo, Esc, what may happen meanwhile, frames."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator

import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d
from driver import Scenario, Stage
from meshes import (
    add_noisy,
    equal_to_core,
    key_names,
    key_positions,
    shown_evolution,
    vertex_positions,
)
from steps import BUTTON, open_panel, press_fairing, run_to_the_end, shading


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
    settings.steps = stage.results["steps asked for"] = 1000
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


def evolution(stage: Stage) -> Scenario:
    """From a fresh panel to an evolution that plays in colours: three clicks."""
    obj = add_noisy("ico_sphere", 0.02, "DENOISE", subdivisions=5)
    seen, scene = stage.results, bpy.context.scene
    with stage.context():
        bpy.ops.view3d.view_selected()
    yield from stage.open_sidebar("Fairing")
    yield from stage.picture("evolution-fresh")
    doors = yield from stage.find_button("adaptive_fairing.algorithm", "shift+ctrl+c", 0.75)
    yield from stage.point_at_view()
    stage.click(*doors)
    yield 1.0
    seen["algorithm"] = scene.adaptive_fairing.algorithm
    yield from stage.picture("evolution-door")
    yield from stage.click_button(BUTTON)
    yield stage.until(lambda: not stage.is_running(), 120, "end of the run")
    yield 1.0
    yield from stage.picture("evolution-faired")
    yield from stage.click_button("adaptive_fairing_play(", 0.2)
    screen = stage.window.screen
    yield stage.until(lambda: screen.is_animation_playing, 20, "start of the animation")
    seen["view"], seen["shading"] = obj.adaptive_fairing.view, shading(stage)
    shown = set()

    def is_playing() -> bool:
        shown.add(obj.adaptive_fairing.evolution)
        return len(shown) > 3

    yield stage.until(is_playing, 120, "four frames of the evolution")
    for number in (1, 2, 3):
        yield from stage.picture(f"evolution-playing-{number}")
        yield 1.0
    seen["range"] = [scene.frame_preview_start, scene.frame_preview_end, scene.use_preview_range]
    yield from stage.click_button("adaptive_fairing_play_end(", 0.2)
    seen["playing after stop"] = screen.is_animation_playing
    seen["preview after stop"] = scene.use_preview_range
    yield from stage.press_in_view("ctrl+z")
    yield 1.0
    obj = bpy.context.view_layer.objects.active
    seen["keys after undo"] = key_names()
    seen["animated after undo"] = obj.data.shape_keys.animation_data is not None
    seen["view after undo"] = obj.adaptive_fairing.view
    seen["shading after undo"] = shading(stage)


def colors(stage: Stage) -> Scenario:
    """Colours and their material by clicks; undo and redo; an attribute faired by a click."""
    obj = add_noisy("ico_sphere", 0.02, "FAIR", subdivisions=4)
    seen = stage.results
    noisy = obj.data.attributes.new("Scan", "FLOAT_COLOR", "POINT")
    noisy.data.foreach_set("color", np.random.default_rng(2).random(4 * len(noisy.data)))
    obj.data.materials.append(bpy.data.materials.new("Mine"))
    bpy.ops.ed.undo_push(message="Colours and a material")
    with stage.context():
        bpy.ops.view3d.view_selected()
    for panel in ("attribute", "view"):
        open_panel(f"VIEW3D_PT_adaptive_fairing_{panel}")
    yield from stage.open_sidebar("Fairing")
    yield from stage.picture("colors-before")

    def state() -> list[object]:
        obj = bpy.context.view_layer.objects.active
        attributes, slots = obj.data.attributes, obj.material_slots
        material = [slot.material.name for slot in slots]
        return [attributes.active_color_name, obj.adaptive_fairing.view, material, shading(stage)]

    seen["before"] = state()
    yield from stage.click_button("adaptive_fairing_view(field='CURVATURE'", 0.2)
    seen["shown"] = state()
    yield from stage.picture("colors-shown")
    yield from stage.click_button("adaptive_fairing_material(")
    seen["rendered"] = state()
    for key in ("undo", "undo", "redo", "redo"):
        yield from stage.press_in_view({"undo": "ctrl+z", "redo": "ctrl+shift+z"}[key])
        yield 1.0
        seen.setdefault("history", []).append(state())
    yield from stage.click_button("adaptive_fairing_view_end(", 0.2)
    seen["ended"] = state()
    yield from stage.picture("colors-ended")
    stage.view.spaces.active.shading.color_type = "VERTEX"
    yield from stage.picture("colors-noisy")
    yield from stage.click_button("source='COLOR'", 0.4)
    yield from stage.picture("colors-faired")
    obj = bpy.context.view_layer.objects.active
    values = np.empty(4 * len(obj.data.vertices), dtype=np.float32)
    obj.data.attributes["Scan"].data.foreach_get("color", values)
    seen["spread"] = float(values.std())
    yield from stage.press_in_view("ctrl+z")
    yield 1.0
    obj = bpy.context.view_layer.objects.active
    obj.data.attributes["Scan"].data.foreach_get("color", values)
    seen["spread after undo"] = float(values.std())


def delete_one_of_three(stage: Stage) -> Scenario:
    """Delete one of three objects during their run; Ctrl Z brings it back afterwards."""
    add_noisy("ico_sphere", 0.01, "DENOISE", subdivisions=6)
    for name in ("Second", "Third"):
        with stage.context():
            bpy.ops.object.duplicate()
        bpy.context.object.name = name
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.ed.undo_push(message="Three")
    yield from press_fairing(stage)
    for obj in bpy.data.objects:
        obj.select_set(obj.name == "Second")
    with stage.context():
        bpy.ops.object.delete("EXEC_DEFAULT", True)
    yield stage.until(lambda: not stage.is_running(), 200, "end of the run")
    yield 1.0
    stage.results["results"] = _results()
    yield from stage.picture("deleted-one")
    yield from stage.press_in_view("ctrl+z")
    yield 1.0
    stage.results["after one undo"] = _results()
    yield from stage.press_in_view("ctrl+z")
    yield 1.0
    stage.results["after two"] = _results()


def _results() -> dict[str, str]:
    return {obj.name: obj.adaptive_fairing.result for obj in bpy.data.objects}


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


def comparison(stage: Stage) -> Scenario:
    """Copies side by side in the view of a new file, from the button: where they are drawn."""
    add_noisy("ico_sphere", 0.02, subdivisions=4)
    open_panel("VIEW3D_PT_adaptive_fairing_compare")
    yield from stage.open_sidebar("Fairing")
    stage.scroll_down("UI")
    yield 0.5
    yield from stage.click_button("adaptive_fairing_compare(")
    yield stage.until(lambda: not stage.is_running(), 100, "end of the comparison")
    yield 1.0
    yield from stage.picture("comparison")
    names = ["Icosphere", "Icosphere uniform", "Icosphere adaptive"]
    labels = ["Before", "Uniform", "Adaptive"]
    stage.results["boxes"] = [drawn_box(stage, name) for name in names]
    stage.results["labels"] = [drawn_box(stage, name) for name in labels]
    region = stage.region("WINDOW")
    stage.results["size"] = [region.width, region.height]


def drawn_box(stage: Stage, name: str) -> list[list[float]]:
    """Lower left and upper right pixel of an object's vertices in the 3D view."""
    graph = bpy.context.evaluated_depsgraph_get()
    evaluated = bpy.data.objects[name].evaluated_get(graph)
    points = np.array([evaluated.matrix_world @ v.co for v in evaluated.to_mesh().vertices])
    drawn = [
        location_3d_to_region_2d(stage.region("WINDOW"), stage.view.spaces.active.region_3d, each)
        for each in points
    ]
    return [np.min(drawn, axis=0).tolist(), np.max(drawn, axis=0).tolist()]
