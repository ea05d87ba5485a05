"""Runs of the operators on the selected object, and what their result must be. Needs bpy."""

import bpy
import numpy as np

from adaptive_fairing.blender.data.mesh_arrays import read_mesh_coordinates, read_triangles
from adaptive_fairing.core import DenoiseSettings, LimitSurface, TriangleTopology, denoise

ULP = 2.0**-23
"""Spacing of float32 at 1: original, offset, their sum and the expectation are rounded to it."""

LEVELS = {"LIMIT": 0, "REFINED_1": 1, "REFINED_2": 2, "REFINED_3": 3}
"""Refinements by the name of the surface."""


def run(**options):
    """Denoise, or what the options say."""
    return bpy.ops.object.adaptive_fairing(**options)


def paper(**options):
    """Fair by a method of the paper."""
    return run(**{"algorithm": "FAIR", "steps": 3, "tau": 0.01, **options})


def surface(name):
    """Show the result on a surface."""
    return bpy.ops.object.adaptive_fairing_surface(surface=name)


def coordinates(obj):
    """Coordinates of the mesh itself, (n, 3)."""
    return read_mesh_coordinates(obj.data)


def core_result(obj, **settings):
    """Denoise the coordinates of an object with the core."""
    vertices = coordinates(obj).astype(float)
    return denoise(vertices, read_triangles(obj.data), DenoiseSettings(**settings))


def fairing_attributes(obj):
    """Names of the attributes that runs have left."""
    return [name for name in obj.data.attributes.keys() if name.startswith("fairing")]


def refined(triangles, positions, name):
    """Return the core's refinement of positions."""
    limit = LimitSurface(TriangleTopology(triangles, len(positions)), positions)
    return limit.refined(LEVELS[name]).vertices


def near(found, expected):
    """Whether coordinates near 1 are equal but for the rounding to float32."""
    return np.abs(found - expected).max() <= 4 * ULP
