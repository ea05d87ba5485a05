"""Clean and noisy meshes by name: of our own shapes, or read from a folder of pairs."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from importlib import import_module
from pathlib import Path

import numpy as np

from tools.geometry.triangles import Faces, FloatArray

from .noise import KINDS, add_noise

STAIRCASE, CLEAN = "staircase", "none"

SCANS = {
    "camera": ("scans", "depth_camera"),
    "scanner": ("scans", "range_scanner"),
    "light": ("devices", "structured_light"),
    "photos": ("devices", "photogrammetry"),
    "volume": ("devices", "fused_volume"),
}
"""Kinds that make a mesh of their own: module and function."""

AMPLITUDES = {
    "normal": (0.05, 0.1, 0.2, 0.4),
    "uniform": (0.1, 0.2, 0.3, 0.5, 0.7),
    "isotropic": (0.2,),
    "growing": (0.23,),
    "impulsive": (0.3,),
    "heavy-tailed": (0.3,),
    "correlated-2": (0.2,),
    "correlated-4": (0.3,),
    "correlated-6": (0.4,),
    "camera": (2.0,),
    "scanner": (0.3,),
    "light": (1.5,),
    "photos": (0.2,),
    "volume": (0.3,),
    STAIRCASE: (0.0,),
    CLEAN: (0.0,),
}
"""Strengths of every kind of noise, in edges (see `noise`) or distances of rays (see `scans` and
`devices`)."""

ALL_NOISE = tuple(
    f"{kind}:{amplitude:g}" if amplitude else kind
    for kind, amplitudes in AMPLITUDES.items()
    for amplitude in amplitudes
)
"""Every kind of noise as it is named on the command line: KIND:AMPLITUDE."""

MAIN_NOISE = "normal:0.2"


@dataclass(frozen=True)
class Pair:
    """A mesh whose clean surface is known.

    Attributes
    ----------
    name, kind, group, noise
        For the tables: name of the shape, what it is like, "tuning", "held-out" or the name of a
        folder, and the noise as in `ALL_NOISE` ("file" where it was read).
    clean, noisy
        (n, 3) positions of the same vertices.
    faces
        (m, 3) triangles.
    """

    name: str
    kind: str
    group: str
    noise: str
    clean: FloatArray
    noisy: FloatArray
    faces: Faces

    @property
    def label(self) -> str:
        """Name and noise, for rows and file names."""
        return self.name if self.noise == "file" else f"{self.name}_{self.noise.replace(':', '_')}"

    @property
    def digest(self) -> str:
        """Name of the mesh's content, for what is kept of it."""
        content = hashlib.sha256()
        for array in (self.clean, self.noisy, self.faces):
            content.update(np.ascontiguousarray(array).tobytes())
        return content.hexdigest()[:20]


def made(names: list[str], noises: list[str]) -> Iterator[Pair]:
    """Make pairs of our own shapes, by name, with every noise asked for that the shape can have."""
    for name in names:
        for noise in noises:
            pair = _made(name, noise)
            if pair is not None:
                yield pair


def in_folder(folder: Path) -> Iterator[Pair]:
    """Read the pairs of a folder, in alphabetical order.

    NAME.clean.EXT and NAME.noisy.EXT have the same triangles; the clean mesh is a pair without
    noise as well. NAME.scan.EXT is a real scan and NAME.reference.EXT the surface, of any
    triangles: clean are its points nearest to the vertices of the scan.
    """
    import igl

    for path in sorted(folder.iterdir()):
        name, _, role = path.stem.rpartition(".")
        if role == "clean":
            noisy_path = path.with_name(f"{name}.noisy{path.suffix}")
            (clean, faces), (noisy, other_faces) = _read(path), _read(noisy_path)
            if not np.array_equal(faces, other_faces):
                raise ValueError(f"{noisy_path} has other faces than {path}")
            yield Pair(name, "given", folder.name, "file", clean, noisy, faces)
            yield Pair(name, "given", folder.name, CLEAN, clean, clean, faces)
        elif role == "scan":
            noisy, faces = _read(path)
            surface = _read(path.with_name(f"{name}.reference{path.suffix}"))
            clean = igl.point_mesh_squared_distance(noisy, surface[0], surface[1].astype(int))[2]
            yield Pair(name, "real", folder.name, "scan", clean, noisy, faces)


def _made(name: str, noise: str) -> Pair | None:
    from . import shapes  # takes seconds: Blender and pymeshlab

    shape = shapes.SHAPES[name]
    group = next(group for group, members in shapes.GROUPS.items() if name in members)
    kind, _, amplitude = noise.partition(":")
    if kind == STAIRCASE:
        if not shape.voxels:
            return None
        from .staircase import staircase

        return Pair(name, shape.kind, group, noise, *staircase(*_shape(name), shape.voxels))
    clean, faces = _shape(name)
    noisy = clean
    seed = int.from_bytes(hashlib.sha256(f"{name} {noise}".encode()).digest()[:4], "big")
    if kind == "volume" and not shape.voxels:
        return None
    if kind in SCANS:
        module, function = SCANS[kind]
        scan = getattr(import_module(f".{module}", __package__), function)
        found = scan(clean, faces, float(amplitude), np.random.default_rng(seed))
        return Pair(name, shape.kind, group, noise, *found)
    if kind != CLEAN:
        noisy = add_noise(clean, faces, kind, float(amplitude), seed)
    return Pair(name, shape.kind, group, noise, clean, noisy, faces)


@lru_cache(maxsize=4)
def _shape(name: str) -> tuple[FloatArray, Faces]:
    from . import shapes

    return shapes.SHAPES[name].make()


def _read(path: Path) -> tuple[FloatArray, Faces]:
    import igl

    vertices, faces = igl.read_triangle_mesh(str(path))
    return np.ascontiguousarray(vertices, dtype=float), faces.astype(np.int32)


def noise_name(text: str) -> str:
    """Check a noise as it is given on the command line."""
    kind, _, amplitude = text.partition(":")
    if kind in (STAIRCASE, CLEAN) and not amplitude:
        return text
    if kind in (*KINDS, *SCANS) and float(amplitude) > 0:
        return text
    raise ValueError(f"{text}: not one of {', '.join(ALL_NOISE)}")
