"""Loop subdivision against Blender's Subdivision Surface modifier at the same number of faces.

Both begin with as many faces, ours with triangles, Blender's with quads, so that each step makes
four of one and both end with as many. Both give a new mesh on the limit surface; ours has exact
normals as well. They take turns in one process, and the shortest time of each counts.

    python -m benchmarks.refinement [--faces 102400] [--levels 2] [--repeats 7]
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from statistics import median

import bpy
import numpy as np

from adaptive_fairing.blender.data import refinement_cache
from adaptive_fairing.blender.data.refined_object import RefineOptions, refine_object
from tools.geometry.triangles import torus

from .measuring import load, machine, table

GOAL = 1.5
"""Times of the modifier's time that ours may take."""

MODIFIER = "Blender, Subdivision Surface"


def bumpy_torus(n_faces: int, is_triangulated: bool, has_uv: bool) -> bpy.types.Object:
    """Make an object with about so many faces, triangles or quads, and a UV map on request."""
    n_quads = n_faces // 2 if is_triangulated else n_faces
    rows = int(np.sqrt(n_quads))
    columns = n_quads // rows
    places, faces = torus(3, 1, (rows, columns))
    places *= 1 + 0.05 * np.sin(5 * places[:, :1]) * np.cos(4 * places[:, 1:2])
    halves = np.split(faces, 2)
    faces = np.concatenate([halves[0], halves[1][:, 2:]], axis=1)
    if is_triangulated:
        faces = faces[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    mesh = bpy.data.meshes.new("torus")
    mesh.from_pydata(places, [], faces.tolist(), shade_flat=False)
    if has_uv:
        layer = mesh.uv_layers.new(name="UV")
        values = places[faces.reshape(-1), :2].astype(np.float32)
        layer.uv.foreach_set("vector", values.reshape(-1))
    obj = bpy.data.objects.new("torus", mesh)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def timed(action: Callable[[], bpy.types.Mesh]) -> tuple[float, int]:
    """Seconds of an action, and the number of faces of the mesh that it gives, which goes."""
    start = time.perf_counter()
    mesh = action()
    mesh.update()
    seconds = time.perf_counter() - start
    n_faces = len(mesh.polygons)
    bpy.data.meshes.remove(mesh)
    return seconds, n_faces


def ours(obj: bpy.types.Object, options: RefineOptions, is_known: bool) -> Callable:
    """Refine an object's mesh, which stays; `is_known`: as the redo panel does it again."""

    def refine() -> bpy.types.Mesh:
        if not is_known:
            refinement_cache.forget()
        control = obj.data
        refine_object(obj, options)
        refined, obj.data = obj.data, control
        return refined

    obj.data.use_fake_user = True
    return refine


def modifier(obj: bpy.types.Object, levels: int) -> Callable:
    """Evaluate the modifier anew, and make a mesh of it."""
    subdivision = obj.modifiers.new("Subdivision", "SUBSURF")
    subdivision.levels = levels

    def evaluate() -> bpy.types.Mesh:
        obj.data.update_tag()
        graph = bpy.context.evaluated_depsgraph_get()
        graph.update()
        return bpy.data.meshes.new_from_object(obj.evaluated_get(graph), depsgraph=graph)

    return evaluate


def main() -> None:
    """Print one table per kind of mesh."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--faces", type=int, default=102_400)
    parser.add_argument("--levels", type=int, default=2)
    parser.add_argument("--repeats", type=int, default=7)
    arguments = parser.parse_args()
    print(f"{machine()}, Blender {bpy.app.version_string}, {load()}")
    for has_uv in (False, True):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        triangles = bumpy_torus(arguments.faces, True, has_uv)
        quads = bumpy_torus(arguments.faces, False, has_uv)
        whole = RefineOptions(arguments.levels)
        plain = RefineOptions(arguments.levels, exact_normals=False)
        actions = {
            MODIFIER: modifier(quads, arguments.levels),
            "ours": ours(triangles, whole, False),
            "ours without exact normals": ours(triangles, plain, False),
            "ours once more, as the redo panel does": ours(triangles, whole, True),
        }
        runs: dict[str, list[tuple[float, int]]] = {name: [] for name in actions}
        for _ in range(arguments.repeats):
            for name, action in actions.items():
                runs[name].append(timed(action))
        rows = []
        of_blender = [seconds for seconds, _ in runs[MODIFIER]]
        for name, found in runs.items():
            seconds = [each for each, _ in found]
            rows.append(
                [
                    name,
                    f"{found[0][1]:,}",
                    f"{min(seconds):.3f}",
                    f"{median(seconds):.3f}",
                    f"{min(seconds) / min(of_blender):.2f}",
                    f"{median(seconds) / median(of_blender):.2f}",
                ]
            )
        print(f"\n{'With' if has_uv else 'Without'} a UV map; goal {GOAL} of the least times\n")
        head = ["", "faces", "least s", "median s", "least / Blender", "median / Blender"]
        print(table(head, rows))


if __name__ == "__main__":
    main()
