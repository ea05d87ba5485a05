"""The curvature energy H(t) over the steps, and where (3.10) and (3.11) stop the evolution."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from adaptive_fairing.core import FairingResult, fair
from tools.geometry.noise import add_noise
from tools.geometry.triangles import normals

from .measures import TIMESTEP, root_mean_square
from .pairs import MeshPair
from .tables import Cell, Findings, Table

STEPS = 12
CURVATURE_BOUNDS = (0.5, 0.2, 0.1, 0.05)
"""ε2 of (3.11)."""

RATE_FRACTIONS = (0.5, 0.2, 0.1, 0.05)
"""ε1 of (3.10), as fractions of the rate |H'| of the first step."""

NOISE = (0.0, 0.2, 0.4, 0.8, 1.6)
"""Strengths of noise for the table of folded triangles, in local edge lengths."""

SEED = 5


@dataclass(frozen=True)
class Course:
    """One run: H(t)/H(0) and the mean error over the density classes, after every step."""

    pair: MeshPair
    tau: float
    energy: list[float]
    errors: list[float]

    @property
    def title(self) -> str:
        """Mesh and τ."""
        return f"{self.pair.name}, τ = {self.tau:g}"


def run(pairs: Sequence[MeshPair]) -> Findings:
    """Follow H over the steps at the paper's adaptive τ and at a quarter of it."""
    courses = [
        _course(pair, tau)
        for pair in pairs
        for tau in (pair.published.adaptive, pair.published.adaptive / 4)
    ]
    tables = [_energies(courses), _stops(courses), _folds(pairs)]
    return Findings(tables, draw=lambda path: _draw(path, courses))


def curvature_stop(energy: Sequence[float], bound: float) -> int | None:
    """Return after which step (3.11) stops: the first with H(t)/H(0) ≤ bound; None for never."""
    return next((k for k, value in enumerate(energy, 1) if value <= bound), None)


def rate_stop(energy: Sequence[float], tau: float, bound: float) -> int | None:
    """Return after which step (3.10) stops: the first with |ΔH| / τ ≤ bound; None for never."""
    rates = np.abs(np.diff([1.0, *energy])) / tau
    return next((k for k, rate in enumerate(rates, 1) if rate <= bound), None)


def _course(pair: MeshPair, tau: float) -> Course:
    result = fair(pair.noisy, pair.triangles, TIMESTEP.settings(tau, STEPS))
    errors = [
        root_mean_square(pair.classes.by_fifth(step.positions, pair.clean)) for step in result.steps
    ]
    return Course(pair, tau, energies(result), errors)


def energies(result: FairingResult) -> list[float]:
    """Return H(t)/H(0) after every step."""
    return [step.curvature_ratio for step in result.steps]


def _energies(courses: Sequence[Course]) -> Table:
    columns = ("mesh", *(f"step {k}" for k in range(1, STEPS + 1)))
    return Table(
        "H(t)/H(0), adaptive timestep, edge density",
        columns,
        [[course.title, *course.energy] for course in courses],
    )


def _stops(courses: Sequence[Course]) -> Table:
    columns = (
        "mesh",
        *(f"ε2 = {bound:g}" for bound in CURVATURE_BOUNDS),
        *(f"ε1 = {fraction:.0%}" for fraction in RATE_FRACTIONS),
        "least error at step",
    )
    rows: list[list[Cell]] = []
    for course in courses:
        first_rate = abs(course.energy[0] - 1.0) / course.tau
        rows.append(
            [
                course.title,
                *(curvature_stop(course.energy, bound) for bound in CURVATURE_BOUNDS),
                *(
                    rate_stop(course.energy, course.tau, fraction * first_rate)
                    for fraction in RATE_FRACTIONS
                ),
                int(np.argmin(course.errors)) + 1,
            ]
        )
    return Table(
        "Step at which (3.11), H ≤ ε2, and (3.10), |H'| ≤ ε1 as a fraction of the first "
        f"step's |H'|, stop (–: not within {STEPS} steps)",
        columns,
        rows,
    )


def _folds(pairs: Sequence[MeshPair]) -> Table:
    rows: list[list[Cell]] = []
    for pair in pairs:
        outward = normals(pair.clean, pair.triangles)
        for strength in NOISE:
            noisy = add_noise(pair.clean, pair.triangles, strength, SEED)
            folded = np.einsum("md,md->m", normals(noisy, pair.triangles), outward) < 0
            result = fair(noisy, pair.triangles, TIMESTEP.settings(pair.published.adaptive, STEPS))
            history = np.array([1.0, *energies(result)])
            rows.append(
                [
                    f"{pair.name}, noise {strength:g}",
                    int(folded.sum()),
                    float(history.min()),
                    int(np.argmin(history)),
                    float(history[-1]),
                    int(np.sum(np.diff(history) > 0)),
                ]
            )
    columns = (
        "mesh, noise in local edge lengths",
        "folded triangles",
        "least H(t)/H(0)",
        "at step",
        f"H(t)/H(0) after {STEPS} steps",
        "steps in which H rises",
    )
    return Table("H where triangles are folded over, the paper's τ", columns, rows)


def _draw(path: Path, courses: Sequence[Course]) -> None:
    from .plots import figure, save

    drawing, (left, right) = figure(2)
    for index, course in enumerate(courses):
        style = {
            "color": f"C{index // 2}",
            "linestyle": "--" if index % 2 else "-",
            "marker": "o",
            "markersize": 3,
            "label": course.title,
        }
        steps = range(len(course.energy) + 1)
        left.semilogy(steps, [1.0, *course.energy], **style)
        start = root_mean_square(course.pair.classes.by_fifth(course.pair.noisy, course.pair.clean))
        right.plot(steps, [start, *course.errors], **style)
    left.set(xlabel="step", title="curvature energy H(t) / H(0)")
    right.set(xlabel="step", title="mean error, local edge lengths")
    right.legend(fontsize=7, frameon=False)
    save(drawing, path)
