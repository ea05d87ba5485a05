"""Zero sets of formulas and of the samples' solids, with dense and coarse places."""

from __future__ import annotations

import numpy as np
from skimage.measure import marching_cubes

from research.samples.implicit import Ellipsoid, Formula, Solid, Tube, rotation, smooth_minimum
from research.samples.meshing import dense_mesh
from tools.geometry.triangles import FloatArray

from ..walls import PERIODIC
from .meshing import MeshArrays, graded, near, remeshed, uneven

LEVEL = 0.35
"""Of the molecule's density, at its surface."""


def coral() -> MeshArrays:
    """Make tubes that branch and thin out from a foot, dense at the tips."""
    generator = np.random.default_rng(5)
    solid = Solid()
    _branch(solid, generator, np.zeros(3), np.array([0.0, 0.0, 1.0]), 0.42, 4)
    vertices, faces = dense_mesh(solid, 0.035)
    return uneven(vertices, faces, 16_000, np.clip(0.35 * vertices[:, 2] - 0.1, 0, 1))


def _branch(solid, generator, start, direction, radius, depth) -> None:
    bend = direction + 0.25 * generator.normal(size=3)
    length = 4.2 * radius + 0.35
    end = start + length * bend / np.linalg.norm(bend)
    middle = (start + end) / 2 + 0.1 * length * generator.normal(size=3)
    tube = Tube(np.stack([start, middle, end]), (radius, 0.85 * radius, 0.72 * radius))
    solid.add(tube, 0.5 * radius)
    for _ in range(2 if depth else 0):
        turned = direction + 0.9 * generator.normal(size=3) + [0, 0, 0.4]
        turned /= np.linalg.norm(turned)
        _branch(solid, generator, end, turned, 0.68 * radius, depth - 1)


def pebble() -> MeshArrays:
    """Make a smooth lump with fine ripples on one side, where it is also meshed finely."""

    def formula(points: FloatArray) -> FloatArray:
        x, y, z = (points / [1.3, 1.0, 0.8]).T
        swell = 0.12 * np.sin(2.1 * x + 1) * np.cos(1.7 * y) + 0.08 * np.sin(3.1 * z + x)
        side = np.exp(-4 * ((x - 1) ** 2 + y**2 + z**2))
        ripples = 0.05 * side * np.sin(17 * y) * np.cos(17 * z)
        return 0.8 * (np.sqrt(x * x + y * y + z * z) - 1 - swell - ripples)

    reach = np.full(3, 1.8)
    vertices, faces = dense_mesh(Formula(formula, -reach, reach), 0.02)
    return uneven(vertices, faces, 14_000, near(vertices, (1.3, 0, 0), 0.7, 0.06))


def molecule() -> MeshArrays:
    """Make a sum of Gaussian atoms by marching cubes, as it comes: slivers and all."""
    generator = np.random.default_rng(8)
    step, atoms = np.array([0.0, 0.0, 0.0]), []
    for _ in range(42):
        turn = generator.normal(size=3) - 0.05 * step
        step = step + 0.95 * turn / np.linalg.norm(turn)
        atoms.append(step)
    atoms = np.array(atoms)
    low, cell = atoms.min(axis=0) - 1.7, 0.16
    shape = np.ceil((atoms.max(axis=0) + 1.7 - low) / cell).astype(int)
    lattice = low + cell * np.stack(np.indices(shape), axis=-1)
    density = np.zeros(shape)
    for atom, size in zip(atoms, generator.uniform(0.45, 0.75, len(atoms)), strict=True):
        density += np.exp(-np.sum(np.square((lattice - atom) / size), axis=-1))
    # No corner of a triangle comes closer to a lattice point than some hundredths of a cell.
    gap = density - LEVEL
    density = LEVEL + np.copysign(np.maximum(np.abs(gap), 0.004), gap)
    vertices, faces, _, _ = marching_cubes(density, LEVEL)
    return low + cell * vertices.astype(float), faces[:, ::-1].astype(np.int32)


def gyroid() -> MeshArrays:
    """Make a piece of a minimal surface: saddles everywhere, open at the boundary."""
    n, reach = 90, 2.9
    axis = np.linspace(-reach, reach, n)
    x, y, z = np.meshgrid(axis, axis, axis, indexing="ij")
    vertices, faces, _, _ = marching_cubes(PERIODIC["gyroid"](x, y, z), 0.0)
    vertices = (2 * reach / (n - 1)) * vertices.astype(float) - reach
    vertices, faces = remeshed(vertices, faces, 0.07)
    return graded(vertices, faces, 12_000, near(vertices, (1, 0, 0), 1.2))


def octopus() -> MeshArrays:
    """Make a body with eyes, warts and eight arms that thin out, dense at the head."""
    generator = np.random.default_rng(21)
    solid = Solid()
    solid.add(Ellipsoid((0, 0.35, 1.55), (0.75, 0.8, 1.0), rotation(25, "x")))
    solid.add(Ellipsoid((0, -0.1, 0.65), (0.6, 0.62, 0.5)), 0.35)
    for k in range(8):
        angle = np.pi * (k + 0.5) / 4
        swing, curl = generator.uniform(-0.3, 0.3), generator.uniform(0.2, 0.9)
        share = np.linspace(0, 1, 7)
        turn, reach = angle + swing * share**2, 0.3 + 2.1 * share
        lift = 0.4 * (1 - share) ** 2 + curl * share**3
        arm = np.stack([reach * np.cos(turn), reach * np.sin(turn), lift], axis=1)
        solid.add(Tube(arm, 0.27 - 0.22 * share), 0.18)
    for side in (-1, 1):
        solid.add(Ellipsoid((0.4 * side, -0.5, 0.95), (0.2, 0.2, 0.2)), 0.08)
        solid.carve(Ellipsoid((0.47 * side, -0.68, 0.98), (0.07, 0.07, 0.03)), 0.03)
    for _ in range(60):
        way = generator.normal(size=3)
        spot = np.array([0, 0.35, 1.6]) + way / np.linalg.norm(way) * [0.74, 0.84, 0.9]
        size = generator.uniform(0.07, 0.13)
        solid.add(Ellipsoid(spot, (size, size, size)), 0.1)
    vertices, faces = dense_mesh(solid, 0.026)
    return uneven(vertices, faces, 30_000, near(vertices, (0, -0.5, 0.95), 1.0, 0.25))


