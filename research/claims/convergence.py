"""Convergence on the sphere: eigenvalues, the shrinking radius, and order in time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.sparse.linalg import eigsh

from adaptive_fairing.core import LoopSpace, TriangleTopology, fair
from adaptive_fairing.core.mesh.density import smoothed
from tools.geometry.triangles import Faces, FloatArray, icosphere, local_edge_lengths

from .linear_elements import mass_matrix, stiffness_matrix
from .measures import UNIFORM
from .pairs import MeshPair
from .tables import Cell, Findings, Table

LEVELS = (2, 3, 4, 5)
EIGEN_DEGREES = (1, 2, 3)
TAU = 0.01
TIME_LEVEL, END, STEP_COUNTS = 3, 0.1, (2, 4, 8, 16, 32)
TIGHT = 1e-6
LIMIT_ROUNDS = 200
KRYLOV_VECTORS = 80


def run(pairs: Sequence[MeshPair]) -> Findings:
    """Measure spheres; the meshes play no part."""
    sizes, loop, linear, radius, energy = [], [], [], [], []
    for level in LEVELS:
        vertices, triangles = icosphere(level)
        sizes.append(float(local_edge_lengths(vertices, triangles).mean()))
        topology = TriangleTopology(triangles, len(vertices))
        control = interpolating(topology, vertices)
        space = LoopSpace(topology, TIGHT)
        loop.append(_eigen_errors(space.mass_matrix(control), space.stiffness_matrix(control)))
        linear.append(
            _eigen_errors(mass_matrix(vertices, triangles), stiffness_matrix(vertices, triangles))
        )
        radius.append(_radius_error(control, triangles, topology))
        energy.append(abs(space.measures(control).curvature_energy / (4 * np.pi) - 1))
    in_time = [_time_error(count) for count in STEP_COUNTS]
    return Findings(
        [_in_space(sizes, loop, linear, radius, energy), _in_time(in_time)],
        draw=lambda path: _draw(path, sizes, np.array(loop), np.array(linear), radius, in_time),
    )


def interpolating(topology: TriangleTopology, vertices: FloatArray) -> FloatArray:
    """Return the control points whose limit surface passes through the vertices.

    The limit mask is (3.6); its eigenvalues lie in (0, 1], so the plain iteration converges.
    """
    control = vertices.copy()
    for _ in range(LIMIT_ROUNDS):
        limit = np.stack([smoothed(topology, column, 1) for column in control.T], axis=1)
        control += vertices - limit
    return control


def _eigen_errors(mass, stiffness) -> list[float]:
    """Return the largest error of l (l + 1), relative, for every degree l."""
    degree = np.repeat(np.arange(4), 2 * np.arange(4) + 1)
    # Eigenvalues come in groups of equal ones, of which a small Krylov space can miss some.
    start = np.random.default_rng(0).standard_normal(mass.shape[0])
    options = {"sigma": -0.1, "v0": start, "ncv": KRYLOV_VECTORS, "return_eigenvectors": False}
    values = np.sort(eigsh(stiffness, len(degree), mass, **options))
    exact = degree * (degree + 1)
    return [
        float(np.abs(values[degree == k] / exact[degree == k] - 1).max()) for k in EIGEN_DEGREES
    ]


def _radius_error(control: FloatArray, triangles: Faces, topology: TriangleTopology) -> float:
    """Return the error of the radius after one step, which is 1 / (1 + 2 τ): Δx = -2 x / r²."""
    settings = UNIFORM.settings(
        TAU, 1, normalize=False, cg_tolerance=1e-12, quadrature_tolerance=TIGHT
    )
    radii = _limit_radii(topology, fair(control, triangles, settings).positions)
    return float(np.abs(radii * (1 + 2 * TAU) - 1).max())


def _time_error(steps: int) -> float:
    """Return the error of the mean radius at time `END`, which is √(1 - 4 t)."""
    vertices, triangles = icosphere(TIME_LEVEL)
    topology = TriangleTopology(triangles, len(vertices))
    settings = UNIFORM.settings(END / steps, steps, normalize=False, cg_tolerance=1e-10)
    result = fair(interpolating(topology, vertices), triangles, settings)
    radius = float(_limit_radii(topology, result.positions).mean())
    return abs(radius - (1 - 4 * END) ** 0.5)


def _limit_radii(topology: TriangleTopology, control: FloatArray) -> FloatArray:
    limit = np.stack([smoothed(topology, column, 1) for column in control.T], axis=1)
    return np.linalg.norm(limit, axis=1)


def orders(errors: Sequence[float]) -> list[float | None]:
    """Return the observed order between one entry and the next, twice as fine."""
    values = np.asarray(errors)
    return [None, *map(float, np.log2(values[:-1] / values[1:]))]


def _in_space(sizes, loop, linear, radius, energy) -> Table:
    last = EIGEN_DEGREES[-1]
    series = [[errors[-1] for errors in loop], [errors[-1] for errors in linear], radius, energy]
    rows: list[list[Cell]] = [
        [f"{size:.3f}", *(cell for pair in zip(row, order, strict=True) for cell in pair)]
        for size, row, order in zip(
            sizes, zip(*series, strict=True), zip(*map(orders, series), strict=True), strict=True
        )
    ]
    eigenvalue = f"eigenvalue {last * (last + 1)}"
    columns = (
        "edge length", f"{eigenvalue}, Loop", "order", f"{eigenvalue}, linear", "order",
        "radius after a step", "order", "curvature energy", "order",
    )  # fmt: skip
    return Table("Errors on the unit sphere", columns, rows)


def _in_time(errors: Sequence[float]) -> Table:
    rows: list[list[Cell]] = [
        list(row) for row in zip(map(str, STEP_COUNTS), errors, orders(errors), strict=True)
    ]
    return Table(f"Radius of the shrinking sphere at t = {END}", ("steps", "error", "order"), rows)


def _draw(path: Path, sizes, loop, linear, radius, in_time) -> None:
    from .plots import figure, save

    drawing, (left, middle, right) = figure(3)
    for index, degree in enumerate(EIGEN_DEGREES):
        value = degree * (degree + 1)
        left.loglog(sizes, linear[:, index], f"C{index}s--", label=f"{value}, linear")
        left.loglog(sizes, loop[:, index], f"C{index}o-", label=f"{value}, Loop")
    left.set(xlabel="edge length", title="relative error of eigenvalues l (l + 1)")
    left.legend(fontsize=7, frameon=False)
    middle.loglog(sizes, radius, "C3o-")
    for axis in (left, middle):
        axis.set_xticks(sizes, [f"{size:.2g}" for size in sizes])
        axis.minorticks_off()
    middle.set(xlabel="edge length", title="radius after one step, error")
    timesteps = END / np.array(STEP_COUNTS)
    right.loglog(timesteps, in_time, "C4o-")
    right.set_xticks(timesteps, [f"{timestep:.2g}" for timestep in timesteps])
    right.minorticks_off()
    right.set(xlabel="timestep", title=f"radius at t = {END:g}, error")
    save(drawing, path)
