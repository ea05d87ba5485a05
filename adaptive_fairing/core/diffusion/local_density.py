"""Density d_i for a run, which may solve on a part of the surface only."""

from __future__ import annotations

import numpy as np

from ..mesh.density import mesh_density
from ..problem.problem import Margin, SolverProblem
from ..problem.region import SUPPORT_RINGS
from ..runtime.arrays import FloatArray
from .settings import FairingSettings


def margin_of_run(settings: FairingSettings) -> Margin | None:
    """Margin around the moving vertices that influences their motion.

    Returns
    -------
    Margin or None
        None for the whole mesh, if the volume is kept: that is the volume of whole parts.
    """
    if settings.keep_volume:
        return None
    # Each pass takes in one more ring, and what it starts from is the mean over another one.
    return Margin(max(SUPPORT_RINGS, settings.density_passes + 1))


def initial_density(problem: SolverProblem, settings: FairingSettings) -> FloatArray:
    """Measure the density (n,) of the whole surface where the run starts."""
    whole = problem.whole
    return mesh_density(whole.topology, whole.start, settings.density, settings.density_passes)


def next_density(
    problem: SolverProblem, current: FloatArray, settings: FairingSettings, last: FloatArray
) -> FloatArray:
    """Measure the density (k,) of the vertices that are solved on.

    On a part of the surface, vertices of weight 0 keep the `last` density: a new one would be wrong
    at the border of the part, and it has no effect where nothing may move.
    """
    topology = problem.space.topology
    density = mesh_density(topology, current, settings.density, settings.density_passes)
    return np.where(problem.weights > 0, density, last) if problem.is_part else density
