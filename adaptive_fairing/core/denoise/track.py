"""Positions on their way through the filters."""

from __future__ import annotations

import numpy as np

from ..runtime.arrays import FloatArray, RealArray
from .filter_bank import FilterBank
from .filter_family import Filter
from .filter_rounds import Round
from .local_frame import LocalFrame
from .mixture import Mixture


class Track:
    """Positions on their way through the filters, with what each filter takes away.

    What is taken away is kept in single precision, which is plenty for it, to save memory.
    """

    def __init__(self, bank: FilterBank, positions: FloatArray) -> None:
        self.positions = positions
        self._bank = bank
        self.surface, filtered = bank.started(positions)
        self.taken: dict[Filter, RealArray] = {
            each: (positions - result).astype(np.float32) for each, result in filtered.items()
        }

    def filter(self, families: Round) -> None:
        """Add filters in metrics of the present surface, or fits to its normals."""
        for each, filtered in self._bank.filtered(self.positions, self.surface, families):
            self.taken[each] = (self.positions - filtered).astype(np.float32)

    def removed(self, each: Filter, frame: LocalFrame) -> FloatArray:
        """Measure the normal part of what a filter takes away, in local edge lengths, (n,)."""
        return frame.along_normal(self.taken[each].astype(np.float64))

    def mixed(self, mixture: Mixture) -> FloatArray:
        """Mix the filters so far."""
        result, taken = self.positions.copy(), list(self.taken.values())
        for used in mixture.used:
            result -= mixture.coefficients(used)[:, None] * taken[used]
        return result
