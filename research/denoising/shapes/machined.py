"""Machine parts and jewellery, made by joining and cutting; the flat sides are coarse."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tools.geometry.triangles import FloatArray, convex_hull, torus

from .cad import Part, gear_outline, helical_ridge
from .meshing import MeshArrays, graded, near, remeshed
from .turned import lathe


def bracket() -> MeshArrays:
    """Return an angle with holes."""
    part = Part().box((0, 0, 0), (4, 3, 0.8)).box((0, 0, 0.1), (0.8, 3, 3))
    for y in (0.8, 2.2):
        part.cylinder((2.7, y, 0.4), (0, 0, 1), 0.4, 4, cut=True)
    part.cylinder((0.4, 1.5, 2.0), (1, 0, 0), 0.6, 4, cut=True)
    return _machined(part, 0.055, 9_000, (4, 3, 0.8), 1.6)


def socket() -> MeshArrays:
    """Return a rounded body on a sharp plate: a bearing block."""
    part = Part().box((-2, -1.2, 0), (2, 1.2, 0.5)).ball((0, 0, 0.9), 1.05)
    part.cylinder((0, 0, 1.0), (1, 0, 0), 0.45, 5, cut=True)
    for x in (-1.6, 1.6):
        part.cylinder((x, 0, 0.3), (0, 0, 1), 0.22, 3, cut=True)
    return _machined(part, 0.055, 10_000, (0, -0.6, 1.8), 1.0)


def gear() -> MeshArrays:
    """Return a toothed wheel with a hub."""
    part = Part().prism(gear_outline(18, 1.6, 2.0), 0.0, 0.5)
    part.cylinder((0, 0, 0.25), (0, 0, 1), 0.7, 1.1).cylinder((0, 0, 0), (0, 0, 1), 0.35, 4, True)
    for k in range(6):
        angle = np.pi * (k + 0.5) / 3
        part.cylinder((1.12 * np.cos(angle), 1.12 * np.sin(angle), 0), (0, 0, 1), 0.22, 4, True)
    return _machined(part, 0.045, 14_000, (1.8, 0, 0.5), 1.0)


def steps() -> MeshArrays:
    """Return a stepped block with a groove and a pocket."""
    part = Part().box((0, 0, 0), (4, 2, 0.6))
    for k in range(1, 5):
        part.box((0.7 * k, 0.12 * k, 0.3), (4, 2 - 0.12 * k, 0.6 + 0.42 * k))
    part.box((3.0, 0.7, 1.2), (3.7, 1.3, 3.0), cut=True, turn=30)
    part.cylinder((2.0, 0, 0), (0, 1, 0), 0.35, 9, cut=True)
    return _machined(part, 0.05, 8_000, (3.4, 1.0, 2.2), 0.9)


def pipes() -> MeshArrays:
    """Return cylinders that run through each other."""
    part = Part().cylinder((0, 0, 0), (0, 0, 1), 0.8, 4).cylinder((0, 0, 0), (1, 0, 0), 0.6, 4)
    part.cylinder((0, 0.6, 0.6), (0.3, 1, 0.7), 0.4, 3).cylinder((0, 0, 2), (0, 0, 1), 1.1, 0.4)
    part.cylinder((0, 0, -2.2), (0, 0, 1), (1.2, 0.8), 0.8)
    return _machined(part, 0.06, 12_000, (0.5, 1.5, 1.5), 0.9, crease=30)


def cushion() -> MeshArrays:
    """Return a part whose edges are all rounded."""
    part = Part().box((0, 0, 0), (3, 2, 1)).box((0.8, 0.5, 0.5), (2.2, 1.5, 1.9))
    part.bevel(0.18, 12)
    return _machined(part, 0.05, 9_000, (2.2, 1.5, 1.9), 0.9, crease=45)


def lens() -> MeshArrays:
    """Return a ball cut flat, drilled and slotted: round and sharp in one mesh."""
    part = Part().ball((0, 0, 0), 1.5).box((-2, -2, 0.9), (2, 2, 2), cut=True)
    part.cylinder((0, 0, 0.9), (0, 0, 1), 0.6, 1.0, cut=True)
    part.box((-2, -0.2, -2), (2, 0.2, -1.1), cut=True, turn=25)
    part.box((1.1, -2, -2), (2, 2, 2), cut=True)
    return _machined(part, 0.05, 10_000, (-1.0, -1.0, 0.5), 0.9, crease=25)


def flange() -> MeshArrays:
    """Return a pipe's flange: its edges and the neck rounded, ribs and drilled holes sharp."""
    outline = [
        (0, -0.25), *_arc((1.8, -0.15), 0.1, -90, 0), *_arc((1.8, 0.1), 0.15, 0, 90),
        *_arc((1.15, 0.5), 0.25, 270, 180), *_arc((0.78, 1.38), 0.12, 0, 90), (0, 1.5),
    ]  # fmt: skip
    part = Part().solid(*lathe(np.array(outline), 128))
    part.box((-1.6, -0.12, 0.1), (1.6, 0.12, 0.7)).box((-0.12, -1.6, 0.1), (0.12, 1.6, 0.7))
    part.cylinder((0, 0, 0), (0, 0, 1), 0.6, 5, cut=True)
    for k in range(8):
        angle = np.pi * (k + 0.5) / 4
        part.cylinder((1.5 * np.cos(angle), 1.5 * np.sin(angle), 0), (0, 0, 1), 0.17, 3, cut=True)
    return _machined(part, 0.07, 20_000, (0, 0.7, 1.2), 1.0, crease=30, least=0.01)


