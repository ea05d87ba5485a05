"""The meshes that the benchmarks run on: made here, or read from a file.

All of them are moved into the box [-3, 3]³, the frame of the paper, so that one diffusion time
means the same to every program.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from adaptive_fairing.core import FairingSettings, TriangleTopology
from adaptive_fairing.core.diffusion.smoothing_radius import radius_scale, suggest_tau
from adaptive_fairing.core.loop.patches import PatchSet
from tools.geometry import ply
from tools.geometry.noise import add_noise
from tools.geometry.triangles import Faces, FloatArray, convex_hull, icosahedron, spiral, unit

NOISE = 0.15
"""Standard deviation of the noise along the normals, over the local edge length."""

N_CLASSES = 300
"""Patch classes of the shape "classes"."""


class Mesh(NamedTuple):
    """A triangle mesh with a name for the tables."""

    name: str
    vertices: FloatArray
    triangles: Faces

    def write(self, path: Path) -> None:
        """Write a .ply file that keeps every bit."""
        ply.write_ply(path, self.vertices, self.triangles, kind="double")


def read(path: Path) -> Mesh:
    """Read a file of `Mesh.write`."""
    return Mesh(path.stem, *ply.read_ply(path))


def sphere(n_triangles: int) -> Mesh:
    """Make a noisy geodesic sphere: valence 6 but for 12 vertices, as a subdivided icosahedron.

    Parameters
    ----------
    n_triangles : int
        Approximate size; an icosahedron's edge is cut into a whole number of parts.
    """
    parts = max(round((n_triangles / 20) ** 0.5), 1)
    corners, faces = icosahedron()
    j, i = (each.ravel() for each in np.meshgrid(*2 * [np.arange(parts + 1)]))
    weights = np.stack([parts - i - j, i, j], axis=1)[i + j <= parts]
    points = (weights @ corners[faces]).reshape(-1, 3)
    # Points of a common edge come from two faces: the same point has the same number, a random
    # integer combination of the corners, exact where coordinates would differ in the last bit.
    labels = np.random.default_rng(0).integers(1, 1 << 40, len(corners))
    _, first = np.unique((labels[faces] @ weights.T).ravel(), return_index=True)
    # In the order of the lattices neighbours lie close together.
    return _noisy("sphere", *_sorted_hull(unit(points[np.sort(first)])))


def irregular(n_triangles: int, jitter: float = 0.5) -> Mesh:
    """Make a noisy bumpy body with triangles of uneven size and valence, as scans have.

    Points on a spiral around the sphere, denser towards one side, are jittered and joined by
    their convex hull; then the sphere is bent into shape.

    Parameters
    ----------
    n_triangles : int
        Size, rounded up to an even number.
    jitter : float
        Random displacement of the points, over their mean distance: the larger, the more
        different valences. 0.5 gives valences 3 to 10.
    """
    n = n_triangles // 2 + 2
    points = spiral(n)
    spacing = (4 * np.pi / n) ** 0.5
    points += jitter * spacing * np.random.default_rng(1).uniform(-1, 1, points.shape)
    points += [0.0, 0.0, 0.55]  # seen from off the centre, one side is denser
    points, triangles = _sorted_hull(unit(points))
    x, y, z = points.T
    bump = 1 + 0.25 * np.sin(3 * x + 1) * np.cos(4 * y) + 0.1 * np.sin(9 * z) * np.cos(7 * x)
    return _noisy("irregular", points * bump[:, None] * [1.0, 0.8, 1.4], triangles)


def many_classes(n_triangles: int, n_classes: int = N_CLASSES) -> Mesh:
    """Make an irregular mesh with about `n_classes` kinds of triangles, by their valences.

    Vertices put into the middle of random triangles raise the valences around; their fraction is
    searched for.
    """
    low, high = 0.0, 0.45
    for _ in range(12):
        fraction = (low + high) / 2
        mesh = _with_vertices_inside(n_triangles, fraction)
        low, high = (fraction, high) if count_classes(mesh) < n_classes else (low, fraction)
    return mesh


def count_classes(mesh: Mesh) -> int:
    """Count the patch classes of a mesh."""
    return len(PatchSet(TriangleTopology(mesh.triangles, len(mesh.vertices))).classes)


def _with_vertices_inside(n_triangles: int, fraction: float) -> Mesh:
    """Split a fraction of all triangles into three; the result has `n_triangles` or one less."""
    n_split = round(fraction * n_triangles / (1 + 2 * fraction))
    base = irregular(n_triangles - 2 * n_split)
    chosen = np.random.default_rng(3).choice(len(base.triangles), n_split, replace=False)
    a, b, c = base.triangles[chosen].T
    new = len(base.vertices) + np.arange(n_split)
    parts = np.concatenate([(a, b, new), (b, c, new), (c, a, new)], axis=1).T
    triangles = np.concatenate([np.delete(base.triangles, chosen, axis=0), parts])
    vertices = np.concatenate([base.vertices, base.vertices[base.triangles[chosen]].mean(axis=1)])
    return Mesh("classes", vertices, triangles.astype(np.int32))


def from_file(path: Path) -> Mesh:
    """Read a mesh file of any format that pymeshlab knows, without adding noise."""
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    mesh = meshes.current_mesh()
    return _framed(path.stem, mesh.vertex_matrix(), mesh.face_matrix())


def _sorted_hull(points: FloatArray) -> tuple[FloatArray, Faces]:
    points, triangles = convex_hull(points)
    return points, triangles[np.argsort(triangles.min(axis=1), kind="stable")]


def _noisy(name: str, vertices: FloatArray, triangles: Faces) -> Mesh:
    mesh = _framed(name, vertices, triangles)
    return mesh._replace(vertices=add_noise(mesh.vertices, mesh.triangles, NOISE, seed=2))


def _framed(name: str, vertices: FloatArray, triangles: Faces) -> Mesh:
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    moved = (vertices - (low + high) / 2) * (6 / (high - low).max())
    return Mesh(name, np.ascontiguousarray(moved), np.ascontiguousarray(triangles, np.int32))


def weights_around(vertices: FloatArray, place: int, part: float) -> FloatArray:
    """Weights (n,) of 1 at a part of the vertices, those nearest to one of them."""
    distance = np.linalg.norm(vertices - vertices[place % len(vertices)], axis=1)
    return (distance <= np.quantile(distance, part)).astype(float)


SHAPES = {"sphere": sphere, "irregular": irregular, "classes": many_classes}


def comparable_settings(mesh: Mesh, radius: float, steps: int = 4) -> FairingSettings:
    """Choose τ so that all steps smooth over `radius` local edge lengths, on any mesh.

    At one τ a finer mesh would be smoothed over more of its edges, and need more iterations.
    """
    settings = FairingSettings(steps=steps)
    scale = radius_scale(mesh.vertices, mesh.triangles, settings)
    return replace(settings, tau=suggest_tau(scale, radius, steps))


def add_arguments(parser: argparse.ArgumentParser, sizes: list[int]) -> None:
    """Add the options that choose meshes."""
    parser.add_argument(
        "--sizes", type=int, nargs="*", default=sizes, help="triangles of the made meshes"
    )
    parser.add_argument(
        "--shapes",
        nargs="*",
        choices=SHAPES,
        default=("sphere", "irregular"),
        help="which meshes to make",
    )
    parser.add_argument("--mesh", type=Path, nargs="*", default=[], help="mesh files as well")
    parser.add_argument(
        "--radius", type=float, default=2.0, help="smoothing radius of four steps, in edges"
    )


def chosen(arguments: argparse.Namespace) -> Iterator[Mesh]:
    """Make or read the meshes that the options ask for, one at a time."""
    for shape in arguments.shapes:
        for size in arguments.sizes:
            yield SHAPES[shape](size)
    yield from map(from_file, arguments.mesh)
