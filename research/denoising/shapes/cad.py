"""Machine parts: flat sides, sharp edges, holes, bevels; exact until they are remeshed."""

from __future__ import annotations

from collections.abc import Sequence

import bpy

# isort: split
import bmesh  # exists once bpy has been imported, like mathutils
import numpy as np
from mathutils import Matrix, Vector

from tools.geometry.blender_meshes import add_modifier, evaluated
from tools.geometry.triangles import grid_faces

from .meshing import MeshArrays

Point = Sequence[float]


class Part:
    """A solid made in Blender by joining and cutting; use one at a time.

    Its boolean operations are Blender's exact ones, so corners and edges lie where they belong.
    """

    def __init__(self) -> None:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self._item: bpy.types.Object | None = None

    def box(self, low: Point, high: Point, cut: bool = False, turn: float = 0.0) -> Part:
        """Join or cut a box between two corners, turned about its own z axis by degrees."""
        mesh = bmesh.new()
        bmesh.ops.create_cube(mesh, size=1.0)
        low, high = Vector(low), Vector(high)
        place = Matrix.Translation((low + high) / 2) @ Matrix.Rotation(np.radians(turn), 4, "Z")
        size = Matrix.Diagonal((*(high - low), 1.0))
        bmesh.ops.transform(mesh, matrix=place @ size, verts=mesh.verts)
        return self._apply(mesh, cut)

    def cylinder(
        self,
        centre: Point,
        axis: Point,
        radius: float | tuple[float, float],
        height: float,
        cut: bool = False,
        segments: int = 96,
    ) -> Part:
        """Join or cut a cylinder, or a cone's stump where two radii are given."""
        first, last = radius if isinstance(radius, tuple) else (radius, radius)
        mesh = bmesh.new()
        bmesh.ops.create_cone(
            mesh, cap_ends=True, segments=segments, radius1=first, radius2=last, depth=height
        )
        turn = Vector(axis).to_track_quat("Z", "Y").to_matrix().to_4x4()
        place = Matrix.Translation(centre) @ turn
        bmesh.ops.transform(mesh, matrix=place, verts=mesh.verts)
        return self._apply(mesh, cut)

    def ball(self, centre: Point, radius: float, cut: bool = False) -> Part:
        """Join or cut a ball."""
        mesh = bmesh.new()
        bmesh.ops.create_icosphere(
            mesh, subdivisions=5, radius=radius, matrix=Matrix.Translation(centre)
        )
        return self._apply(mesh, cut)

    def prism(self, outline: np.ndarray, low: float, high: float, cut: bool = False) -> Part:
        """Join or cut an outline (n, 2), counter-clockwise, between two heights z."""
        mesh = bmesh.new()
        bottom = [mesh.verts.new((x, y, low)) for x, y in outline]
        top = [mesh.verts.new((x, y, high)) for x, y in outline]
        mesh.faces.new(bottom[::-1])
        mesh.faces.new(top)
        for k in range(len(outline)):
            mesh.faces.new((bottom[k - 1], bottom[k], top[k], top[k - 1]))
        return self._apply(mesh, cut)

    def solid(self, vertices: np.ndarray, faces: np.ndarray, cut: bool = False) -> Part:
        """Join or cut a closed mesh, (n, 3) and (m, 3)."""
        mesh = bmesh.new()
        corners = [mesh.verts.new(vertex) for vertex in vertices]
        for face in faces:
            mesh.faces.new([corners[k] for k in face])
        return self._apply(mesh, cut)

    def bevel(self, width: float, segments: int = 6) -> Part:
        """Round all edges bent by more than 30 degrees."""
        sharp = {"limit_method": "ANGLE", "angle_limit": np.radians(30)}
        add_modifier(self._item, "BEVEL", width=width, segments=segments, **sharp)
        return self

    def arrays(self) -> MeshArrays:
        """Return the vertices and triangles."""
        return evaluated(self._item)

    def _apply(self, mesh: bmesh.types.BMesh, cut: bool) -> Part:
        data = bpy.data.meshes.new("part")
        mesh.to_mesh(data)
        mesh.free()
        item = bpy.data.objects.new("part", data)
        bpy.context.scene.collection.objects.link(item)
        if self._item is None:
            self._item = item
        else:
            operation = "DIFFERENCE" if cut else "UNION"
            add_modifier(self._item, "BOOLEAN", solver="EXACT", object=item, operation=operation)
        return self


def gear_outline(n_teeth: int, inner: float, outer: float, points_per_flank: int = 3) -> np.ndarray:
    """Return a gear's outline (n, 2), counter-clockwise, its flanks leaning inwards."""
    pitch = 2 * np.pi / n_teeth
    root = np.linspace(-0.5, -0.27, points_per_flank), np.full(points_per_flank, inner)
    tip = np.linspace(-0.14, 0.14, points_per_flank), np.full(points_per_flank, outer)
    back = np.linspace(0.27, 0.5, points_per_flank)[:-1], np.full(points_per_flank - 1, inner)
    turns = np.concatenate([root[0], tip[0], back[0]])
    radii = np.concatenate([root[1], tip[1], back[1]])
    angles = (turns[None] + np.arange(n_teeth)[:, None]).ravel() * pitch
    radii = np.tile(radii, n_teeth)
    return np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1)


def helical_ridge(
    radius: float, height: float, pitch: float, n_turns: float, per_turn: int = 64
) -> MeshArrays:
    """Return the ridge of a screw thread about the z axis, closed, from z = 0 upwards.

    Its foot lies within a cylinder of that radius; at both ends it runs out into it.
    """
    turns = np.linspace(0, n_turns, round(n_turns * per_turn) + 1)
    run_out = np.clip(np.minimum(turns, n_turns - turns) / 0.4, 0, 1)
    crest = radius - 0.02 + (height + 0.02) * run_out
    foot = np.full(len(turns), radius - 0.3 * pitch)
    flank = np.full(len(turns), radius - 0.02)
    profile = ((foot, -0.42), (flank, -0.42), (crest, -0.08), (crest, 0.08), (flank, 0.42),
               (foot, 0.42))  # fmt: skip
    angle = 2 * np.pi * turns
    rings = [
        np.stack([r * np.cos(angle), r * np.sin(angle), pitch * (turns + z)], axis=-1)
        for r, z in profile
    ]
    n = len(profile)
    points = np.stack(rings, axis=1).reshape(-1, 3)
    sides = grid_faces(len(turns), n, (False, True))
    fan = np.array([[0, k, k + 1] for k in range(1, n - 1)])
    last = len(points) - n
    return points, np.concatenate([sides, fan[:, ::-1], fan + last]).astype(np.int32)
