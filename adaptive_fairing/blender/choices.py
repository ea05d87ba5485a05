"""Choices of the panel and the preferences: algorithms, schemes and kinds of results.

The identifiers of schemes, densities and frames are the core's words in capitals.
"""

from __future__ import annotations

DENOISE = "DENOISE"
"""The algorithm `denoise`."""

FAIR = "FAIR"
"""The algorithm `fair`: the paper, step by step."""

LIVE = "LIVE"
"""The result of `denoise` as the mesh's own coordinates."""

EVOLUTION = "ABSOLUTE_KEYS"
"""The steps of `fair` as one movie."""

ALGORITHMS = (
    (DENOISE, "Denoise", "Estimate the noise and remove it, without parameters"),
    (
        FAIR,
        "Adaptive Fairing",
        "Smooth by the geometric diffusion of the paper, which follows the density of the mesh, "
        "and keep every step",
    ),
)

SCHEMES = (
    (
        "TIMESTEP",
        "Adaptive Timestep",
        "Coarse parts are smoothed for a longer time than dense ones, so details in dense parts "
        "stay",
    ),
    (
        "TENSOR",
        "Adaptive Tensor",
        "The time is the same everywhere, but dense parts diffuse less",
    ),
    (
        "UNIFORM",
        "Uniform",
        "The same smoothing everywhere, whatever the density; it needs a much smaller τ",
    ),
)

RESULTS = (
    (
        "LIVE",
        "Live",
        "The mesh itself has the shape that is shown, so every exporter writes it; the "
        "original and the offsets are kept as attributes for the Strength slider",
    ),
    (
        "MODIFIER",
        "Modifier",
        "The mesh stays as it is; the modifier Adaptive Fairing shows the result",
    ),
)
