"""The panels that all three figures share: the paper's settings, then equal smoothness."""

from __future__ import annotations

from pathlib import Path

from samples.ply import read_ply

from .comparison import DensityClasses, faired, matched_tau
from .layout import Panel

ROOT = Path(__file__).resolve().parents[2]
SCHEMES = {
    "uniform": "Uniform timestep",
    "adaptive_timestep": "Adaptive timestep",
    "adaptive_tensor": "Adaptive tensor",
}


class Comparison:
    """One noisy sample mesh, and its panels at given settings."""

    def __init__(self, name: str) -> None:
        self.clean, self.triangles = read_ply(ROOT / "assets" / f"{name}.ply")
        self.noisy, _ = read_ply(ROOT / "assets" / f"{name}_noisy.ply")
        self.classes = DensityClasses(self.clean, self.triangles)

    def input(self) -> Panel:
        """Return the noisy input."""
        return Panel(self.noisy, "Input", self._errors(self.noisy))

    def at(self, method: str, tau: float, steps: int, show: int | None = None) -> Panel:
        """Return the surface after `show` (or all) of the steps at the given τ."""
        count = show or steps
        positions = faired(self.noisy, self.triangles, method, tau, count)[-1]
        plural = "step" if count == 1 else "steps"
        title = f"{SCHEMES[method]}, τ = {tau:.3g}, {count} {plural}"
        return Panel(positions, title, self._errors(positions))

    def matched(self, method: str, steps: int) -> Panel:
        """Return the surface at the τ that leaves the coarse parts as rough as without noise."""
        coarse = self.classes.coarse
        goal = self.classes.roughness(self.clean, coarse)
        tau = matched_tau(self.noisy, self.triangles, method, steps, coarse, goal, self.classes)
        return self.at(method, tau, steps)

    def _errors(self, positions) -> str:
        coarse = self.classes.error(positions, self.clean, self.classes.coarse)
        dense = self.classes.error(positions, self.clean, self.classes.dense)
        return f"error: coarse part {coarse:.2f}, dense part {dense:.2f} edge lengths"
