"""Plan of a run: how the filters were mixed, enough for other frames of the surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..runtime.arrays import FloatArray
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
    has_creases : bool
        Whether the last round was run, which is for creases.
    correlation : NoiseCorrelation
        Of the noise at neighbours.
    """

    filters: tuple[Filter, ...]
    noise: FloatArray
    pilots: tuple[Mixture, ...]
    mixtures: tuple[Mixture, ...]
    kept: FloatArray
    impulsive: FloatArray
    reach: FloatArray
    has_creases: bool = False
    correlation: NoiseCorrelation = WHITE

    @classmethod
    def idle(cls, noise: FloatArray, impulsive: FloatArray, reach: FloatArray) -> DenoisePlan:
        """Leave everything but vertices that stand out as it is."""
        return cls((), noise, (), (), np.ones(len(STRENGTHS)), impulsive, reach)

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
        return float(np.sqrt(np.sqrt(3) / (4 * np.pi) * (1 / kept - 1)))
