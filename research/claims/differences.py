"""Differences between two schemes on one mesh, at three choices of τ.

The adaptive timestep against the adaptive tensor (section 3.3, Fig 4.1), and the mean edge length
against the ring area as the measure of density (section 3.2).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize_scalar

from adaptive_fairing.core.diffusion.smoothing_radius import radius_scale, suggest_tau

from .measures import (
    TENSOR,
    TENSOR_AREA,
    TIMESTEP,
    TIMESTEP_AREA,
    Scheme,
    matched_tau,
    root_mean_square,
)
from .pairs import MeshPair
from .tables import Cell, Findings, Table

RADII = (0.2, 4.0)
"""Smoothing radii between which the best τ is looked for, in local edge lengths."""

COLUMNS = (
    "mesh, choice of τ", "τ", "move", "difference", "difference / move", "mean error",
    "worst error",
)  # fmt: skip


def two_schemes(pairs: Sequence[MeshPair]) -> Findings:
    """Compare the two schemes with either density measure."""
    schemes = ((TIMESTEP, TENSOR), (TIMESTEP_AREA, TENSOR_AREA))
    return Findings([difference_table(pairs, *two) for two in schemes])


def density_measures(pairs: Sequence[MeshPair]) -> Findings:
    """Compare the two measures of density in the timestep scheme."""
    return Findings([difference_table(pairs, TIMESTEP, TIMESTEP_AREA)])


def difference_table(pairs: Sequence[MeshPair], first: Scheme, second: Scheme) -> Table:
    """Compare two schemes at the paper's τ, with equally smooth coarse parts, and at their best.

    Moves, differences and errors are RMS distances along the normals in local edge lengths; mean
    and worst are over the five density classes.
    """
    rows: list[list[Cell]] = []
    for pair in pairs:
        steps = pair.published.steps
        choices = {
            "the paper's": lambda scheme, pair=pair: pair.published.tau(scheme.method),
            "equally smooth": lambda scheme, pair=pair, steps=steps: matched_tau(
                scheme, pair.noisy, pair.clean, pair.classes, steps
            ),
            "least error": lambda scheme, pair=pair: best_tau(pair, scheme),
        }
        for name, choice in choices.items():
            rows.append(_row(pair, f"{pair.name}, {name}", (first, second), choice))
    return Table(f"{first.label} against {second.label}: A / B", COLUMNS, rows)


def best_tau(pair: MeshPair, scheme: Scheme) -> float:
    """Return the τ with the least mean error over the density classes."""
    steps = pair.published.steps
    scale = radius_scale(pair.noisy, pair.triangles, scheme.settings(1.0, steps))
    bounds = [np.log(suggest_tau(scale, radius, steps)) for radius in RADII]

    def error(log_tau: float) -> float:
        moved = scheme.faired(pair.noisy, pair.triangles, float(np.exp(log_tau)), steps)
        return root_mean_square(pair.classes.by_fifth(moved, pair.clean))

    found = minimize_scalar(error, bounds=bounds, method="bounded", options={"xatol": 0.05})
    return float(np.exp(found.x))


def _row(pair, name, schemes, choice) -> list[Cell]:
    taus = tuple(choice(scheme) for scheme in schemes)
    results = [
        scheme.faired(pair.noisy, pair.triangles, tau, pair.published.steps)
        for scheme, tau in zip(schemes, taus, strict=True)
    ]
    moves = tuple(pair.classes.distance(result, pair.noisy) for result in results)
    difference = pair.classes.distance(*results)
    errors = [pair.classes.by_fifth(result, pair.clean) for result in results]
    return [
        name,
        taus,
        moves,
        difference,
        difference / max(moves),
        tuple(map(root_mean_square, errors)),
        tuple(map(max, errors)),
    ]
