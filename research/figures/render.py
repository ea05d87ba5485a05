"""Render triangle meshes as clay with Blender's Cycles on the CPU.

A small helper for the sample meshes and the figures: `render(vertices, triangles, ...)` makes one
picture. Flat shading shows every triangle, which is what a picture of fairing is about.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector
from numpy.typing import NDArray
from PIL import Image

from tools.geometry.blender_meshes import new_object

CLAY = (0.62, 0.60, 0.57)
AMBIENT = 0.9
"""Strength of the even light from all around (Blender's default world colour is dark grey)."""


@dataclass(frozen=True)
class View:
    """Position and view of the camera.

    Attributes
    ----------
    direction
        From the object towards the camera, any length.
    box
        Lower and upper corner of the part to frame, in object units; None is the whole mesh.
    perspective
        Field of view in degrees; 0 is an orthographic camera.
    margin
        Free room around the framed part, as a fraction of its size.
    """

    direction: tuple[float, float, float]
    box: tuple[Sequence[float], Sequence[float]] | None = None
    perspective: float = 0.0
    margin: float = 0.06


@dataclass(frozen=True)
class Look:
    """Settings of a picture."""

    size: tuple[int, int] = (800, 800)
    samples: int = 48
    color: tuple[float, float, float] = CLAY
    smooth: bool = False


def render(
    vertices: NDArray[np.float64],
    triangles: NDArray[np.int32],
    view: View,
    look: Look | None = None,
    vertex_colors: NDArray[np.float64] | None = None,
) -> Image.Image:
    """Render one mesh to a picture with a transparent background.

    Parameters
    ----------
    vertices, triangles
        (n, 3) positions and (m, 3) vertex indices.
    view, look
        Camera, and picture settings.
    vertex_colors
        (n, 3) linear RGB in [0, 1], replacing the clay colour.
    """
    look = look or Look()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    mesh = _add_mesh(vertices, triangles, look, vertex_colors)
    # Lights are cast for the part in view, so that a close-up is lit like the whole.
    corners = np.array(view.box) if view.box else np.array([vertices.min(0), vertices.max(0)])
    _add_camera(scene, corners, vertices, view, look)
    _add_lights(scene, view)
    mesh.materials.append(_clay(look, vertex_colors is not None))
    _set_up(scene, look)
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder, "picture.png"))
        bpy.ops.render.render(write_still=True)
        return Image.open(scene.render.filepath).convert("RGBA")


def _add_mesh(vertices, triangles, look, vertex_colors=None):
    """Return the mesh of a new object of the scene."""
    mesh = new_object(vertices, triangles).data
    mesh.polygons.foreach_set("use_smooth", np.full(len(triangles), look.smooth))
    if vertex_colors is not None:
        # Not "color": Cycles takes that name for the colour of the object.
        attribute = mesh.attributes.new("field", "FLOAT_COLOR", "POINT")
        rgba = np.column_stack([vertex_colors, np.ones(len(vertices))]).astype(np.float32)
        attribute.data.foreach_set("color", rgba.ravel())
    return mesh


def _add_camera(scene, corners, vertices, view, look):
    """Place the camera so that it sees the box of `corners`, or all `vertices` if it is theirs."""
    direction = Vector(view.direction).normalized()
    turn = direction.to_track_quat("Z", "Y")
    centre = Vector(corners.mean(axis=0))
    seen = vertices if view.box is None else _box_corners(corners)
    local = np.array(turn.to_matrix().transposed()) @ (seen - np.array(centre)).T
    low, high = local.min(axis=1), local.max(axis=1)
    middle = turn @ Vector((0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.0))
    width, height = high[0] - low[0], high[1] - low[1]
    aspect = look.size[0] / look.size[1]
    span = max(width, height * aspect) * (1.0 + 2.0 * view.margin)
    radius = float(np.linalg.norm(vertices - np.array(centre), axis=1).max())
    camera = bpy.data.cameras.new("camera")
    if view.perspective:
        camera.angle_x = math.radians(view.perspective)
        camera.sensor_fit = "HORIZONTAL"
        distance = 0.5 * span / math.tan(0.5 * camera.angle_x) + high[2]
    else:
        camera.type = "ORTHO"
        camera.sensor_fit = "HORIZONTAL"
        camera.ortho_scale = span
        distance = 4.0 * radius
    camera.clip_start, camera.clip_end = 0.001 * radius, 20.0 * radius + 2.0 * distance
    item = bpy.data.objects.new("camera", camera)
    item.location = centre + middle + direction * distance
    item.rotation_euler = turn.to_euler()
    scene.collection.objects.link(item)
    scene.camera = item


def _box_corners(corners):
    return np.array(np.meshgrid(*corners.T)).reshape(3, -1).T


def _add_lights(scene, view):
    """Add three suns that turn with the camera: key, upper left; fill, right; rim, behind."""
    turn = Vector(view.direction).normalized().to_track_quat("Z", "Y")
    for name, offset, strength, angle in (
        ("key", (-0.8, 0.75, 0.75), 3.4, 8.0),
        ("fill", (0.95, 0.15, 0.8), 0.7, 40.0),
        ("rim", (0.5, 0.9, -0.8), 1.6, 15.0),
    ):
        light = bpy.data.lights.new(name, "SUN")
        light.energy, light.angle = strength, math.radians(angle)
        item = bpy.data.objects.new(name, light)
        item.rotation_euler = (turn @ Vector(offset)).to_track_quat("Z", "Y").to_euler()
        scene.collection.objects.link(item)


def _clay(look, colored=False):
    """Return the material of all meshes; `colored` takes the colours of the vertices."""
    material = bpy.data.materials.new("clay")
    material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*look.color, 1.0)
    shader.inputs["Roughness"].default_value = 0.6
    shader.inputs["Specular IOR Level"].default_value = 0.25
    if colored:
        node = material.node_tree.nodes.new("ShaderNodeAttribute")
        node.attribute_name = "field"
        material.node_tree.links.new(node.outputs["Color"], shader.inputs["Base Color"])
    return material


def _set_up(scene, look):
    """Choose Cycles on the CPU, a picture that is the same on every run, and even light."""
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = look.samples
    scene.cycles.seed = 0
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.max_bounces = 3
    scene.cycles.use_denoising = True
    scene.render.resolution_x, scene.render.resolution_y = look.size
    scene.render.film_transparent = True
    scene.render.image_settings.file_format = "PNG"
    scene.render.image_settings.color_mode = "RGBA"
    scene.view_settings.view_transform = "Standard"
    world = bpy.data.worlds.new("world")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Strength"].default_value = AMBIENT
    scene.world = world
