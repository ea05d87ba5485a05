"""Render the evolution of a .blend that `adaptive-fairing fair` has written, as numbered pictures.

    adaptive-fairing fair scan.ply -o scan.blend
    blender -b scan.blend --python-exit-code 1 --python render_evolution.py -- pictures

On the left the surface in grey, on the right the same in the colours of its density. It needs no
extension and no graphics card. After the folder, `--width 480`, `--samples 4` and `--every 4`
(frames) make it faster. `ffmpeg -i pictures/%04d.png film.mp4` makes a film of the pictures.
"""

import argparse
import math
import os
import sys

import bpy
import numpy as np
from mathutils import Vector

DIRECTION = Vector((0.5, -1.0, 0.2)).normalized()  # from the objects towards the camera
TO_THE_RIGHT = Vector((0.0, 0.0, 1.0)).cross(DIRECTION).normalized()  # as the camera sees it
COLORS = "fairing_density_color"


def main(arguments):
    """Set the scene up and render its frames."""
    parser = argparse.ArgumentParser(prog="render_evolution.py")
    parser.add_argument("folder")
    parser.add_argument("--width", type=int, default=960)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--every", type=int, default=1)
    options = parser.parse_args(arguments)
    scene = bpy.context.scene
    meshes = [obj for obj in scene.objects if obj.type == "MESH"]
    colored = next(obj for obj in meshes if COLORS in obj.data.attributes)
    for obj in meshes:
        obj.hide_render = obj is not colored
    grey = grey_copy(colored)
    scene.collection.objects.link(grey)
    grey.location -= 1.1 * width(colored) * TO_THE_RIGHT
    prepare_render(scene, [grey, colored], (options.width, options.width * 2 // 3), options.samples)
    for number, frame in enumerate(range(scene.frame_start, scene.frame_end + 1, options.every)):
        scene.frame_set(frame)
        scene.render.filepath = os.path.abspath(os.path.join(options.folder, f"{number:04d}.png"))
        bpy.ops.render.render(write_still=True)


def grey_copy(colored):
    """Copy an object, with a grey material in place of its own; the mesh stays shared."""
    grey = colored.copy()
    material = grey_material()
    for slot in grey.material_slots:
        slot.link, slot.material = "OBJECT", material
    return grey


def grey_material():
    """Make a matt grey material."""
    material = bpy.data.materials.new("Grey")
    if material.node_tree is None:  # Blender 5 gives every material its nodes
        material.use_nodes = True
    (shader,) = (node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    shader.inputs["Base Color"].default_value = (0.45, 0.45, 0.45, 1.0)
    shader.inputs["Roughness"].default_value = 0.7
    return material


def prepare_render(scene, objects, size, samples):
    """Add a camera that sees all objects, and lights; choose Cycles, and the size in pixels."""
    import _cycles  # exists once bpy has been imported

    scene.camera = add_camera(scene, objects, size[0] / size[1])
    add_lights(scene)
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = samples
    scene.cycles.use_denoising = _cycles.with_openimagedenoise  # not in every build of Blender
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    scene.render.dither_intensity = 0.0
    scene.render.image_settings.file_format = "PNG"
    scene.view_settings.view_transform = "Standard"  # colours as they are


def add_camera(scene, objects, aspect):
    """Point an orthographic camera at the objects."""
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    camera.rotation_euler = DIRECTION.to_track_quat("Z", "Y").to_euler()
    turn = camera.rotation_euler.to_matrix()
    bpy.context.view_layer.update()
    seen = np.concatenate([points(obj) for obj in objects]) @ np.array(turn)
    low, high = seen.min(axis=0), seen.max(axis=0)
    across, up, _ = high - low
    camera.data.type = "ORTHO"
    camera.data.ortho_scale = 1.08 * max(across, aspect * up)
    far = float(np.ptp(seen))
    camera.location = turn @ Vector((*(low[:2] + high[:2]) / 2, high[2] + far))
    camera.data.clip_start, camera.data.clip_end = 1e-3 * far, 10.0 * far
    return camera


def add_lights(scene):
    """Light the scene from the upper left, a little from the right, and evenly from all around."""
    camera = scene.camera.rotation_euler.to_quaternion()
    for name, towards, strength in (("Key", (-0.8, 0.7, 0.7), 2.6), ("Fill", (1.0, 0.1, 0.8), 0.5)):
        light = bpy.data.objects.new(name, bpy.data.lights.new(name, "SUN"))
        light.data.energy, light.data.angle = strength, math.radians(10.0)
        light.rotation_euler = (camera @ Vector(towards)).to_track_quat("Z", "Y").to_euler()
        scene.collection.objects.link(light)
    scene.world = bpy.data.worlds.new("Even light")
    if scene.world.node_tree is None:
        scene.world.use_nodes = True
    (background,) = (node for node in scene.world.node_tree.nodes if node.type == "BACKGROUND")
    background.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    background.inputs["Strength"].default_value = 0.6


def points(obj):
    """Places (n, 3) of the vertices of an object in the scene."""
    found = np.empty((len(obj.data.vertices), 3), dtype=np.float32)
    obj.data.vertices.foreach_get("co", found.ravel())
    matrix = np.array(obj.matrix_world)
    return found @ matrix[:3, :3].T + matrix[:3, 3]


def width(obj):
    """Width of an object as the camera sees it."""
    return float(np.ptp(points(obj) @ np.array(TO_THE_RIGHT)))


if __name__ == "__main__":
    main(sys.argv[sys.argv.index("--") + 1 :])
