"""The meshes that the benchmarks run on: made here, read from a file, or from Debian's CGAL data.

All of them are moved into the box [-3, 3]³, the frame of the paper, so that one diffusion time
means the same to every program.
"""

from __future__ import annotations

import argparse
import tarfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from adaptive_fairing.core import FairingSettings
from adaptive_fairing.core.diffusion.smoothing_radius import radius_scale, suggest_tau

CGAL_DATA = Path("/usr/share/doc/libcgal-dev/data.tar.gz")
"""Meshes in Debian's package libcgal-demo."""

CGAL_MESHES = ("refined_elephant", "bunny00", "armadillo", "diplodocus")
"""The large ones that are clean triangle meshes."""

NOISE = 0.15
"""Standard deviation of the noise along the normals, over the local edge length."""


class Mesh(NamedTuple):
    """A triangle mesh with a name for the tables."""

    name: str
    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]


def sphere(n_triangles: int) -> Mesh:
    """Make a noisy geodesic sphere: valence 6 but for 12 vertices, as a subdivided icosahedron.

    Parameters
    ----------
    n_triangles : int
        Approximate size; an icosahedron's edge is cut into a whole number of parts.
    """
    parts = max(round((n_triangles / 20) ** 0.5), 1)
    corners, faces = _icosahedron()
    j, i = np.meshgrid(np.arange(parts + 1), np.arange(parts + 1))
    inside = i + j <= parts
    i, j = i[inside], j[inside]
    weights = np.stack([parts - i - j, i, j], axis=1)
    number = np.full((parts + 1, parts + 1), -1)
    number[i, j] = np.arange(len(i))
    up = (i + j < parts).nonzero()[0]
    down = (i + j < parts - 1).nonzero()[0]
    a, b = (i[up], j[up]), (i[down], j[down])
    lattice = np.concatenate(
        [
            np.stack([number[a], number[a[0] + 1, a[1]], number[a[0], a[1] + 1]], axis=1),
            np.stack(
                [
                    number[b[0] + 1, b[1]],
                    number[b[0] + 1, b[1] + 1],
                    number[b[0], b[1] + 1],
                ],
                axis=1,
            ),
        ]
    )
    points = np.concatenate([weights @ corners[face] for face in faces])
    # Points of a common edge come from two faces: the same point has the same number, a random
    # integer combination of the corners, exact where coordinates would differ in the last bit.
    labels = np.random.default_rng(0).integers(1, 1 << 40, len(corners))
    keys = np.concatenate([weights @ labels[face] for face in faces])
    _, first, place = np.unique(keys, return_index=True, return_inverse=True)
    # Keep the order of the lattices, in which neighbours lie close together.
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    offsets = len(i) * np.arange(len(faces))
    triangles = rank[place][(lattice + offsets[:, None, None]).reshape(-1, 3)]
    vertices = points[np.sort(first)]
    vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    return _finished("sphere", vertices, triangles)


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
    generator = np.random.default_rng(1)
    height = 1 - (2 * np.arange(n) + 1) / n
    angle = np.pi * (3 - 5**0.5) * np.arange(n)
    radius = np.sqrt(1 - height**2)
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=1)
    spacing = (4 * np.pi / n) ** 0.5
    points += jitter * spacing * generator.uniform(-1, 1, points.shape)
    points += [0.0, 0.0, 0.55]  # seen from off the centre, one side is denser
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    triangles = ConvexHull(points).simplices.astype(np.int64)
    corner = points[triangles]
    normals = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    inward = np.einsum("fd,fd->f", normals, corner[:, 0]) < 0
    triangles[inward] = triangles[inward][:, ::-1]
    triangles = triangles[np.argsort(triangles.min(axis=1), kind="stable")]
    x, y, z = points.T
    bump = 1 + 0.25 * np.sin(3 * x + 1) * np.cos(4 * y) + 0.1 * np.sin(9 * z) * np.cos(7 * x)
    return _finished("irregular", points * bump[:, None] * [1.0, 0.8, 1.4], triangles)


def from_cgal_data(name: str) -> Mesh | None:
    """Read one of `CGAL_MESHES`, or None where Debian's package libcgal-demo is not installed."""
    if not CGAL_DATA.is_file():
        return None
    with tarfile.open(CGAL_DATA) as archive:
        stream = archive.extractfile(f"data/meshes/{name}.off")
        if stream is None:
            return None
        text = stream.read().decode()
    numbers = " ".join(line.split("#")[0] for line in text.splitlines()[1:]).split()
    n_vertices, n_faces = int(numbers[0]), int(numbers[1])
    vertices = np.array(numbers[3 : 3 + 3 * n_vertices], dtype=float).reshape(-1, 3)
    faces = np.array(numbers[3 + 3 * n_vertices :][: 4 * n_faces], dtype=float).astype(int)
    return _framed(name, vertices, faces.reshape(-1, 4)[:, 1:])


