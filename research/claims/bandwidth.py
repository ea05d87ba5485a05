"""Loop basis against linear elements in the same scheme: which wavelengths are damped how much.

Section 3.1.1 of the paper: "the reduction speed of high frequency noise in our approach is not that
drastic, but still fast, while the reduction speed of lower frequency noise is not slow. Hence, the
bandwidth of affected frequencies is wider."

On the plane's grid of equilateral triangles every row of a matrix is the same stencil. On the wave
exp(i k·x) it acts as a number, its symbol: m(k) for M, l(k) for L. One semi-implicit step with a
uniform T damps the wave by m / (m + T l).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu
from scipy.special import eval_legendre

from adaptive_fairing.core import LoopSpace, TriangleTopology
from tools.geometry.triangles import FloatArray, icosphere, local_edge_lengths

from .linear_elements import fair_linear, mass_matrix, stiffness_matrix
from .measures import TIMESTEP, DensityClasses, root_mean_square
from .pairs import MeshPair
from .shapes import flat_hexagon
from .tables import Cell, Findings, Table

RADIUS = 1.0
"""Smoothing radius sqrt(2T) of the one step, in edge lengths."""

WAVELENGTHS = (1.75, 2.0, 2.5, 3.0, 4.0, 6.0, 10.0, 20.0, 40.0)
ACROSS_EDGES = np.pi / 6
"""Direction of the waves on the plane: at right angles to edges, down to √3 edge lengths."""

RINGS = 5
"""Size of the flat grid: the centre's row of a matrix reaches two rings."""

SPHERE_LEVEL = 4
DEGREES = (2, 4, 8, 16, 24, 32, 40, 48)
TIGHT = 1e-6


class Damping(NamedTuple):
    """Damping factors of one step, one for every wavelength."""

    wavelengths: FloatArray
    exact: FloatArray
    loop: FloatArray
    linear: FloatArray


def run(pairs: Sequence[MeshPair]) -> Findings:
    """Measure waves on the plane and on the sphere, then the meshes with either kind of element."""
    plane, sphere = plane_damping(np.array(WAVELENGTHS)), sphere_damping(DEGREES)
    tables = [
        _waves("plane", plane),
        _waves("sphere of 2562 vertices, waves are zonal harmonics", sphere),
        _meshes(pairs),
    ]
    return Findings(tables, draw=_draw)


def plane_damping(wavelengths: FloatArray) -> Damping:
    """Damp waves on the grid of unit edges, with the symbols of the assembled matrices."""
    positions, triangles = flat_hexagon(RINGS)
    space = LoopSpace(TriangleTopology(triangles, len(positions)), TIGHT)
    waves = wave_vector(wavelengths, ACROSS_EDGES)
    time = 0.5 * RADIUS**2
    factors = []
    for mass, stiffness in (
        (space.mass_matrix(positions), space.stiffness_matrix(positions)),
        (mass_matrix(positions, triangles), stiffness_matrix(positions, triangles)),
    ):
        m, s = (measured_symbol(each, positions, 0, waves) for each in (mass, stiffness))
        factors.append(m / (m + time * s))
    exact = 1 / (1 + time * np.sum(waves**2, axis=1))
    return Damping(wavelengths, exact, *factors)


def wave_vector(wavelength: FloatArray, angle: float) -> FloatArray:
    """Return k (n, 2) of waves of given lengths that run at an angle to an edge direction."""
    size = 2 * np.pi / np.asarray(wavelength, dtype=float)
    return size[:, None] * np.array([np.cos(angle), np.sin(angle)])


def measured_symbol(
    matrix: sparse.csr_array, positions: FloatArray, centre: int, waves: FloatArray
) -> FloatArray:
    """Return the symbol of a matrix from the row of one vertex that is far from the boundary."""
    row = matrix[[centre], :].tocoo()
    offset = positions[row.col, :2] - positions[centre, :2]
    return np.cos(waves @ offset.T) @ row.data


