"""Scenarios of a user: from a scan to files, in other languages, for the manual's pictures."""

from __future__ import annotations

import subprocess
import time
from pathlib import Path

import bpy
import numpy as np
from driver import REACTION, Scenario, Stage
from mathutils import Vector
from meshes import add_noisy, largest_gap, vertex_positions
from steps import (
    add_in_view,
    finished_part,
    open_panel,
    press_fairing,
    run_to_the_end,
    take_brush,
)


def walk(stage: Stage) -> Scenario:
    """A new user: scan in, one press, slide, paint the nose back, apply, export, import again."""
    seen = stage.results
    scan = stage.directory / "scan.ply"
    with stage.context():
        to_viewer = bpy.context.region_data.view_rotation @ Vector((0.0, 0.0, 1.0))
        add_noisy("ico_sphere", 0.02, "DENOISE", subdivisions=5, nose=to_viewer)
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


def languages(stage: Stage) -> Scenario:
    """Show every panel in other languages, before and after runs of both kinds."""
    view = bpy.context.preferences.view
    for panel in (
        "options",
        "advanced",
        "animation",
        "check",
        "view",
        "statistics",
        "compare",
        "sequence",
    ):
        open_panel(f"VIEW3D_PT_adaptive_fairing_{panel}")
    for language in ("de_DE", "es"):
        view.language = language
        view.use_translate_interface = True
        translated = bpy.app.translations.pgettext
        stage.results[language] = [translated("Paint Back", each) for each in ("*", "Operator")]
        for algorithm in ("DENOISE", "FAIR"):
            add_noisy("ico_sphere", 0.02, algorithm, subdivisions=4)
            yield from stage.open_sidebar("Fairing")
            yield 0.5
            yield from stage.picture(f"{language}-{algorithm}-before")
            with stage.context():
                bpy.ops.object.adaptive_fairing(algorithm=algorithm)
            yield 0.5
            yield from stage.picture(f"{language}-{algorithm}-after")
            stage.scroll_down("UI")
            yield 0.5
            yield from stage.picture(f"{language}-{algorithm}-below")


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
    open_panel("VIEW3D_PT_adaptive_fairing_statistics", is_open=False)
    with stage.context():
        bpy.ops.object.adaptive_fairing_discard()
        bpy.ops.object.adaptive_fairing(algorithm="FAIR")
        bpy.ops.object.adaptive_fairing_view(field="DENSITY")
    settings = bpy.context.scene.adaptive_fairing
    settings.algorithm, settings.show_energy = "FAIR", True
    yield 1.0
    yield from stage.picture("evolution")
    settings.show_energy = False
    open_panel("VIEW3D_PT_adaptive_fairing_view")
    yield 1.0
    yield from stage.picture("density")
    space = stage.view.spaces.active
    space.overlay.show_overlays = space.show_gizmo = False
    with stage.context():
        bpy.ops.object.adaptive_fairing_discard()
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.object.adaptive_fairing_compare(algorithm="FAIR", tau=0.016)
    yield 1.0
    yield from stage.picture("comparison")
    yield from press_under_the_brush(stage)
    yield from stage.picture("brush")
    parts = {
        "modifier": "1260x655+340+81",
        "statistics": "982x720+340+81",
        "density": "982x820+340+81",
        "comparison": "660x430+225+285",
        "brush": "660x430+225+285",
    }
    for name in stage.pictures:
        path = stage.directory / f"{name}.png"
        width = "374x" if name == "brush" else "748x"  # noise does not compress
        part = ["-crop", parts.get(name, "982x655+340+81"), "+repage", "-resize", width]
        part += ["+dither", "-colors", "160"]  # a third of the size
        subprocess.run(
            ["convert", path, *part, f"PNG8:{path.with_name(f'manual-{name}.png')}"], check=True
        )


def press_under_the_brush(stage: Stage) -> Scenario:
    """Press Alt N in four places of a noisy ball in Sculpt Mode."""
    obj = add_in_view(stage, 0.004, 7)
    with stage.context():
        bpy.ops.object.mode_set(mode="SCULPT")
    tools = bpy.context.tool_settings
    shared = getattr(tools, "unified_paint_settings", None) or tools.sculpt.unified_paint_settings
    shared.use_unified_size, shared.size = True, 50
    x, y = stage.middle("WINDOW")
    for across, up in ((0, 0), (130, 30), (-130, -30), (20, 130)):
        before = vertex_positions(obj)
        stage.point(x + across, y + up)
        yield REACTION
        stage.press("alt+n")
        yield stage.until(
            lambda old=before: (vertex_positions(obj) != old).any(), 60, "result under the brush"
        )
        yield 0.5
