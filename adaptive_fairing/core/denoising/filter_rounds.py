"""Rounds of the automatic method, with the filters of each."""

from __future__ import annotations

import numpy as np

from ..linalg.krylov_filters import Diffusion
from .filter_family import IGNORES, KEEPS, SEES, FilterFamily, FlatFamily, NormalFamily
from .lifted_metric import LiftedMetric
from .noise_correlation import WHITE, NoiseCorrelation
from .normal_filter import Smoothing
from .parameters import parameters

Round = tuple[FilterFamily | NormalFamily | FlatFamily, ...]


def gentle_diffusions() -> tuple[Diffusion, ...]:
    """Return the diffusions of low order, which suffice near creases."""
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
    return FilterFamily("mesh", IGNORES, LiftedMetric(), all_diffusions())


def rounds(angle_factor: float = 1.0, correlation: NoiseCorrelation = WHITE) -> tuple[Round, ...]:
    """Return the filters of each round besides those of the mesh.

    The metrics of a round are those of the mixture of the earlier rounds, at first those of the
    slightly smoothed surface.  Their angles are for coarse noise, times a factor.
    The correlation is that of smooth noise in which flat faces are to be found.
    """
    tuned = parameters()
    wide, narrow = angle_factor * tuned.wide_angle, angle_factor * tuned.narrow_angle
    every, gentle = all_diffusions(), gentle_diffusions()
    return (
        (FilterFamily("surface", IGNORES, LiftedMetric(1), every),),
        (FilterFamily("mesh, wide angle", SEES, LiftedMetric(0, wide), every),),
        (
            FilterFamily("mesh, narrow angle", KEEPS, LiftedMetric(0, narrow), gentle),
            NormalFamily(
                "noisy normals", (Smoothing(tuned.long_fit_angle, tuned.noisy_fit_passes),), True
            ),
        ),
        (
            NormalFamily(
                "normals",
                (
                    Smoothing(tuned.short_fit_angle, tuned.short_fit_passes),
                    Smoothing(tuned.long_fit_angle, tuned.long_fit_passes),
                ),
            ),
        ),
        (FlatFamily("flat faces", correlation),),
    )


def rounds_for(typical: float, correlation: NoiseCorrelation = WHITE) -> list[Round]:
    """Choose the filters of all rounds for noise of a typical size in local edge lengths.

    The angles of the metrics are scaled to it.  Noise that turns triangles over leaves no
    information in their normals, so filters by normals are then left out.
    """
    tuned = parameters()
    factor = float(np.clip(typical / tuned.coarse_noise, tuned.least_angle_factor, 1))
    has_normals = typical <= tuned.most_noise_in_normals
    return [
        tuple(
            family
            for family in families
            if has_normals or not (isinstance(family, NormalFamily) and family.is_of_noisy)
        )
        for families in rounds(factor, correlation)
    ]
