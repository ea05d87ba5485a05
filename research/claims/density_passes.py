"""Influence of the smoothing passes (3.6) over the density."""

from __future__ import annotations

from collections.abc import Sequence

from adaptive_fairing.core import fair

from .measures import TIMESTEP, TIMESTEP_AREA, Scheme, matched_tau, root_mean_square
from .pairs import MeshPair
from .tables import Findings, Table

PASSES = (0, 1, 2, 3, 5, 10)
PAPER_PASSES = 3
COLUMNS = ("mesh, density", "τ", *map(str, PASSES))


def run(pairs: Sequence[MeshPair]) -> Findings:
    """Fair at the paper's τ, and with area density at equally smooth coarse parts."""
    errors, differences = [], []
    for pair in pairs:
        steps = pair.published.steps
        area_tau = matched_tau(TIMESTEP_AREA, pair.noisy, pair.clean, pair.classes, steps)
        for scheme, tau in ((TIMESTEP, pair.published.adaptive), (TIMESTEP_AREA, area_tau)):
            results = _results(pair, scheme, tau)
            usual = results[PASSES.index(PAPER_PASSES)]
            move = pair.classes.distance(usual, pair.noisy)
            name = f"{pair.name}, {scheme.label.split()[-1]}"
            errors.append(
                [name, tau]
                + [root_mean_square(pair.classes.by_fifth(r, pair.clean)) for r in results]
            )
            differences.append(
                [name, tau] + [pair.classes.distance(result, usual) / move for result in results]
            )
    return Findings(
        [
            Table("Mean error by passes of (3.6), in local edge lengths", COLUMNS, errors),
            Table("Difference from three passes, relative to the move", COLUMNS, differences),
        ]
    )


def _results(pair: MeshPair, scheme: Scheme, tau: float):
    return [
        fair(
            pair.noisy,
            pair.triangles,
            scheme.settings(tau, pair.published.steps, density_passes=passes),
        ).positions
        for passes in PASSES
    ]