def from_file(path: Path) -> Mesh:
    """Read a mesh file of any format that pymeshlab knows, without adding noise."""
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    mesh = meshes.current_mesh()
    return _framed(path.stem, mesh.vertex_matrix(), mesh.face_matrix())


def mean_edge(mesh: Mesh) -> tuple[float, float]:
    """Mean length, and mean squared length, of the triangles' edges."""
    corner = mesh.vertices[mesh.triangles]
    squares = np.sum(np.square(corner - corner[:, [1, 2, 0]]), axis=2)
    return float(np.sqrt(squares).mean()), float(squares.mean())


def write_ply(mesh: Mesh, path: Path) -> None:
    """Write a binary .ply with coordinates in double precision."""
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(mesh.vertices)}\n"
        "property double x\nproperty double y\nproperty double z\n"
        f"element face {len(mesh.triangles)}\n"
        "property list uchar int vertex_indices\nend_header\n"
    )
    faces = np.empty(len(mesh.triangles), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, mesh.triangles
    with path.open("wb") as file:
        file.write(header.encode())
        file.write(mesh.vertices.astype("<f8").tobytes())
        file.write(faces.tobytes())


def read_ply(path: Path) -> Mesh:
    """Read a file of `write_ply`."""
    data = path.read_bytes()
    start = data.index(b"end_header\n") + len(b"end_header\n")
    lines = data[:start].decode().splitlines()
    n_vertices, n_faces = (int(line.split()[2]) for line in lines if line.startswith("element"))
    vertices = np.frombuffer(data, "<f8", 3 * n_vertices, start).reshape(-1, 3)
    face = np.dtype([("count", "u1"), ("corners", "<i4", 3)])
    faces = np.frombuffer(data, face, n_faces, start + vertices.nbytes)
    return Mesh(path.stem, vertices.copy(), np.ascontiguousarray(faces["corners"]))


def _icosahedron() -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    golden = (1 + 5**0.5) / 2
    signs = [(a, b) for a in (-1, 1) for b in (-1, 1)]
    corners = np.array([np.roll([0.0, a, b * golden], turn) for turn in range(3) for a, b in signs])
    faces = ConvexHull(corners).simplices.astype(np.intp)
    corner = corners[faces]
    volume = np.einsum("fd,fd->f", np.cross(corner[:, 0], corner[:, 1]), corner[:, 2])
    faces[volume < 0] = faces[volume < 0][:, ::-1]
    return corners, faces


def _finished(name: str, vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> Mesh:
    """Add noise along the normals, relative to the edges around, and fit the mesh to the frame."""
    mesh = _framed(name, vertices, triangles)
    n, origins = len(vertices), mesh.triangles.reshape(-1)
    corner = mesh.vertices[mesh.triangles]
    lengths = np.linalg.norm(corner - corner[:, [1, 2, 0]], axis=2).reshape(-1)
    local_edge = np.bincount(origins, lengths, n) / np.bincount(origins, minlength=n)
    face_normals = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normals = np.stack([np.bincount(origins, np.repeat(c, 3), n) for c in face_normals.T])
    normals /= np.linalg.norm(normals, axis=0)
    noise = NOISE * local_edge * np.random.default_rng(2).normal(size=n)
    return Mesh(name, mesh.vertices + (noise * normals).T, mesh.triangles)


def _framed(name: str, vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> Mesh:
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    moved = (vertices - (low + high) / 2) * (6 / (high - low).max())
    return Mesh(name, np.ascontiguousarray(moved), np.ascontiguousarray(triangles, np.int32))


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
        choices=("sphere", "irregular"),
        default=("sphere", "irregular"),
        help="which meshes to make",
    )
    parser.add_argument("--mesh", type=Path, nargs="*", default=[], help="mesh files as well")
    parser.add_argument(
        "--radius", type=float, default=2.0, help="smoothing radius of four steps, in edges"
    )
    parser.add_argument(
        "--cgal-data", action="store_true", help="large meshes of Debian's libcgal-demo as well"
    )


def chosen(arguments: argparse.Namespace) -> Iterator[Mesh]:
    """Make or read the meshes that the options ask for, one at a time."""
    for shape in arguments.shapes:
        make = sphere if shape == "sphere" else irregular
        for size in arguments.sizes:
            yield make(size)
    for path in arguments.mesh:
        yield from_file(path)
    if arguments.cgal_data:
        for name in CGAL_MESHES:
            mesh = from_cgal_data(name)
            if mesh is None:
                print(f"{name}: left out, the package libcgal-demo is not installed")
                return
            yield mesh
