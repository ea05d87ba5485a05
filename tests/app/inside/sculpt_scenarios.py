"""Scenarios of sculpting and painting: mask, history, overlay, brush."""

from __future__ import annotations

import time
from collections.abc import Iterator

import bpy
import numpy as np
from driver import Scenario, Stage
from mathutils import Vector
from meshes import vertex_positions
from steps import (
    add_in_view,
    find_strength,
    run_to_the_end,
    take_brush,
)


def mask_back(stage: Stage) -> Scenario:
    """In Sculpt Mode: the slider, the original back where the mask is, and one Ctrl Z."""
    seen = stage.results
    obj = add_in_view(stage, 0.02, 5)
    noisy = vertex_positions(obj)
    yield from run_to_the_end(stage, 200)
    denoised = vertex_positions(obj)
    is_masked = noisy[:, 2] > 0
    mask = obj.data.attributes.new(".sculpt_mask", "FLOAT", "POINT")
    mask.data.foreach_set("value", is_masked.astype(np.float32))
    with stage.context():
        bpy.ops.object.mode_set("EXEC_DEFAULT", True, mode="SCULPT")
    yield 1.0
    x, y = yield from find_strength(stage)
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


def sculpt_history(stage: Stage) -> Scenario:
    """In Sculpt Mode: a stroke, the slider and Before are a step of the history each."""
    seen = stage.results
    add_in_view(stage, 0.02, 4)
    yield from run_to_the_end(stage, 200)
    states = []

    def look() -> int:
        """Number of the state that is shown, counted from 1; a new one gets the next."""
        obj = bpy.context.view_layer.objects.active
        record = obj.adaptive_fairing
        state = vertex_positions(obj).tobytes(), round(record.strength, 4), record.is_before
        if state not in states:
            states.append(state)
        return states.index(state) + 1

    with stage.context():
        bpy.ops.object.mode_set("EXEC_DEFAULT", True, mode="SCULPT")
    yield 1.0
    seen["forward"] = [look()]
    take_brush(stage, "SCULPT")
    yield 1.0
    yield from stage.drag(*stage.middle("WINDOW"), 60)
    yield 1.0
    seen["forward"].append(look())
    x, y = yield from find_strength(stage)
    yield from stage.enter_value(x, y, 0.5)
    yield 1.0
    seen["forward"].append(look())
    yield from stage.drag(x, y, -30, pause=0.6)
    yield 1.0
    seen["forward"].append(look())
    for name in ("sculpt-history", "sculpt-history-after"):
        yield from stage.click_button("adaptive_fairing_before(", 0.2)
        yield 1.0
        seen["forward"].append(look())
        yield from stage.picture(name)
    for keys, name in (("ctrl+z", "back"), ("shift+ctrl+z", "again")):
        seen[name] = []
        for _ in range(6):
            yield from stage.press_in_view(keys)
            yield 0.5
            seen[name].append(look())
    seen["mode"] = bpy.context.view_layer.objects.active.mode


def painting(stage: Stage) -> Scenario:
    """Paint Back in the window: a faint overlay, the key X, and the end by Tab; then a mask."""
    seen = stage.results
    obj = add_in_view(stage, 0.02, 5)
    overlay = stage.view.spaces.active.overlay
    seen["opacities"] = [overlay.weight_paint_mode_opacity]
    with stage.context():
        bpy.ops.object.adaptive_fairing()
    yield from stage.open_sidebar("Fairing")
    yield from stage.click_button("adaptive_fairing_paint(", 0.85)
    seen["opacities"].append(overlay.weight_paint_mode_opacity)
    weights = weight_paint_weights()
    seen["weights"] = [next(weights)]
    for _ in range(2):
        yield from stage.press_in_view("x")
        seen["weights"].append(next(weights))
        yield from stage.picture(f"painting-{len(seen['weights'])}")
    denoised = vertex_positions(obj)
    x, y = yield from find_strength(stage)
    yield from stage.enter_value(x, y, 0.5)
    yield 1.0

    def state() -> list:
        now = bpy.context.view_layer.objects.active
        is_denoised = bool(np.array_equal(vertex_positions(now), denoised))
        return [now.mode, now.adaptive_fairing.strength, is_denoised]

    seen["typed"] = state()
    yield from stage.press_in_view("ctrl+z")
    yield 1.0
    seen["undone"] = state()
    obj = bpy.context.view_layer.objects.active
    with stage.context():
        bpy.ops.object.mode_set(mode="SCULPT")
        yield 1.0
        seen["opacities"].append(overlay.weight_paint_mode_opacity)
        seen["mask back"] = [bpy.ops.object.adaptive_fairing_paint.poll()]
        bpy.ops.paint.mask_flood_fill(mode="VALUE", value=1.0)
        seen["mask back"].append(bpy.ops.object.adaptive_fairing_paint.poll())
        yield 1.0
        yield from stage.picture("painting-mask")
        bpy.ops.object.mode_set(mode="OBJECT")
    seen["kept"] = obj.adaptive_fairing.result


def weight_paint_weights() -> Iterator[float]:
    """Weight of the brush in Weight Paint, each time it is asked for; Blender 5 moved it."""
    while True:
        tools = bpy.context.tool_settings
        unified = getattr(tools, "unified_paint_settings", None)
        yield (unified or tools.weight_paint.unified_paint_settings).weight


def brush(stage: Stage) -> Scenario:
    """Alt N in Sculpt Mode denoises what is under the pointer; Ctrl Z takes it back."""
    seen = stage.results
    obj = add_in_view(stage, 0.01, 6)
    noisy = vertex_positions(obj)
    with stage.context():
        bpy.ops.object.mode_set(mode="SCULPT")
    tools = bpy.context.tool_settings
    shared = getattr(tools, "unified_paint_settings", None) or tools.sculpt.unified_paint_settings
    shared.use_unified_size, shared.size = True, 100
    yield 1.0
    began = time.monotonic()
    yield from stage.press_in_view("alt+n")
    yield stage.until(lambda: not stage.is_running(), 60, "end of the run")
    seen["seconds"] = time.monotonic() - began
    yield 1.0
    yield from stage.picture("brush-after")
    seen["mode"] = obj.mode
    moved = (vertex_positions(obj) != noisy).any(axis=1)
    seen["moved"] = float(moved.mean())
    view = stage.view.spaces.active.region_3d
    to_viewer = view.view_rotation @ Vector((0.0, 0.0, 1.0))
    seen["in front"] = float((noisy[moved] @ np.array(to_viewer)).min())
    yield from stage.press_in_view("ctrl+z")
    yield 1.0
    obj = bpy.context.object
    seen["after undo"] = [obj.mode, bool(np.array_equal(vertex_positions(obj), noisy))]