def mask() -> MeshArrays:
    """Make a face with open eyes and an open boundary, as a scan from the front."""
    solid = Solid()
    solid.add(Ellipsoid((0, 0, 0), (0.82, 0.66, 1.1)))
    solid.add(Ellipsoid((0, -0.38, -0.75), (0.42, 0.3, 0.3)), 0.3)
    solid.add_pair(Ellipsoid((0.4, -0.4, -0.2), (0.26, 0.22, 0.24)), 0.2)
    solid.add_pair(Tube([(0.1, -0.62, 0.3), (0.32, -0.58, 0.36), (0.56, -0.4, 0.26)], 0.07), 0.12)
    solid.carve_pair(Ellipsoid((0.3, -0.66, 0.14), (0.21, 0.16, 0.12)), 0.12)
    solid.add(Tube([(0, -0.62, 0.3), (0, -0.7, 0.0), (0, -0.76, -0.2)], (0.07, 0.08, 0.11)), 0.1)
    solid.add_pair(Ellipsoid((0.1, -0.66, -0.23), (0.07, 0.09, 0.06)), 0.06)
    solid.carve_pair(Ellipsoid((0.06, -0.74, -0.31), (0.035, 0.05, 0.03)), 0.03)
    for height, size in ((-0.48, 0.05), (-0.58, 0.06)):
        lip = [(-0.24, -0.56, -0.53), (0, -0.7, height), (0.24, -0.56, -0.53)]
        solid.add(Tube(lip, (0.02, size, 0.02)), 0.05)
    vertices, faces = dense_mesh(solid, 0.025)
    is_eye = np.square((np.abs(vertices[:, 0]) - 0.3) / 0.13) + np.square(
        (vertices[:, 2] - 0.14) / 0.055
    )
    x, y, z = vertices.T
    kept = (y < 0.12 + 0.05 * np.sin(5 * z) + 0.03 * np.cos(9 * x)) & ((is_eye > 1) | (y > 0))
    faces = faces[kept[faces].all(axis=1)]
    vertices, faces = remeshed(vertices, faces, 0.024, 60.0)
    return graded(vertices, faces, 20_000, near(vertices, (0, -0.8, -0.1), 0.45, 0.01))


def coin() -> MeshArrays:
    """Make a struck coin: a raised rim, a ring of beads, a star with rays, fine letters."""
    generator = np.random.default_rng(4)
    strokes = generator.uniform(0.6, 1.4, 16)

    def relief(x: FloatArray, y: FloatArray) -> FloatArray:
        radius, angle = np.hypot(x, y), np.arctan2(y, x)
        rim = 0.07 / (1 + np.exp(-(radius - 1.78) / 0.02))
        bead = np.hypot(radius - 1.64, 1.64 * (np.mod(angle, np.pi / 30) - np.pi / 60))
        beads = 0.05 * np.exp(-((bead / 0.05) ** 2))
        star = 0.14 * np.exp(-((radius / (0.55 + 0.2 * np.cos(5 * angle))) ** 6))
        rays = 0.03 * np.cos(40 * angle) * np.exp(-(((radius - 1.0) / 0.14) ** 4))
        cell = np.floor(angle / (np.pi / 8)).astype(int) % 16
        across = np.mod(angle, np.pi / 8) / (np.pi / 8) - 0.5
        stroke = np.cos(14 * strokes[cell] * across) * np.cos(16 * strokes[cell] * (radius - 1.36))
        letters = 0.03 * np.tanh(3 * stroke) * np.exp(-(((radius - 1.38) / 0.13) ** 6))
        return rim + beads + star + rays + letters * np.exp(-((across / 0.4) ** 6))

    def formula(points: FloatArray) -> FloatArray:
        x, y, z = points.T
        top, bottom = z - 0.1 - relief(x, y), -0.1 - z
        side = np.hypot(x, y) - 2 + 0.015 * np.cos(90 * np.arctan2(y, x))
        return -smooth_minimum(smooth_minimum(-top, -side, 0.06), -bottom, 0.06)

    reach = np.array([2.05, 2.05, 0.35])
    vertices, faces = dense_mesh(Formula(formula, -reach, reach), 0.024)
    front = np.clip(4 * vertices[:, 2], 0, 1)
    return uneven(vertices, faces, 36_000, 0.02 + 0.98 * front)


def protein() -> MeshArrays:
    """Make a union of balls along a chain by marching tetrahedra, as it comes."""
    generator = np.random.default_rng(17)
    place, way, solid = np.zeros(3), np.zeros(3), Solid()
    for _ in range(64):
        turn = generator.normal(size=3) + 0.4 * way - 0.12 * place
        way = turn / np.linalg.norm(turn)
        place = place + 1.1 * way
        size = generator.choice([0.75, 0.95, 1.1])
        solid.add(Ellipsoid(place, (size, size, size)), 0.12)
    return dense_mesh(solid, 0.22)
