"""Named filters, and families of them that are computed together."""

from __future__ import annotations

import math
from typing import NamedTuple

from ..linalg.krylov_filters import Diffusion
from .lifted_metric import LiftedMetric
from .noise_correlation import WHITE, NoiseCorrelation
from .normal_filter import Smoothing

# What a filter does at creases. Those that see creases keep what stands out of the noise.
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
