"""Blender's smoothing modifiers, as peers."""

from __future__ import annotations

from collections.abc import Iterator

import bpy

from tools.geometry.blender_meshes import add_modifier, evaluated, new_object
from tools.geometry.triangles import Faces, FloatArray


def smooth(vertices: FloatArray, faces: Faces, sweep: tuple[float, ...]) -> Iterator[FloatArray]:
    """Smooth, at its factor 0.5; the sweep counts iterations."""
    return _counted(vertices, faces, sweep, "SMOOTH")


def corrective_smooth(
    vertices: FloatArray, faces: Faces, sweep: tuple[float, ...], weights: str
) -> Iterator[FloatArray]:
    """Smooth Corrective without the correction, which would bring the noise back."""
    return _counted(
        vertices, faces, sweep, "CORRECTIVE_SMOOTH", use_only_smooth=True, smooth_type=weights
    )


def laplacian_smooth(
    vertices: FloatArray, faces: Faces, sweep: tuple[float, ...], iterations: int
) -> Iterator[FloatArray]:
    """Laplacian Smooth; the sweep is its lambda for inner and boundary vertices."""
    item = _object(vertices, faces)
    for value in sweep:
        yield _evaluated(
            item, "LAPLACIANSMOOTH", iterations=iterations, lambda_factor=value, lambda_border=value
        )


def _counted(vertices, faces, sweep, modifier: str, **options) -> Iterator[FloatArray]:
    """Go on from the last result: that is what further iterations do."""
    positions, done = vertices, 0
    for value in sweep:
        item = _object(positions, faces)
        positions = _evaluated(item, modifier, iterations=int(value) - done, **options)
        done = int(value)
        yield positions


def _object(vertices: FloatArray, faces: Faces) -> bpy.types.Object:
    """Make the mesh the only object of an empty file."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return new_object(vertices, faces)


def _evaluated(item: bpy.types.Object, modifier: str, **options) -> FloatArray:
    item.modifiers.clear()
    add_modifier(item, modifier, **options)
    return evaluated(item)[0]
