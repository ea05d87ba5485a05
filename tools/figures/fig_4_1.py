"""Fig 4.1 of the paper, the foot: `python -m figures.fig_4_1` in tools/."""

from __future__ import annotations

from claims.measures import TENSOR, TIMESTEP, TIMESTEP_AREA, UNIFORM
from render import View

from .layout import Shot, figure
from .panels import ROOT, Comparison

WHOLE = View((0.9, -1.0, 0.7))
TOES = View((0.45, -1.0, 0.9), box=((-4.6, -12.2, 0.0), (4.6, -5.4, 3.0)))
STEPS = 3


def main() -> None:
    """Render the figure into assets/figures."""
    foot = Comparison("foot")
    rows = [
        [
            foot.input(),
            foot.at(UNIFORM, 0.0011, STEPS),
            foot.at(TIMESTEP, 0.025, STEPS),
            foot.at(TENSOR, 0.025, STEPS),
        ],
        [
            foot.matched(UNIFORM, STEPS),
            foot.matched(TIMESTEP, STEPS),
            foot.matched(TENSOR, STEPS),
            foot.matched(TIMESTEP_AREA, STEPS),
        ],
    ]
    shots = [[Shot(WHOLE, (430, 400)), Shot(TOES, (430, 290))]]
    figure(ROOT / "assets" / "figures" / "fig_4_1.png", rows, foot.triangles, shots)


if __name__ == "__main__":
    main()
