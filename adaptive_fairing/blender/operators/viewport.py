"""Draw the colours of a field over the object in 3D views.

Nothing of the view's shading and of the mesh's own colours changes, and other objects stay as they
are.
"""

from __future__ import annotations

import bpy
import numpy as np

from ..data.attributes import FIELD_ATTRIBUTES, color_name

BIAS = 2e-4
"""How much nearer than the surface the colours are drawn, as a part of the depth."""

_batches: dict[int, object] = {}  # by the object's session_uid
_handles: list[object] = []


def forget(obj: bpy.types.Object) -> None:
    """Have the colours of an object read again: its shape or its colours are others."""
    _batches.pop(obj.session_uid, None)


def forget_all() -> None:
    """Have all colours read again."""
    _batches.clear()


def redraw(context: bpy.types.Context) -> None:
    """Draw all 3D views anew."""
    forget_all()
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


def _draw() -> None:
    import gpu

    graph = bpy.context.evaluated_depsgraph_get()
    space = bpy.context.space_data
    shown = [
        obj
        for obj in bpy.context.visible_objects
        if obj.type == "MESH" and obj.adaptive_fairing.view and obj.visible_in_viewport_get(space)
    ]
    if not shown:
        return
    shader = gpu.shader.from_builtin("SMOOTH_COLOR")
    gpu.state.depth_test_set("LESS_EQUAL")
    projection = gpu.matrix.get_projection_matrix().copy()
    projection[2] -= BIAS * projection[3]
    with gpu.matrix.push_pop_projection():
        gpu.matrix.load_projection_matrix(projection)
        for obj in shown:
            if obj.session_uid not in _batches:
                _batches[obj.session_uid] = _batch(obj.evaluated_get(graph), obj, shader)
            batch = _batches[obj.session_uid]
            if batch is not None:
                with gpu.matrix.push_pop():
                    gpu.matrix.multiply_matrix(obj.matrix_world)
                    batch.draw(shader)
    gpu.state.depth_test_set("NONE")


def _batch(evaluated: bpy.types.Object, obj: bpy.types.Object, shader):
    """Make triangles with the colours of a field; None if the mesh has lost them."""
    from gpu_extras.batch import batch_for_shader

    mesh = evaluated.data
    colors = mesh.attributes.get(color_name(FIELD_ATTRIBUTES[obj.adaptive_fairing.view]))
    if colors is None or colors.domain != "POINT":
        return None
    n_vertices = len(mesh.vertices)
    positions = np.empty((n_vertices, 3), dtype=np.float32)
    mesh.attributes["position"].data.foreach_get("vector", positions.ravel())
    values = np.empty((n_vertices, 4), dtype=np.float32)
    colors.data.foreach_get("color_srgb", values.ravel())
    mesh.calc_loop_triangles()
    triangles = np.empty((len(mesh.loop_triangles), 3), dtype=np.int32)
    mesh.loop_triangles.foreach_get("vertices", triangles.ravel())
    return batch_for_shader(shader, "TRIS", {"pos": positions, "color": values}, indices=triangles)


def register() -> None:
    """Draw from now on, where there is a window."""
    if not bpy.app.background:
        handle = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW")
        _handles.append(handle)


def unregister() -> None:
    """Draw no more."""
    while _handles:
        bpy.types.SpaceView3D.draw_handler_remove(_handles.pop(), "WINDOW")
    forget_all()
