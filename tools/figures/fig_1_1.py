"""Fig 1.1 of the paper, the head: `python -m figures.fig_1_1` in tools/."""

from __future__ import annotations

from claims.measures import TENSOR, TIMESTEP, TIMESTEP_AREA, UNIFORM
from render import View

from .layout import Shot, figure
from .panels import ROOT, Comparison

WHOLE = View((0.75, -1.0, 0.15), perspective=25.0)
EAR = View((1.0, -0.6, 0.1), box=((6.8, -1.6, 6.6), (8.6, 3.4, 13.8)))
FACE = View((0.4, -1.0, 0.05), box=((-3.4, -11.5, 3.0), (4.8, -8.0, 13.0)))
STEPS = 4


def main() -> None:
    """Render the figure into assets/figures."""
    head = Comparison("head")
    rows = [
        [
            head.input(),
            head.at(TIMESTEP, 0.016, STEPS),
            head.at(UNIFORM, 0.001, STEPS, show=1),
            head.at(UNIFORM, 0.001, STEPS),
        ],
        [
            head.matched(TIMESTEP, STEPS),
            head.matched(TENSOR, STEPS),
            head.matched(UNIFORM, STEPS),
            head.matched(TIMESTEP_AREA, STEPS),
        ],
    ]
    shots = [[Shot(WHOLE, (300, 480))], [Shot(EAR, (170, 220)), Shot(FACE, (170, 260))]]
    figure(ROOT / "assets" / "figures" / "fig_1_1.png", rows, head.triangles, shots)


if __name__ == "__main__":
    main()
