"""Test meshes made in Blender, and what became of them. Runs inside Blender."""

from __future__ import annotations

import bpy
import numpy as np
from mathutils import Vector
from mathutils.kdtree import KDTree


def add_noisy(
    primitive: str,
    noise: float,
    algorithm: str = "FAIR",
    nose: Vector | None = None,
    **sizes: int,
) -> bpy.types.Object:
    """Replace the scene's objects by one of Blender's primitives with seeded noise.

    `noise` is the standard deviation along the normals in object units, `algorithm` what the panel
    is set to. A `nose` is pulled out of the shape in that direction.
    """
    bpy.context.scene.adaptive_fairing.algorithm = algorithm
    for old in list(bpy.data.objects):
        bpy.data.objects.remove(old)
    getattr(bpy.ops.mesh, f"primitive_{primitive}_add")(**sizes)
    obj = bpy.context.object
    positions = vertex_positions(obj)
    normals = np.empty_like(positions)
    obj.data.vertex_normals.foreach_get("vector", normals.ravel())
    if nose is not None:
        positions += 0.3 * np.exp(30 * (positions @ nose - 1))[:, None] * np.array(nose)
    positions += np.random.default_rng(1).normal(0.0, noise, (len(normals), 1)) * normals
    obj.data.vertices.foreach_set("co", positions.ravel())
    obj.data.update()
    bpy.ops.ed.undo_push(message="Test mesh")
    return obj


def vertex_positions(obj: bpy.types.Object) -> np.ndarray:
    """Undeformed vertices (n, 3), float32."""
    positions = np.empty((len(obj.data.vertices), 3), np.float32)
    obj.data.vertices.foreach_get("co", positions.ravel())
    return positions


def shown_positions(obj: bpy.types.Object) -> np.ndarray:
    """Vertices (n, 3) as the window shows them, shape keys applied."""
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return vertex_positions(evaluated)


def largest_gap(obj: bpy.types.Object, expected: np.ndarray) -> float:
    """Largest distance from a vertex of an object, in the world, to the nearest of (n, 3)."""
    tree = KDTree(len(expected))
    for index, position in enumerate(expected):
        tree.insert(position, index)
    tree.balance()
    bpy.context.view_layer.update()
    return max(tree.find(obj.matrix_world @ vertex.co)[2] for vertex in obj.data.vertices)


def key_positions(obj: bpy.types.Object) -> dict[str, np.ndarray]:
    """Vertices (n, 3) of each shape key by name; empty without shape keys."""
    keys = obj.data.shape_keys
    positions = {}
    for block in keys.key_blocks if keys else ():
        positions[block.name] = np.empty((len(obj.data.vertices), 3), np.float32)
        block.data.foreach_get("co", positions[block.name].ravel())
    return positions


def shown_evolution(obj: bpy.types.Object, keys: dict[str, np.ndarray]) -> dict[str, float]:
    """Value of the Evolution slider, and how far the shape shown is from that mix of keys."""
    value = obj.adaptive_fairing.evolution
    place = value * (len(keys) - 1)
    before = min(int(place), len(keys) - 2)
    first, second = list(keys.values())[before : before + 2]
    expected = first + (place - before) * (second - first)
    return {"value": value, "error": float(np.abs(shown_positions(obj) - expected).max())}


def key_names() -> list[str]:
    """Shape keys of the active object; looked up anew, since undo replaces objects."""
    obj = bpy.context.view_layer.objects.active
    return list(key_positions(obj)) if obj else []


def equal_to_core(obj: bpy.types.Object, noisy: np.ndarray, keys: list[np.ndarray]) -> bool:
    """Tell whether the shape keys are the core's positions, rounded to float32."""
    from bl_ext.user_default.adaptive_fairing.adaptive_fairing.core import FairingSettings, fair

    obj.data.calc_loop_triangles()
    triangles = np.empty((len(obj.data.loop_triangles), 3), np.int32)
    obj.data.loop_triangles.foreach_get("vertices", triangles.ravel())
    result = fair(noisy.astype(np.float64), triangles, FairingSettings())
    expected = [step.positions.astype(np.float32) for step in result.steps]
    return len(expected) == len(keys) and all(map(np.array_equal, expected, keys))
