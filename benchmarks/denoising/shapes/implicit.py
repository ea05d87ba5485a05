"""Zero sets of formulas and of the samples' solids, with dense and coarse places."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from skimage.measure import marching_cubes

from tools.samples.implicit import Solid, Tube
from tools.samples.meshing import dense_mesh

from ..geometry import FloatArray
from .meshing import MeshArrays, graded, near, remeshed, uneven

Field = Callable[[FloatArray], FloatArray]


LEVEL = 0.35
"""Of the molecule's density, at its surface."""


class Zeros:
    """Points where a formula is 0, inside a cube; negative inside, as `tools.samples` wants it."""

    def __init__(self, formula: Field, reach: float) -> None:
        self.distance = formula
        self.lower, self.upper = np.full(3, -reach), np.full(3, reach)


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

    vertices, faces = dense_mesh(Zeros(formula, 1.8), 0.02)
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
    """Make a piece of a minimal surface: saddles everywhere, open at the rim."""
    n, reach = 90, 2.9
    axis = np.linspace(-reach, reach, n)
    x, y, z = np.meshgrid(axis, axis, axis, indexing="ij")
    wave = np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x)
    vertices, faces, _, _ = marching_cubes(wave, 0.0)
    vertices = (2 * reach / (n - 1)) * vertices.astype(float) - reach
    vertices, faces = remeshed(vertices, faces, 0.07)
    return graded(vertices, faces, 12_000, near(vertices, (1, 0, 0), 1.2))
