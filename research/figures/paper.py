"""Figs 1.1 (head), 4.1 (foot), 4.2 (crocodile) of the paper: `python -m research.figures.paper`.

Fig 1.1 is also drawn on the limit surfaces, which the method solves for, instead of their nets.
Each shows the paper's settings, then all schemes with equally smooth coarse parts.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable

from research.claims.measures import TENSOR, TIMESTEP, TIMESTEP_AREA, UNIFORM, Scheme, matched_tau
from research.claims.pairs import sample_pair
from research.figures.render import View

from .layout import FOLDER, Panel, Shot, figure

TITLES = {
    UNIFORM: "Uniform timestep",
    TIMESTEP: "Adaptive timestep",
    TIMESTEP_AREA: "Adaptive timestep, area",
    TENSOR: "Adaptive tensor",
}

HEAD_SHOTS = [
    [Shot(View((0.75, -1.0, 0.15), perspective=25.0), (300, 480))],
    [
        Shot(View((1.0, -0.6, 0.1), box=((6.8, -1.6, 6.6), (8.6, 3.4, 13.8))), (170, 220)),
        Shot(View((0.4, -1.0, 0.05), box=((-3.4, -11.5, 3.0), (4.8, -8.0, 13.0))), (170, 260)),
    ],
]
FOOT_SHOTS = [
    [
        Shot(View((0.9, -1.0, 0.7)), (430, 400)),
        Shot(View((0.45, -1.0, 0.9), box=((-4.6, -12.2, 0.0), (4.6, -5.4, 3.0))), (430, 290)),
    ]
]
CROCODILE_SHOTS = [
    [Shot(View((0.35, -1.0, 0.55)), (760, 240))],
    [Shot(View((-0.35, -1.0, 0.5), box=((-42.0, -9.5, 3.0), (-17.0, -1.0, 8.5))), (400, 240))],
    [Shot(View((0.35, -1.0, 0.7), box=((0.0, -6.0, 4.0), (26.0, 3.0, 10.0))), (360, 240))],
]


class Comparison:
    """One noisy sample mesh, and its panels at given settings."""

    def __init__(self, name: str, steps: int) -> None:
        self.pair = sample_pair(name)
        self.steps = steps

    def input(self) -> Panel:
        """Return the noisy input."""
        return Panel(self.pair.noisy, "Input", self._errors(self.pair.noisy))

    def at(self, scheme: Scheme, tau: float, steps: int | None = None) -> Panel:
        """Return the surface after some (or all) of the steps at the given τ."""
        count = steps or self.steps
        positions = scheme.faired(self.pair.noisy, self.pair.triangles, tau, count)
        plural = "step" if count == 1 else "steps"
        title = f"{TITLES[scheme]}, τ = {tau:.3g}, {count} {plural}"
        return Panel(positions, title, self._errors(positions))

    def matched(self, *schemes: Scheme) -> list[Panel]:
        """Return the surfaces at the τ that leaves the coarse parts as rough as without noise."""
        pair = self.pair
        return [
            self.at(s, matched_tau(s, pair.noisy, pair.clean, pair.classes, self.steps))
            for s in schemes
        ]

    def _errors(self, positions) -> str:
        classes, clean = self.pair.classes, self.pair.clean
        coarse = classes.distance(positions, clean, classes.coarse)
        dense = classes.distance(positions, clean, classes.dense)
        return f"error: coarse part {coarse:.2f}, dense part {dense:.2f} edge lengths"


def head() -> tuple[Comparison, list[list[Panel]], list[list[Shot]]]:
    """Return fig 1.1: its mesh, its rows of panels and their shots."""
    mesh = Comparison("head", 4)
    published = [
        mesh.input(),
        mesh.at(TIMESTEP, 0.016),
        mesh.at(UNIFORM, 0.001, 1),
        mesh.at(UNIFORM, 0.001),
    ]
    return mesh, [published, mesh.matched(TIMESTEP, TENSOR, UNIFORM, TIMESTEP_AREA)], HEAD_SHOTS


def head_surface() -> tuple[Comparison, list[list[Panel]], list[list[Shot]]]:
    """Return fig 1.1 with the paper's settings alone, for its limit surfaces."""
    mesh, (published, _), shots = head()
    return mesh, [published], shots


def foot() -> tuple[Comparison, list[list[Panel]], list[list[Shot]]]:
    """Return fig 4.1, as `head`."""
    mesh = Comparison("foot", 3)
    published = [
        mesh.input(),
        mesh.at(UNIFORM, 0.0011),
        mesh.at(TIMESTEP, 0.025),
        mesh.at(TENSOR, 0.025),
    ]
    return mesh, [published, mesh.matched(UNIFORM, TIMESTEP, TENSOR, TIMESTEP_AREA)], FOOT_SHOTS


def crocodile() -> tuple[Comparison, list[list[Panel]], list[list[Shot]]]:
    """Return fig 4.2, as `head`."""
    mesh = Comparison("crocodile", 4)
    panels = [mesh.input(), mesh.at(UNIFORM, 0.0001, 2), mesh.at(UNIFORM, 0.0001)]
    panels += [mesh.at(TIMESTEP, 0.0016, 2), mesh.at(TIMESTEP, 0.0016)]
    rows = [[panel] for panel in (*panels, *mesh.matched(UNIFORM, TIMESTEP))]
    return mesh, rows, CROCODILE_SHOTS


FIGURES: dict[str, Callable] = {
    "fig_1_1": head,
    "fig_1_1_surface": head_surface,
    "fig_4_1": foot,
    "fig_4_2": crocodile,
}
ON_SURFACE = {"fig_1_1_surface": 2}
"""Steps of refinement of the figures that show limit surfaces."""


def main() -> None:
    """Render the figures named on the command line, or all, into assets/figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("figures", nargs="*", choices=[[], *FIGURES], metavar=", ".join(FIGURES))
    for name in parser.parse_args().figures or FIGURES:
        mesh, rows, shots = FIGURES[name]()
        figure(
            FOLDER / f"{name}.png", rows, mesh.pair.triangles, shots, levels=ON_SURFACE.get(name)
        )


if __name__ == "__main__":
    main()
