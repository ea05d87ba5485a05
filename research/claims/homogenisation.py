"""Homogenisation of triangles by the diffusion tensor (section 3.3 of the paper)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from adaptive_fairing.core import fair
from tools.geometry.triangles import Faces, FloatArray, corner_angles, density_ratio, triangle_areas

from .measures import TENSOR, TIMESTEP, UNIFORM, DensityClasses
from .pairs import MeshPair
from .shapes import graded_hexagon
from .tables import Cell, Findings, Table

COLUMNS = (
    "mesh", "smallest angle, 1st percentile", "mean quality", "smallest triangles",
    "density ratio", "move along the surface", "move along the normals",
)  # fmt: skip
DISC_RINGS, DISC_RATIO, DISC_TAU = 12, 15.0, 0.01
DISC_STEPS = (1, 5, 20)
TIGHT = 1e-6
SMALLEST_FRACTION = 0.001


def run(pairs: Sequence[MeshPair]) -> Findings:
    """Measure a flat disc with a dense centre, then the meshes at the paper's τ."""
    return Findings([_flat_disc(), *map(_table, pairs)])


def _flat_disc() -> Table:
    """On a plane the curvature is zero: whatever moves there moves along the surface."""
    vertices, triangles = graded_hexagon(DISC_RINGS, DISC_RATIO)
    area = triangle_areas(vertices, triangles)
    smallest = np.argmin(area)
    rows: list[list[Cell]] = []
    for scheme in (UNIFORM, TIMESTEP, TENSOR):
        tight = {"cg_tolerance": 1e-12, "quadrature_tolerance": TIGHT}
        settings = scheme.settings(DISC_TAU, max(DISC_STEPS), normalize=False, **tight)
        steps = fair(vertices, triangles, settings).steps
        for count in DISC_STEPS:
            positions = steps[count - 1].positions
            rows.append(
                [
                    f"{scheme.label}, step {count}",
                    float(triangle_areas(positions, triangles)[smallest] / area[smallest]),
                    density_ratio(positions, triangles),
                    float(np.linalg.norm(positions - vertices, axis=1).max()),
                ]
            )
    return Table(
        f"A flat disc of radius 1 with a dense centre, τ = {DISC_TAU}, boundary fixed "
        f"(density ratio before: {density_ratio(vertices, triangles):.1f})",
        ("scheme", "smallest triangle, area after / before", "density ratio", "largest move"),
        rows,
    )


def _table(pair: MeshPair) -> Table:
    run_of = pair.published
    rows = [_row(pair, "clean", pair.clean), _row(pair, "input", pair.noisy)]
    for scheme in (UNIFORM, TIMESTEP, TENSOR):
        tau = run_of.tau(scheme.method)
        result = scheme.faired(pair.noisy, pair.triangles, tau, run_of.steps)
        rows.append(_row(pair, f"{scheme.label}, τ = {tau:g}", result))
    return Table(f"{pair.name}, {run_of.steps} steps", COLUMNS, rows)


def _row(pair: MeshPair, name: str, positions: FloatArray) -> list[Cell]:
    classes: DensityClasses = pair.classes
    length = np.linalg.norm(positions - pair.noisy, axis=1) / classes.lengths
    normal = classes.heights(positions, pair.noisy)
    tangential = np.maximum(length**2 - normal**2, 0)
    smallest = np.quantile(triangle_areas(positions, pair.triangles), SMALLEST_FRACTION)
    reference = np.quantile(triangle_areas(pair.clean, pair.triangles), SMALLEST_FRACTION)
    return [
        name,
        float(np.percentile(corner_angles(positions, pair.triangles).min(axis=1), 1)),
        float(quality(positions, pair.triangles).mean()),
        float(smallest / reference),
        density_ratio(positions, pair.triangles),
        float(np.sqrt(tangential.mean())),
        float(np.sqrt(np.mean(normal**2))),
    ]


def quality(vertices: FloatArray, triangles: Faces) -> FloatArray:
    """Return twice the inscribed over the circumscribed radius (m,): 1 is equilateral, 0 flat."""
    corners = vertices[triangles]
    sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    area = triangle_areas(vertices, triangles)
    # r = 2 area / (a + b + c) and R = abc / (4 area).
    product = sides.prod(axis=1) * sides.sum(axis=1)
    return 16 * area**2 / np.maximum(product, np.finfo(float).tiny)
