"""Clean meshes of the benchmark, by name: what `denoise` was tuned on, and what was held out.

All are made here, the same on every run with the same versions of pymeshlab and Blender.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from research.samples.crocodile import detail
from tools.geometry.ply import read_ply

from . import facets, implicit, machined, new, parametric, patches, turned
from .meshing import MeshArrays, folded, speckled, uneven

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


TUNING: Mapping[str, Shape] = {
    "head": Shape("organic", lambda: sample("head")),
    "coral": Shape("organic", implicit.coral, 90),
    "bracket": Shape("cad", machined.bracket),
    "socket": Shape("mixed", machined.socket),
    "poles_32": Shape("poles", lambda: parametric.pole_sphere(32, 64, 0.1)),
    "hills": Shape("terrain", lambda: parametric.terrain(3, 4_500, ridged=False), 0),
    "two_lumps": Shape("pieces", lambda: parametric.pieces(2, (700, 4_000))),
    "foot": Shape("organic", lambda: sample("foot")),
    "crocodile": Shape("organic", crocodile, 110),
    "pebble": Shape("organic, fine detail", implicit.pebble),
    "engraved": Shape("detail at the noise's scale", parametric.engraved),
    "gear": Shape("cad", machined.gear),
    "steps": Shape("cad", machined.steps),
    "pipes": Shape("cad", machined.pipes),
    "cushion": Shape("cad, bevelled", machined.cushion),
    "lens": Shape("mixed", machined.lens),
    "pawn": Shape("mixed", turned.pawn),
    "molecule": Shape("marching cubes", implicit.molecule),
    "mountains": Shape("terrain", lambda: parametric.terrain(7, 6_500, ridged=True), 0),
    "gyroid": Shape("open, saddles", implicit.gyroid, 0),
    "four_lumps": Shape("pieces", lambda: parametric.pieces(9, (500, 1_200, 2_800, 6_000))),
    "poles_72": Shape("poles", lambda: parametric.pole_sphere(72, 48, 0.06)),
    "bracket_even": Shape("cad, even", lambda: machined.even(machined.bracket, 0.09)),
    "gear_even": Shape("cad, even", lambda: machined.even(machined.gear, 0.06)),
    "steps_even": Shape("cad, even", lambda: machined.even(machined.steps, 0.08)),
    "crystal": Shape("cad, even", machined.crystal),
    "shelf": Shape("cad, thin", machined.shelf),
    "speck_bracket_even": Shape(
        "cad, specks", lambda: speckled(*machined.even(machined.bracket, 0.09))
    ),
    "speck_steps_even": Shape(
        "cad, specks", lambda: speckled(*machined.even(machined.steps, 0.08))
    ),
    "speck_coral": Shape("organic, specks", lambda: speckled(*implicit.coral())),
    "speck_pawn": Shape("mixed, specks", lambda: speckled(*turned.pawn())),
    "folded_shelf": Shape("cad, folds", lambda: folded(*machined.shelf())),
}
"""Shapes for tuning the parameters of `denoise`. Those from the foot on were added after a
measurement on them without tuning."""

HELD_OUT: Mapping[str, Shape] = {
    "octopus": Shape("organic", implicit.octopus, 90),
    "mask": Shape("organic, open", implicit.mask, 0),
    "coin": Shape("relief", implicit.coin, 110),
    "protein": Shape("marching tetrahedra", implicit.protein, 80),
    "flange": Shape("cad, filleted", machined.flange),
    "bolt": Shape("cad, thread", machined.bolt, 90),
    "jewel": Shape("mixed", machined.jewel, 90),
    "vase": Shape("thin walls", turned.vase, 110),
    "knot": Shape("tube", parametric.knot, 90),
    "crater": Shape("terrain", parametric.crater, 0),
}
"""Shapes that were never looked at while tuning."""

NEW: Mapping[str, Shape] = {
    "block": Shape("cad, even", new.block),
    "die": Shape("cad, even", new.die),
    "faceted_ring": Shape("cad, even", new.faceted_ring),
    "heat_sink": Shape("cad, thin", new.heat_sink, 110),
    "house": Shape("cad", new.house),
    "propeller": Shape("cad, thin", new.propeller, 110),
    "wall": Shape("relief, open, even", new.wall, 0),
    "fish": Shape("organic", new.fish, 90),
    "hand": Shape("organic", new.hand, 90),
    "seashell": Shape("organic, open, thin", new.seashell, 0),
    "brain": Shape("organic, folds", new.brain, 90),
    "mushroom": Shape("mixed", new.mushroom, 90),
}
"""Shapes that are looked at once, when all parameters are final. Nothing is tuned on them."""

OPEN: Mapping[str, Shape] = {
    "square": Shape("open, flat", patches.square, 0),
    "ell": Shape("open, corners", patches.ell, 0),
    "sieve": Shape("open, holes", patches.sieve, 0),
    "half_pipe": Shape("open, bent", patches.half_pipe, 0),
    "cap": Shape("open, bent, uneven", patches.cap, 0),
}
"""Shapes for tuning the treatment of free boundaries, besides the open ones among `TUNING`."""

FACETS: Mapping[str, Shape] = {
    "facets_28": Shape("cad, facets", lambda: facets.polyhedron(16, 4_000, 0)),
    "facets_44": Shape("cad, facets", lambda: facets.polyhedron(24, 6_000, 1)),
    "facets_68": Shape("cad, facets", lambda: facets.polyhedron(36, 8_000, 2)),
    "facets_96": Shape("cad, facets", lambda: facets.polyhedron(50, 10_000, 3)),
    "facets_136": Shape("cad, facets", lambda: facets.polyhedron(70, 9_000, 4)),
}
"""Shapes for tuning how flat faces are found that meet at small angles."""

GROUPS = {"tuning": TUNING, "held-out": HELD_OUT, "new": NEW, "open": OPEN, "facets": FACETS}

SHAPES = {name: shape for group in GROUPS.values() for name, shape in group.items()}
