"""Clean meshes of the benchmark, by name: what `method="auto"` was tuned on, and what was held out.

All are made here, the same on every run with the same versions of pymeshlab and Blender.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tools.samples.crocodile import detail
from tools.samples.ply import read_ply

from . import cad, implicit, parametric
from .meshing import MeshArrays, graded, near, remeshed, uneven

ASSETS = Path(__file__).resolve().parents[3] / "assets"


@dataclass(frozen=True)
class Shape:
    """A clean mesh that can be made.

    Attributes
    ----------
    kind
        What it is like: organic, cad, mixed ...
    make
        Returns vertices (n, 3) and triangles (m, 3).
    voxels
        Cells along its longest side for the noise kind "staircase"; 0 where the mesh is open.
    """

    kind: str
    make: Callable[[], MeshArrays]
    voxels: int = 56


def sample(name: str) -> MeshArrays:
    """Read one of the project's own samples."""
    return read_ply(ASSETS / f"{name}.ply")


def crocodile() -> MeshArrays:
    """Return the sample with half its triangles."""
    vertices, faces = sample("crocodile")
    return uneven(vertices, faces, 20_000, detail(vertices))


def bracket() -> MeshArrays:
    """Return an angle with holes."""
    part = cad.Part().box((0, 0, 0), (4, 3, 0.8)).box((0, 0, 0.1), (0.8, 3, 3))
    for y in (0.8, 2.2):
        part.cylinder((2.7, y, 0.4), (0, 0, 1), 0.4, 4, cut=True)
    part.cylinder((0.4, 1.5, 2.0), (1, 0, 0), 0.6, 4, cut=True)
    return _machined(part, 0.055, 9_000, (4, 3, 0.8), 1.6)


def socket() -> MeshArrays:
    """Return a rounded body on a sharp plate: a bearing block."""
    part = cad.Part().box((-2, -1.2, 0), (2, 1.2, 0.5)).ball((0, 0, 0.9), 1.05)
    part.cylinder((0, 0, 1.0), (1, 0, 0), 0.45, 5, cut=True)
    for x in (-1.6, 1.6):
        part.cylinder((x, 0, 0.3), (0, 0, 1), 0.22, 3, cut=True)
    return _machined(part, 0.055, 10_000, (0, -0.6, 1.8), 1.0)


def gear() -> MeshArrays:
    """Return a toothed wheel with a hub."""
    part = cad.Part().prism(cad.gear_outline(18, 1.6, 2.0), 0.0, 0.5)
    part.cylinder((0, 0, 0.25), (0, 0, 1), 0.7, 1.1).cylinder((0, 0, 0), (0, 0, 1), 0.35, 4, True)
    for k in range(6):
        angle = np.pi * (k + 0.5) / 3
        part.cylinder((1.12 * np.cos(angle), 1.12 * np.sin(angle), 0), (0, 0, 1), 0.22, 4, True)
    return _machined(part, 0.045, 14_000, (1.8, 0, 0.5), 1.0)


def steps() -> MeshArrays:
    """Return a stepped block with a groove and a pocket."""
    part = cad.Part().box((0, 0, 0), (4, 2, 0.6))
    for k in range(1, 5):
        part.box((0.7 * k, 0.12 * k, 0.3), (4, 2 - 0.12 * k, 0.6 + 0.42 * k))
    part.box((3.0, 0.7, 1.2), (3.7, 1.3, 3.0), cut=True, turn=30)
    part.cylinder((2.0, 0, 0), (0, 1, 0), 0.35, 9, cut=True)
    return _machined(part, 0.05, 8_000, (3.4, 1.0, 2.2), 0.9)


def pipes() -> MeshArrays:
    """Return cylinders that run through each other."""
    part = cad.Part().cylinder((0, 0, 0), (0, 0, 1), 0.8, 4).cylinder((0, 0, 0), (1, 0, 0), 0.6, 4)
    part.cylinder((0, 0.6, 0.6), (0.3, 1, 0.7), 0.4, 3).cylinder((0, 0, 2), (0, 0, 1), 1.1, 0.4)
    part.cylinder((0, 0, -2.2), (0, 0, 1), (1.2, 0.8), 0.8)
    return _machined(part, 0.06, 12_000, (0.5, 1.5, 1.5), 0.9, crease=30)


def cushion() -> MeshArrays:
    """Return a part whose edges are all rounded."""
    part = cad.Part().box((0, 0, 0), (3, 2, 1)).box((0.8, 0.5, 0.5), (2.2, 1.5, 1.9))
    part.bevel(0.18, 12)
    return _machined(part, 0.05, 9_000, (2.2, 1.5, 1.9), 0.9, crease=45)


def lens() -> MeshArrays:
    """Return a ball cut flat, drilled and slotted: round and sharp in one mesh."""
    part = cad.Part().ball((0, 0, 0), 1.5).box((-2, -2, 0.9), (2, 2, 2), cut=True)
    part.cylinder((0, 0, 0.9), (0, 0, 1), 0.6, 1.0, cut=True)
    part.box((-2, -0.2, -2), (2, 0.2, -1.1), cut=True, turn=25)
    part.box((1.1, -2, -2), (2, 2, 2), cut=True)
    return _machined(part, 0.05, 10_000, (-1.0, -1.0, 0.5), 0.9, crease=25)


def _machined(part, edge, n_triangles, dense, radius, crease=25.0) -> MeshArrays:
    vertices, faces = remeshed(*part.arrays(), 0.55 * edge, crease)
    return graded(vertices, faces, n_triangles, near(vertices, dense, radius, 1e-6))


TUNING: Mapping[str, Shape] = {
    "head": Shape("organic", lambda: sample("head")),
    "coral": Shape("organic", implicit.coral, 90),
    "bracket": Shape("cad", bracket),
    "socket": Shape("mixed", socket),
    "poles_32": Shape("poles", lambda: parametric.pole_sphere(32, 64, 0.1)),
    "hills": Shape("terrain", lambda: parametric.terrain(3, 4_500, ridged=False), 0),
    "two_lumps": Shape("pieces", lambda: parametric.pieces(2, (700, 4_000))),
}
"""What the parameters of method "auto" may be tuned on."""

HELD_OUT: Mapping[str, Shape] = {
    "foot": Shape("organic", lambda: sample("foot")),
    "crocodile": Shape("organic", crocodile, 110),
    "pebble": Shape("organic, fine detail", implicit.pebble),
    "engraved": Shape("detail at the noise's scale", parametric.engraved),
    "gear": Shape("cad", gear),
    "steps": Shape("cad", steps),
    "pipes": Shape("cad", pipes),
    "cushion": Shape("cad, bevelled", cushion),
    "lens": Shape("mixed", lens),
    "pawn": Shape("mixed", parametric.pawn),
    "molecule": Shape("marching cubes", implicit.molecule),
    "mountains": Shape("terrain", lambda: parametric.terrain(7, 6_500, ridged=True), 0),
    "gyroid": Shape("open, saddles", implicit.gyroid, 0),
    "four_lumps": Shape("pieces", lambda: parametric.pieces(9, (500, 1_200, 2_800, 6_000))),
    "poles_72": Shape("poles", lambda: parametric.pole_sphere(72, 48, 0.06)),
}
"""What was never looked at while tuning."""

SHAPES = {**TUNING, **HELD_OUT}
