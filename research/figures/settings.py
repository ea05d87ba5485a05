"""Pictures of docs/settings.md: `python -m research.figures.settings`."""

from __future__ import annotations

import numpy as np

from adaptive_fairing.core import FairingSettings, fair
from adaptive_fairing.core.diffusion.smoothing_radius import radius_scale
from research.claims.measures import TIMESTEP, TIMESTEP_AREA, UNIFORM, Scheme, matched_tau
from research.claims.pairs import MeshPair, sample_pair
from research.figures.render import View

from .layout import FOLDER, Panel, Shot, figure

STEPS = 4
TAUS = (0.0027, 0.0107, 0.043, 0.17)
FACE = View((0.75, -1.0, 0.1), box=((-5.0, -11.0, 2.0), (8.5, 4.0, 15.0)))
FRONT = View((0.1, -1.0, 0.05), box=((-9.5, -11.0, 1.0), (8.5, 0.0, 20.0)))
ANKLE = View((0.5, -0.8, 0.75), box=((-3.5, 1.0, 4.0), (4.0, 12.0, 11.0)))
LEG_CUT = 11.0
"""Height at which the leg of the foot is cut off, for a mesh with a boundary."""

BOUNDARY_TAU = 0.1
REGION_TAU = 0.06


def main() -> None:
    """Render all pictures into assets/figures."""
    head = sample_pair("head")
    _tau(head)
    _density(head)
    _region(head)
    _boundary(sample_pair("foot"))


def _tau(head: MeshPair) -> None:
    settings = TIMESTEP_AREA.settings(TAUS[0], STEPS)
    scale = radius_scale(head.noisy, head.triangles, settings)
    panels = [Panel(head.noisy, "input", "")]
    for tau in TAUS:
        result = TIMESTEP_AREA.faired(head.noisy, head.triangles, tau, STEPS)
        _, radius, _ = scale.radii(STEPS * tau)
        panels.append(Panel(result, f"τ = {tau:g}", f"radius {radius:.2g} edges"))
    figure(FOLDER / "settings_tau.png", [panels], head.triangles, [[Shot(FACE, (200, 230))]])


def _density(head: MeshPair) -> None:
    panels = [
        _matched(head, UNIFORM, "uniform"),
        _matched(head, TIMESTEP, "edge length"),
        _matched(head, TIMESTEP_AREA, "area"),
    ]
    figure(FOLDER / "settings_density.png", [panels], head.triangles, [[Shot(FACE, (260, 290))]])


def _matched(head: MeshPair, scheme: Scheme, title: str) -> Panel:
    tau = matched_tau(scheme, head.noisy, head.clean, head.classes, STEPS)
    result = scheme.faired(head.noisy, head.triangles, tau, STEPS)
    return Panel(result, title, f"τ = {tau:.2g}")


def _region(head: MeshPair) -> None:
    across = head.clean[:, 0]
    halves = {
        "whole mesh": np.ones(len(across)),
        "weights 0 and 1": (across > 0).astype(float),
        "weights from 0 to 1": np.clip(0.5 + across / 8, 0, 1),
    }
    settings = TIMESTEP_AREA.settings(REGION_TAU, STEPS)
    panels = [
        Panel(fair(head.noisy, head.triangles, settings, weights=weights).positions, title, "")
        for title, weights in halves.items()
    ]
    figure(FOLDER / "settings_region.png", [panels], head.triangles, [[Shot(FRONT, (240, 290))]])


def _boundary(foot: MeshPair) -> None:
    kept = foot.triangles[(foot.noisy[foot.triangles][:, :, 2] < LEG_CUT).all(axis=1)]
    used, corners = np.unique(kept, return_inverse=True)
    noisy, triangles = foot.noisy[used], corners.reshape(-1, 3).astype(np.int32)
    panels = [Panel(noisy, "input", "open at the ankle")]
    for boundary, text in (
        ("fixed", "the boundary stays"),
        ("free", "the boundary is smoothed, and shrinks"),
    ):
        settings = FairingSettings(density="area", tau=BOUNDARY_TAU, steps=STEPS, boundary=boundary)
        panels.append(Panel(fair(noisy, triangles, settings).positions, boundary, text))
    figure(FOLDER / "settings_boundary.png", [panels], triangles, [[Shot(ANKLE, (260, 230))]])


if __name__ == "__main__":
    main()
