"""Rounds of the automatic method, with the families of filters of each."""

from __future__ import annotations

import math
from typing import NamedTuple

from ..linalg.krylov_filters import Diffusion
from .lifted_metric import LiftedMetric
from .noise_model import WHITE, NoiseCorrelation
from .normal_filter import Smoothing
from .parameters import parameters

# Behaviour of a filter at creases. Filters that see creases keep those that stand out of the noise.
KEEPS, SEES, IGNORES = "keeps", "sees", "ignores"


class Filter(NamedTuple):
    """One filter of the bank.

    Attributes
    ----------
    name : str
        Unique name among the filters of a run.
    creases : str
        `KEEPS`, `SEES` or `IGNORES`.
    """

    name: str
    creases: str

    def serves(self, features: str) -> bool:
        """Whether the setting "auto", "sharp" or "smooth" allows this filter."""
        return features == "auto" or self.creases == {"sharp": KEEPS, "smooth": IGNORES}[features]


class FilterFamily(NamedTuple):
    """Several diffusions in one metric.

    Attributes
    ----------
    name : str
    creases : str
        As in `Filter`.
    metric : LiftedMetric
    diffusions : tuple of Diffusion
    """

    name: str
    creases: str
    metric: LiftedMetric
    diffusions: tuple[Diffusion, ...]

    @property
    def filters(self) -> tuple[Filter, ...]:
        """The filters, in the order of the diffusions."""
        return tuple(
            Filter(f"{self.name}: time {each.time:g}, order {each.order}", self.creases)
            for each in self.diffusions
        )


class FlatFamily(NamedTuple):
    """The mixture of the earlier rounds with its flat faces flattened, see `flat_faces`.

    Attributes
    ----------
    name : str
    correlation : NoiseCorrelation
        Correlation of smooth noise in which faces are to be found; no correlation otherwise.
    """

    name: str
    correlation: NoiseCorrelation = WHITE

    @property
    def filters(self) -> tuple[Filter, ...]:
        """The only filter."""
        return (Filter(self.name, KEEPS),)


class NormalFamily(NamedTuple):
    """Fits to the normals of triangles, smoothed in several ways but not across creases.

    Attributes
    ----------
    name : str
    smoothings : tuple of Smoothing
    is_of_noisy : bool
        Whether the normals are those of the noisy mesh, instead of the mixture of the earlier
        rounds.
    """

    name: str
    smoothings: tuple[Smoothing, ...]
    is_of_noisy: bool = False

    @property
    def filters(self) -> tuple[Filter, ...]:
        """The filters, in the order of the smoothings and their passes."""
        return tuple(
            Filter(f"{self.name} within {math.degrees(each.angle):g}°: {passes} passes", KEEPS)
            for each in self.smoothings
            for passes in each.passes
        )


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
    factor = min(typical / tuned.coarse_noise, 1.0)
    has_normals = typical <= tuned.most_noise_in_normals
    return [
        tuple(
            family
            for family in families
            if has_normals or not (isinstance(family, NormalFamily) and family.is_of_noisy)
        )
        for families in rounds(factor, correlation)
    ]
