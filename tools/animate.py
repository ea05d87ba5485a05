"""Film the head while it is faired, uniform beside adaptive timesteps, from its shape keys.

Run `python tools/animate.py [-o FILE.gif]`. Blender renders every frame, and Pillow puts them
together.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector
from PIL import Image

from adaptive_fairing.blender.data.shape_keys import animate_evolution, write_absolute_keys
from adaptive_fairing.core import fair
from claims.measures import TIMESTEP_AREA, UNIFORM, Scheme, matched_tau
from claims.pairs import MeshPair, sample_pair
from render import Look, View, add_camera, add_lights, add_mesh, clay, set_up

OUTPUT = Path(__file__).resolve().parent.parent / "assets" / "figures" / "evolution.gif"

SIDES = {"uniform timestep": UNIFORM, "adaptive timestep": TIMESTEP_AREA}
STEPS = 8
FRAMES_PER_STEP, FRAMES_BEFORE, FRAMES_AFTER = 3, 6, 10
FRAMES_PER_SECOND = 10
GAP = 0.06
"""Room between the two sides, as a fraction of the width of one."""

TEXT_SIZE = 0.075
"""Height of the letters, as a fraction of the height of the mesh."""

VIEW, SIZE = View((0.75, -1.0, 0.15), margin=0.02), (560, 500)
SAMPLES = 8
GREYS = 48
"""Grey levels kept in the file: plenty for clay, and a third of the size."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Film the head."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=OUTPUT, metavar="FILE.gif")
    options = parser.parse_args(arguments)
    _stage(sample_pair("head"))
    _render_gif(options.output)
    return 0


def _stage(pair: MeshPair) -> None:
    """Set the scene: one object with animated shape keys for each side, and its name."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    look = Look(size=SIZE, samples=SAMPLES)
    material = clay(look)
    turn = Vector(VIEW.direction).normalized().to_track_quat("Z", "Y")
    right, up, _ = np.array(turn.to_matrix()).T
    across, along = pair.clean @ right, pair.clean @ up
    stride = (1 + GAP) * np.ptp(across) * right
    seen = []
    for index, (name, scheme) in enumerate(SIDES.items()):
        item = add_mesh(pair.noisy, pair.triangles, look)
        item.location = index * stride
        item.data.materials.append(material)
        write_absolute_keys(item, _evolution(pair, scheme))
        start = FRAMES_BEFORE
        animate_evolution(item, start, start + STEPS * FRAMES_PER_STEP)
        height = TEXT_SIZE * np.ptp(along)
        middle = 0.5 * (across.min() + across.max()) * right + index * stride
        below = middle + (along.min() - 2 * height) * up
        _add_text(scene, name, below, height, turn)
        seen += [pair.noisy + index * stride, below[None] - 0.5 * height * up]
    everything = np.concatenate(seen)
    corners = np.array([everything.min(axis=0), everything.max(axis=0)])
    add_camera(scene, corners, everything, VIEW, look)
    add_lights(scene, VIEW)
    set_up(scene, look)
    _paint_background(scene.world)
    scene.render.film_transparent = False
    scene.render.fps = FRAMES_PER_SECOND
    scene.frame_start = 1
    scene.frame_end = FRAMES_BEFORE + STEPS * FRAMES_PER_STEP + FRAMES_AFTER


def _evolution(pair: MeshPair, scheme: Scheme) -> list[np.ndarray]:
    """Return all steps, at the τ that leaves the coarse parts as rough as without noise."""
    tau = matched_tau(scheme, pair.noisy, pair.clean, pair.classes, STEPS)
    run = fair(pair.noisy, pair.triangles, scheme.settings(tau, STEPS))
    return [step.positions for step in run.steps]


def _add_text(scene, text, place, height, turn):
    curve = bpy.data.curves.new(text, "FONT")
    curve.body, curve.size, curve.align_x = text, height, "CENTER"
    material = bpy.data.materials.new("ink")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    ink = nodes.new("ShaderNodeEmission")
    ink.inputs["Color"].default_value = (0.02, 0.02, 0.02, 1.0)
    material.node_tree.links.new(ink.outputs[0], nodes["Material Output"].inputs["Surface"])
    curve.materials.append(material)
    item = bpy.data.objects.new(text, curve)
    item.location, item.rotation_euler = place, turn.to_euler()
    scene.collection.objects.link(item)


def _paint_background(world):
    """Show white behind the meshes, without lighting them by it."""
    nodes, links = world.node_tree.nodes, world.node_tree.links
    white, mix = nodes.new("ShaderNodeBackground"), nodes.new("ShaderNodeMixShader")
    white.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    is_seen = nodes.new("ShaderNodeLightPath").outputs["Is Camera Ray"]
    for source, target in (
        (is_seen, mix.inputs[0]),
        (nodes["Background"].outputs[0], mix.inputs[1]),
        (white.outputs[0], mix.inputs[2]),
        (mix.outputs[0], nodes["World Output"].inputs["Surface"]),
    ):
        links.new(source, target)


def _render_gif(path: Path) -> None:
    with tempfile.TemporaryDirectory() as folder:
        bpy.context.scene.render.filepath = str(Path(folder) / "frame")
        bpy.context.scene.render.image_settings.color_mode = "RGB"
        bpy.ops.render.render(animation=True)
        frames = [Image.open(file).convert("L") for file in sorted(Path(folder).glob("*.png"))]
    # The same greys in all frames: nothing flickers, and frames that are alike become one.
    levels = [round(round(v / 255 * (GREYS - 1)) * 255 / (GREYS - 1)) for v in range(256)]
    frames = [frame.point(levels) for frame in frames]
    frames[0].save(
        path,
        save_all=True,
        append_images=frames[1:],
        duration=1000 // FRAMES_PER_SECOND,
        loop=0,
        optimize=True,
    )


if __name__ == "__main__":
    sys.exit(main())
