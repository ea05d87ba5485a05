"""Timestep field: τ times the density, and its place in the system of each of the three schemes."""

from __future__ import annotations

import numpy as np

from ..runtime.arrays import FloatArray
from .settings import FairingSettings


def local_times(settings: FairingSettings, times: FloatArray, density: FloatArray) -> FloatArray:
    """Time t_i of one step at every vertex.

    Parameters
    ----------
    settings : FairingSettings
    times : (n,)
        τ times the weights of the vertices.
    density : (n,)
        d_i of the surface.

    Returns
    -------
    (n,)

    Source: (3.4) of the paper.
    """
    return times if settings.method == "uniform" else times * density


def scheme_fields(settings: FairingSettings, local: FloatArray) -> dict[str, FloatArray]:
    """Field that the matrices of a step need, under its name in `LoopSpace`.

    Parameters
    ----------
    settings : FairingSettings
    local : (n,)
        `local_times` of the step.

    Returns
    -------
    {"timestep": (n,)} or {"diffusivity": (n,)}

    Source: (3.4) and (3.9) of the paper.
    """
    if settings.method == "adaptive_tensor":
        return {"diffusivity": local}
    # Positive where it is 0, which is only in the equations of held vertices.
    return {"timestep": np.maximum(local, 1e-12 * local.max(initial=0) or 1.0)}
