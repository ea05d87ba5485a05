"""What the panel and the command line start with; the core's own defaults are in its settings."""

from __future__ import annotations

from collections.abc import Collection

METHOD = "auto"
"""Method, by its name in `FairingSettings`."""

DIFFUSION = ("tau", "steps", "density", "density_passes", "stop_curvature", "stop_rate")
"""Settings that "auto" has no use for."""


def method_beside(given: Collection[str]) -> str:
    """Choose the method where somebody has named these settings, but no method.

    Who says how far to diffuse does not want it estimated.
    """
    return "adaptive_timestep" if set(given) & set(DIFFUSION) else METHOD