def sphere_damping(degrees: Sequence[int]) -> Damping:
    """Damp zonal harmonics on an icosphere: (y, S y) / (y, y) in the mass matrix's product."""
    positions, triangles = icosphere(SPHERE_LEVEL)
    edge = float(local_edge_lengths(positions, triangles).mean())
    time = 0.5 * (RADIUS * edge) ** 2
    space = LoopSpace(TriangleTopology(triangles, len(positions)), TIGHT)
    values = np.stack([eval_legendre(degree, positions[:, 2]) for degree in degrees], axis=1)
    eigenvalues = np.array([degree * (degree + 1.0) for degree in degrees])
    factors = []
    for mass, stiffness in (
        (space.mass_matrix(positions), space.stiffness_matrix(positions)),
        (mass_matrix(positions, triangles), stiffness_matrix(positions, triangles)),
    ):
        damped = splu((mass + time * stiffness).tocsc()).solve(mass @ values)
        factors.append(
            np.sum(values * (mass @ damped), axis=0) / np.sum(values * (mass @ values), axis=0)
        )
    wavelengths = 2 * np.pi / np.sqrt(eigenvalues) / edge
    return Damping(wavelengths, 1 / (1 + time * eigenvalues), *factors)


def _waves(what: str, damping: Damping) -> Table:
    rows: list[list[Cell]] = [
        [f"{wavelength:.3g}", *map(float, factors)]
        for wavelength, *factors in zip(*damping, strict=True)
    ]
    return Table(
        f"Damping factor of one step with smoothing radius {RADIUS:g} edge on the {what}",
        ("wavelength, edge lengths", "exact", "Loop basis", "linear elements"),
        rows,
    )


def _meshes(pairs: Sequence[MeshPair]) -> Table:
    rows: list[list[Cell]] = []
    for pair in pairs:
        classes: DensityClasses = pair.classes
        tau, steps = pair.published.adaptive, pair.published.steps
        for divisor in (1, 4, 16):
            loop = TIMESTEP.faired(pair.noisy, pair.triangles, tau / divisor, steps)
            linear = fair_linear(pair.noisy, pair.triangles, tau / divisor, steps)
            loop_errors, linear_errors = (
                classes.by_fifth(result, pair.clean) for result in (loop, linear)
            )
            rows.append(
                [
                    f"{pair.name}, τ = {tau / divisor:.3g}",
                    root_mean_square(loop_errors),
                    root_mean_square(linear_errors),
                    max(loop_errors),
                    max(linear_errors),
                    classes.distance(loop, linear) / classes.distance(loop, pair.noisy),
                ]
            )
    columns = (
        "mesh", "mean error, Loop", "linear", "worst error, Loop", "linear", "difference / move",
    )  # fmt: skip
    return Table("Adaptive timestep, edge density, with either kind of element", columns, rows)


def _draw(path: Path) -> None:
    from .plots import figure, save

    plane = plane_damping(np.geomspace(3**0.5, WAVELENGTHS[-1], 120))
    sphere = sphere_damping(range(2, DEGREES[-1] + 1))

    drawing, axes = figure(2)
    for axis, damping, name in zip(axes, (plane, sphere), ("plane", "sphere"), strict=True):
        axis.semilogx(damping.wavelengths, damping.exact, color="0.7", label="exact", linewidth=5)
        axis.semilogx(damping.wavelengths, damping.loop, color="C0", label="Loop basis")
        axis.semilogx(damping.wavelengths, damping.linear, color="C1", label="linear elements")
        axis.set(
            xlabel="wavelength, edge lengths",
            title=f"damping factor of one step, {name}",
            ylim=(0, 1),
        )
        axis.set_xticks([2, 3, 5, 10, 20, 40], ["2", "3", "5", "10", "20", "40"])
        axis.minorticks_off()
    axes[0].legend(frameon=False)
    save(drawing, path)