def _arc(centre: tuple[float, float], radius: float, start: float, end: float) -> FloatArray:
    """Return points (n, 2) of an arc between two directions in degrees."""
    angle = np.radians(np.linspace(start, end, 10))
    return centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def bolt() -> MeshArrays:
    """Return a screw with a hexagonal head and a thread that runs out at both ends."""
    turn = np.pi * np.arange(6) / 3
    outline = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    part = Part().prism(outline, 0.0, 0.55).cylinder((0, 0, -1.6), (0, 0, 1), 0.5, 3.3)
    ridge, faces = helical_ridge(0.5, 0.14, 0.3, 7.3)
    part.solid(ridge - [0, 0, 3.0], faces)
    part.cylinder((0, 0, 0.5), (0, 0, 1), (0.3, 0.36), 0.3, cut=True)
    return _machined(part, 0.06, 18_000, (0, 0, -1.8), 0.9, least=0.01)


def jewel() -> MeshArrays:
    """Return a ring with a cut stone: flat facets on a round band, held by four claws."""
    levels = ((8, 0.55, 0.36), (8, 0.82, 0.2), (16, 1.0, 0.0), (16, 1.0, -0.06), (8, 0.06, -0.8))
    corners = []
    for n, radius, height in levels:
        turn = 2 * np.pi * (np.arange(n) + 0.5 * (height == 0.2)) / n
        corners.append(
            np.stack([radius * np.cos(turn), radius * np.sin(turn), np.full(n, height)], axis=1)
        )
    part = Part().solid(*convex_hull(np.concatenate(corners)))
    part.cylinder((0, 0, -0.62), (0, 0, 1), (0.42, 0.8), 0.75)
    band, faces = torus(1.5, 0.2, (192, 48))
    part.solid(band[:, [0, 2, 1]] * [1, -1, 1] - [0, 0, 2.2], faces)
    for k in range(4):
        angle = np.pi * (k + 0.5) / 2
        x, y = 0.97 * np.cos(angle), 0.97 * np.sin(angle)
        part.cylinder((0.97 * x, 0.97 * y, -0.2), (0.25 * x, 0.25 * y, 1), 0.11, 0.7)
        part.ball((x, y, 0.13), 0.15)
    return _machined(part, 0.06, 24_000, (0, 0, 0.2), 0.9, crease=15, least=0.01)


def crystal() -> MeshArrays:
    """Return an even solid of flat faces alone, that meet at 15 to 60 degrees."""
    points = np.random.default_rng(11).normal(size=(24, 3))
    points *= np.array([1.6, 1.2, 2.0]) / np.linalg.norm(points, axis=1)[:, None]
    return remeshed(*convex_hull(points), 0.08, crease=8)


def shelf() -> MeshArrays:
    """Return boards and a slanted rest, all flat, a few edges thick."""
    part = Part().box((0, 0, 0), (4, 1.6, 0.3)).box((0, 0, 0.1), (0.3, 1.6, 3))
    part.box((3.4, 0, 0.1), (3.7, 1.6, 2.4)).box((0.1, 0.2, 1.2), (3.6, 1.6, 1.5))
    outline = np.array([(0.25, 2.9), (0.25, 2.4), (1.6, 1.4), (2.2, 1.4)])
    slant = np.array([[x, y, z] for y in (0.5, 1.3) for x, z in outline])
    part.solid(*convex_hull(slant))
    return _machined(part, 0.06, 9_000, (3.6, 0.8, 2.0), 1.2)


def even(make: Callable[[], MeshArrays], edge: float) -> MeshArrays:
    """Return a part with triangles of one size, as the literature's CAD models have them."""
    vertices, faces = make()
    return remeshed(vertices, faces, edge)


def _machined(part, edge, n_triangles, dense, radius, crease=25.0, least=1e-6) -> MeshArrays:
    vertices, faces = remeshed(*part.arrays(), 0.55 * edge, crease)
    return graded(vertices, faces, n_triangles, near(vertices, dense, radius, least))
