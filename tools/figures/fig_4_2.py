"""Fig 4.2 of the paper, the crocodile: `python -m figures.fig_4_2` in tools/."""

from __future__ import annotations

from claims.measures import TIMESTEP, UNIFORM
from render import View

from .layout import Shot, figure
from .panels import ROOT, Comparison

WHOLE = View((0.35, -1.0, 0.55))
SNOUT = View((-0.35, -1.0, 0.5), box=((-42.0, -9.5, 3.0), (-17.0, -1.0, 8.5)))
BACK = View((0.35, -1.0, 0.7), box=((0.0, -6.0, 4.0), (26.0, 3.0, 10.0)))


def main() -> None:
    """Render the figure into assets/figures."""
    animal = Comparison("crocodile")
    rows = [
        [panel]
        for panel in (
            animal.input(),
            animal.at(UNIFORM, 0.0001, 2),
            animal.at(UNIFORM, 0.0001, 4),
            animal.at(TIMESTEP, 0.0016, 2),
            animal.at(TIMESTEP, 0.0016, 4),
            animal.matched(UNIFORM, 4),
            animal.matched(TIMESTEP, 4),
        )
    ]
    shots = [[Shot(WHOLE, (760, 240))], [Shot(SNOUT, (400, 240))], [Shot(BACK, (360, 240))]]
    figure(ROOT / "assets" / "figures" / "fig_4_2.png", rows, animal.triangles, shots)


if __name__ == "__main__":
    main()
