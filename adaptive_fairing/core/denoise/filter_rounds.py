"""The filters of the automatic method, round by round."""

from __future__ import annotations

import numpy as np

from ..linalg.krylov_filters import Diffusion
from ..runtime.arrays import FloatArray
from .filter_family import KEEPS, ROUNDS, SEES, FilterFamily, NormalFamily
from .lifted_metric import LiftedMetric
from .normal_filter import Smoothing
from .parameters import parameters

Round = tuple[FilterFamily | NormalFamily, ...]


def gentle_diffusions() -> tuple[Diffusion, ...]:
    """Return the diffusions of low order, which are enough near creases."""
    tuned = parameters()
    return tuple(
        Diffusion(time, tuned.gentle_order, tuned.diffusion_steps) for time in tuned.gentle_times
    )


def all_diffusions() -> tuple[Diffusion, ...]:
    """Return the gentle diffusions and those of high order, for smooth shapes."""
    tuned = parameters()
    steep = (
        Diffusion(time, tuned.steep_order, tuned.diffusion_steps) for time in tuned.steep_times
    )
    return *gentle_diffusions(), *steep


def mesh_family() -> FilterFamily:
    """Return the filters in the metric of the mesh alone."""
    return FilterFamily("mesh", ROUNDS, LiftedMetric(), all_diffusions())


def rounds() -> tuple[Round, ...]:
    """Return the filters of each round besides those of the mesh.

    The metrics of a round are those of the mixture of the rounds before it, at first those of the
    slightly smoothed surface.  Their angles are for coarse noise, see `rounds_for`.
    """
    tuned = parameters()
    every, gentle = all_diffusions(), gentle_diffusions()
    return (
        (FilterFamily("surface", ROUNDS, LiftedMetric(1), every),),
        (
            FilterFamily("mesh, wide angle", SEES, LiftedMetric(0, tuned.wide_angle), every),
            FilterFamily("surface, wide angle", SEES, LiftedMetric(1, tuned.wide_angle), every),
        ),
        (FilterFamily("mesh, narrow angle", KEEPS, LiftedMetric(0, tuned.narrow_angle), gentle),),
        (
            NormalFamily(
                (
                    Smoothing(tuned.short_fit_angle, tuned.short_fit_passes),
                    Smoothing(tuned.long_fit_angle, tuned.long_fit_passes),
                )
            ),
        ),
    )


def rounds_for(noise: FloatArray) -> list[Round]:
    """Scale the angles of all rounds' metrics to the noise, (n,), of the vertices judged."""
    tuned = parameters()
    typical = float(np.median(noise[noise > 0])) if noise.any() else 0.0
    factor = float(np.clip(typical / tuned.coarse_noise, tuned.least_angle_factor, 1))
    return [tuple(family.scaled(factor) for family in families) for families in rounds()]
