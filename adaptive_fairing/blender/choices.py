"""The methods and the results that there are, as the panel and the preferences offer them."""

from __future__ import annotations

AUTO = "auto"
"""Method of `denoise`; the other methods are those of the paper."""

FALLBACK_METHOD = "adaptive_timestep"
"""The method of the paper where one is needed beside `AUTO`."""

LIVE = "LIVE"
"""The result of `denoise` as the mesh's own coordinates."""

# The numbers are what files hold.
METHODS = (
    (
        "auto",
        "Denoise",
        "Estimate the noise and remove it, without parameters",
        3,
    ),
    ("", "Diffusion (paper)", ""),
    (
        "adaptive_timestep",
        "Adaptive Timestep",
        "Coarse parts run through more time than dense ones: details in dense parts stay",
        0,
    ),
    (
        "adaptive_tensor",
        "Adaptive Tensor",
        "The same time everywhere, but dense parts conduct less",
        1,
    ),
    (
        "uniform",
        "Uniform",
        "The same smoothing everywhere, whatever the density; needs a much smaller τ",
        2,
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
