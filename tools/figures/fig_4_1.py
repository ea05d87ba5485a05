"""Fig 4.1 of the paper, the foot: `python -m figures.fig_4_1` in tools/."""

from __future__ import annotations

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
            foot.at("uniform", 0.0011, STEPS),
            foot.at("adaptive_timestep", 0.025, STEPS),
            foot.at("adaptive_tensor", 0.025, STEPS),
        ],
        [
            foot.matched("uniform", STEPS),
            foot.matched("adaptive_timestep", STEPS),
            foot.matched("adaptive_tensor", STEPS),
        ],
    ]
    shots = [[Shot(WHOLE, (430, 400)), Shot(TOES, (430, 290))]]
    figure(ROOT / "assets" / "figures" / "fig_4_1.png", rows, foot.triangles, shots)


if __name__ == "__main__":
    main()
