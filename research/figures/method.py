"""Picture of docs/method.md: `python -m research.figures.method`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from adaptive_fairing.core.loop.basis import evaluate_basis, table_depth
from adaptive_fairing.core.loop.patch_class import Corner, PatchClass, is_regular_patch
from adaptive_fairing.core.loop.patches import PatchSet
from adaptive_fairing.core.loop.quadrature import QuadratureChoice, quadrature_choice
from adaptive_fairing.core.loop.subdivision import refine
from adaptive_fairing.core.mesh.topology import TriangleTopology
from research.claims.plots import figure, save

from .layout import FOLDER

VALENCES = (4, 6, 9)
RINGS = 3
"""Two rings for the support of the function, and one that the patches of the second need."""

SAMPLES = 16
"""Points along a side of a triangle at which the function is drawn."""

INSET = 1e-3
"""Points keep this far from the corners, where the basis of an irregular patch is not evaluated."""

TOLERANCES = (1e-3, 1e-5)


def main() -> None:
    """Draw the picture into assets/figures."""
    drawing, axes = figure(len(VALENCES) + 1)
    for axis, valence in zip(axes, VALENCES, strict=False):
        _draw_function(axis, valence)
    _draw_points(axes[-1])
    save(drawing, FOLDER / "method.png")


def fan(valence: int):
    """Return a flat disc of triangles around vertex 0 of a given valence, all others regular."""
    index, positions = {(0, 0, 0): 0}, [(0.0, 0.0)]

    def vertex(sector: int, a: int, b: int) -> int:
        """Return the vertex a steps along one ray of a sector and b along the next."""
        if a == 0:
            sector, a, b = sector + 1, b, 0
        key = (sector % valence if a else 0, a, b)
        if key not in index:
            index[key] = len(positions)
            rays = 2 * np.pi * (np.array([sector, sector + 1])) / valence
            point = a * np.exp(1j * rays[0]) + b * np.exp(1j * rays[1])
            positions.append((point.real, point.imag))
        return index[key]

    triangles = []
    for sector in range(valence):
        for a in range(RINGS):
            for b in range(RINGS - a):
                one, right, up = (
                    vertex(sector, *place) for place in ((a, b), (a + 1, b), (a, b + 1))
                )
                triangles.append((one, right, up))
                if a + b + 1 < RINGS:
                    triangles.append((right, vertex(sector, a + 1, b + 1), up))
    flat = np.column_stack([positions, np.zeros(len(positions))])
    return flat, np.array(triangles, dtype=np.int32)


def _draw_function(axis, valence: int) -> None:
    vertices, triangles = fan(valence)
    patches = PatchSet(TriangleTopology(triangles, len(vertices)))
    steps = np.arange(SAMPLES + 1)
    i, j = (each.ravel() for each in np.meshgrid(steps, steps))
    lattice = np.stack([i, j], axis=1)[i + j <= SAMPLES] / SAMPLES
    points = INSET + (1 - 3 * INSET) * lattice
    xy, height = [], []
    for segment in patches.segments:
        values = evaluate_basis(patches.classes[segment.class_index], points)[0]
        for control in segment.control_points.T:
            xy.append(values @ vertices[control, :2])
            height.append(values @ (control == 0))
    xy, height = np.concatenate(xy), np.concatenate(height)
    axis.tricontourf(*xy.T, height, levels=np.linspace(1e-4, 0.6, 25), cmap="viridis")
    axis.triplot(*vertices[:, :2].T, triangles, color="0.5", linewidth=0.6)
    axis.set(title=f"basis function, valence {valence}", aspect="equal")
    axis.set_axis_off()


def _draw_points(axis) -> None:
    for shift, tolerance in zip((0.0, 1.15), TOLERANCES, strict=True):
        choice = quadrature_choice(tolerance)
        for lift, ring_size in ((0.0, 5), (1.05, 6)):
            patch_class = (Corner(ring_size), Corner(6), Corner(6))
            points = _points(patch_class, choice)
            corners = np.array([(0, 0), (1, 0), (0.5, 0.75**0.5), (0, 0)])
            place = np.array([shift, lift])
            axis.plot(*(corners + place).T, color="0.5", linewidth=0.8)
            flat = points @ (corners[1:3]) + place
            axis.plot(*flat.T, ".", color="C0", markersize=2)
            axis.text(shift, lift - 0.09, f"({ring_size}, 6, 6), {tolerance:g}", fontsize=7)
    axis.set(title="quadrature points", aspect="equal")
    axis.set_axis_off()


def _points(patch_class: PatchClass, choice: QuadratureChoice) -> NDArray[np.float64]:
    """Return the quadrature points (n, 2) of a patch in its own parameters."""
    if is_regular_patch(patch_class):
        return choice.regular.points
    return _refined(patch_class, choice.irregular.points, table_depth(patch_class, choice))


def _refined(patch_class, points, depth):
    if depth == 0 or is_regular_patch(patch_class):
        return points
    _, children = refine(patch_class)
    return np.concatenate(
        [
            (_refined(child.patch_class, points, depth - 1) - child.origin)
            @ np.linalg.inv(child.jacobian).T
            for child in children
        ]
    )


if __name__ == "__main__":
    main()
