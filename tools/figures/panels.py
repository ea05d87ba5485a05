"""The panels that all three figures share: the paper's settings, then equal smoothness."""

from __future__ import annotations

from pathlib import Path

from claims.measures import TENSOR, TIMESTEP, TIMESTEP_AREA, UNIFORM, Scheme, matched_tau
from claims.pairs import sample_pair

from .layout import Panel

ROOT = Path(__file__).resolve().parents[2]
TITLES = {
    UNIFORM: "Uniform timestep",
    TIMESTEP: "Adaptive timestep",
    TIMESTEP_AREA: "Adaptive timestep, area",
    TENSOR: "Adaptive tensor",
}


class Comparison:
    """One noisy sample mesh, and its panels at given settings."""

    def __init__(self, name: str) -> None:
        self.pair = sample_pair(name)
        self.triangles = self.pair.triangles

    def input(self) -> Panel:
        """Return the noisy input."""
        return Panel(self.pair.noisy, "Input", self._errors(self.pair.noisy))

    def at(self, scheme: Scheme, tau: float, steps: int, show: int | None = None) -> Panel:
        """Return the surface after `show` (or all) of the steps at the given τ."""
        count = show or steps
        positions = scheme.faired(self.pair.noisy, self.triangles, tau, count)
        plural = "step" if count == 1 else "steps"
        title = f"{TITLES[scheme]}, τ = {tau:.3g}, {count} {plural}"
        return Panel(positions, title, self._errors(positions))

    def matched(self, scheme: Scheme, steps: int) -> Panel:
        """Return the surface at the τ that leaves the coarse parts as rough as without noise."""
        pair = self.pair
        tau = matched_tau(scheme, pair.noisy, pair.clean, pair.classes, steps)
        return self.at(scheme, tau, steps)

    def _errors(self, positions) -> str:
        classes, clean = self.pair.classes, self.pair.clean
        coarse = classes.distance(positions, clean, classes.coarse)
        dense = classes.distance(positions, clean, classes.dense)
        return f"error: coarse part {coarse:.2f}, dense part {dense:.2f} edge lengths"
