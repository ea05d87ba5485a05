"""Write the paper's figure 1.1: a noisy head, faired with adaptive and with uniform timesteps.

    python examples/figure_1_1.py figure_1_1.png

It needs `pip install ".[blender]"`, and takes the sample head of this repository; `--mesh FILE.ply`
takes another. From left to right: the input, four adaptive timesteps of τ = 0.016, one uniform
timestep of τ = 0.001, and four of them.
"""

import argparse
import os
import sys
from pathlib import Path

import bpy
import numpy as np
from render_evolution import TO_THE_RIGHT, grey_material, prepare_render, width

from adaptive_fairing.core import FairingSettings, fair

HEAD = Path(__file__).resolve().parent.parent / "assets" / "head_noisy.ply"
ADAPTIVE = FairingSettings(method="adaptive_timestep", tau=0.016, steps=4)
UNIFORM = FairingSettings(method="uniform", tau=0.001, steps=4)


def main(arguments):
    """Fair the mesh in the paper's two ways, and render the shapes side by side."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("picture", help="PNG file to write")
    parser.add_argument("--mesh", default=HEAD, help="PLY file with a mesh")
    parser.add_argument("--width", type=int, default=1600, help="of the picture, in pixels")
    parser.add_argument("--samples", type=int, default=16, help="rays for each pixel")
    options = parser.parse_args(arguments)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.ply_import(filepath=str(options.mesh))
    noisy = bpy.context.object
    noisy.data.materials.append(grey_material())
    vertices, triangles = mesh_arrays(noisy.data)
    adaptive = fair(vertices, triangles, ADAPTIVE)
    uniform = fair(vertices, triangles, UNIFORM)
    shapes = [adaptive.positions, uniform.steps[0].positions, uniform.positions]
    objects = [noisy]
    for place, shape in enumerate(shapes, start=1):
        copy = noisy.copy()
        copy.data = noisy.data.copy()
        copy.data.vertices.foreach_set("co", shape.astype(np.float32).ravel())
        copy.location += 1.1 * place * width(noisy) * TO_THE_RIGHT
        bpy.context.collection.objects.link(copy)
        objects.append(copy)
    size = (options.width, options.width * 2 // 5)
    prepare_render(bpy.context.scene, objects, size, options.samples)
    bpy.context.scene.render.filepath = os.path.abspath(options.picture)
    bpy.ops.render.render(write_still=True)


def mesh_arrays(mesh):
    """Positions (n, 3) and triangles (m, 3) of a mesh."""
    vertices = np.empty((len(mesh.vertices), 3), dtype=np.float32)
    mesh.vertices.foreach_get("co", vertices.ravel())
    mesh.calc_loop_triangles()
    triangles = np.empty((len(mesh.loop_triangles), 3), dtype=np.int32)
    mesh.loop_triangles.foreach_get("vertices", triangles.ravel())
    return vertices.astype(np.float64), triangles


if __name__ == "__main__":
    main(sys.argv[1:])
