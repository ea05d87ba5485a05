"""Plan of a run: the mixture of its filters, which other frames of the surface can use."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..runtime.arrays import BoolArray, FloatArray, IndexArray
from .coarse_level import CoarseLevel
from .filters import Filter
from .mixture import Mixture
from .noise_model import WHITE, NoiseCorrelation

# Strengths that every run computes, as factors of the estimated noise.
STRENGTHS = (0.5, 0.75, 1.0, 1.5, 2.0)


@dataclass(frozen=True)
class DenoisePlan:
    """Noise level and filter coefficients at the solver's vertices.

    Attributes
    ----------
    filters : tuple of Filter
        Filters, in the order of the coefficients.
    noise : (n,)
        Standard deviation of the noise in local edge lengths; 0 where it was not judged.
    pilots : tuple of Mixture
        Mixtures of the filters so far, after each round except the last.
    mixtures : tuple of Mixture
        Mixtures of all filters, for each of `STRENGTHS`; empty if there is nothing to do.
    kept : (s,)
        Fraction of the noise that each mixture keeps, 0 to 1.
    impulsive : (n,) bool
        Where spikes are put back before the filters.
    reach : (n,)
        Standard deviation of all noise, including spikes, in local edge lengths: the unit of the
        largest displacement of a vertex.
    typical_noise : float
        Median of the noise where it was judged, over the whole surface; it decides the filters.
    correlation : NoiseCorrelation
        Correlation of the noise at neighbours.
    level : CoarseLevel, optional
        Level on which wide noise was removed; `on_level` is the plan there. Everything except
        `noise` then refers to the level's vertices.
    on_level : DenoisePlan, optional
    """

    filters: tuple[Filter, ...]
    noise: FloatArray
    pilots: tuple[Mixture, ...]
    mixtures: tuple[Mixture, ...]
    kept: FloatArray
    impulsive: BoolArray
    reach: FloatArray
    typical_noise: float = 0.0
    correlation: NoiseCorrelation = WHITE
    level: CoarseLevel | None = None
    on_level: DenoisePlan | None = None

    @classmethod
    def idle(cls, noise: FloatArray, impulsive: BoolArray, reach: FloatArray) -> DenoisePlan:
        """Make the plan that only puts spikes back."""
        return cls((), noise, (), (), np.ones(len(STRENGTHS)), impulsive, reach)

    def at(self, vertices: IndexArray) -> DenoisePlan:
        """Return the same plan for a part of the surface, (k,) of its vertices."""
        noise = self.noise[vertices]
        if self.level is not None:
            return replace(self, noise=noise)
        return replace(
            self,
            noise=noise,
            pilots=tuple(each.at(vertices) for each in self.pilots),
            mixtures=tuple(each.at(vertices) for each in self.mixtures),
            impulsive=self.impulsive[vertices],
            reach=self.reach[vertices],
        )

    def carried_to(self, level: CoarseLevel, noise: FloatArray) -> DenoisePlan:
        """Return the plan for a surface over the level that this plan was made on.

        With its noise, (n,) in local edge lengths.
        """
        return replace(self, noise=noise, level=level, on_level=self)

    @property
    def is_idle(self) -> bool:
        """Whether the plan changes nothing."""
        return not any(len(each.used) for each in self.mixtures)

    @property
    def radius(self) -> float:
        """Smoothing radius at strength 1, in local edge lengths.

        A Gaussian filter of this standard deviation r keeps the same fraction of white noise. It
        keeps cell / (2 π r²), and a vertex has a cell of √3/2 squared edges. The 1 in the formula
        makes the radius 0 if nothing is done.
        """
        kept = float(np.clip(self.kept[STRENGTHS.index(1.0)], 1e-6, 1))
        unit = self.level.ratio if self.level is not None else 1.0
        return unit * float(np.sqrt(np.sqrt(3) / (4 * np.pi) * (1 / kept - 1)))
