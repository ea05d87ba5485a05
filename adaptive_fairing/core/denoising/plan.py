"""Plan of a run: how the filters were mixed, enough for other frames of the surface."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..runtime.arrays import FloatArray, IndexArray
from .coarse_level import CoarseLevel
from .filter_family import Filter
from .mixture import Mixture
from .noise_correlation import WHITE, NoiseCorrelation

# Strengths that every run computes, as factors of the estimated noise.
STRENGTHS = (0.5, 0.75, 1.0, 1.5, 2.0)


@dataclass(frozen=True)
class DenoisePlan:
    """Noise level and filter coefficients at the solver's vertices.

    Attributes
    ----------
    filters : tuple of Filter
        What is mixed, in the order of the coefficients.
    noise : (n,)
        Standard deviation of the noise in local edge lengths; 0 where it was not judged.
    pilots : tuple of Mixture
        Of the filters so far, after each round but the last that was run.
    mixtures : tuple of Mixture
        Of all filters, for each of `STRENGTHS`; none if nothing is to be done.
    kept : (s,)
        Fraction of the noise that each mixture keeps, 0 to 1.
    impulsive : (n,)
        Fraction of their way by which vertices that stand out are put back before the filters.
    reach : (n,)
        Standard deviation of all noise, spikes included, in local edge lengths: the unit of how far
        a vertex may move.
    typical_noise : float
        Median of the noise where it was judged, of all of the surface: it decides the filters.
    has_creases : bool
        Whether the last round was run, which is for creases.
    correlation : NoiseCorrelation
        Of the noise at neighbours.
    level : CoarseLevel, optional
        Where the noise was removed, if it is wide, and the plan there. All but `noise` then is of
        the level's vertices.
    on_level : DenoisePlan, optional
    """

    filters: tuple[Filter, ...]
    noise: FloatArray
    pilots: tuple[Mixture, ...]
    mixtures: tuple[Mixture, ...]
    kept: FloatArray
    impulsive: FloatArray
    reach: FloatArray
    typical_noise: float = 0.0
    has_creases: bool = False
    correlation: NoiseCorrelation = WHITE
    level: CoarseLevel | None = None
    on_level: DenoisePlan | None = None

    @classmethod
    def idle(cls, noise: FloatArray, impulsive: FloatArray, reach: FloatArray) -> DenoisePlan:
        """Leave everything but vertices that stand out as it is."""
        return cls((), noise, (), (), np.ones(len(STRENGTHS)), impulsive, reach)

    def at(self, vertices: IndexArray) -> DenoisePlan:
        """Return the same plan for a part of the surface, (k,) of its vertices."""
        return replace(
            self,
            noise=self.noise[vertices],
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

        A Gaussian filter of this standard deviation r keeps the same part of white noise. It keeps
        cell / (2 π r²), and a vertex has a cell of √3/2 squared edges. The 1 in the formula makes
        the radius of doing nothing 0.
        """
        kept = float(np.clip(self.kept[STRENGTHS.index(1.0)], 1e-6, 1))
        unit = self.level.ratio if self.level is not None else 1.0
        return unit * float(np.sqrt(np.sqrt(3) / (4 * np.pi) * (1 / kept - 1)))
