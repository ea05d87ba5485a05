"""How close the adaptive timestep and the adaptive tensor come out (section 3.3, Fig 4.1)."""

from __future__ import annotations

from collections.abc import Sequence

from .differences import difference_table
from .findings import Findings
from .measures import TENSOR, TENSOR_AREA, TIMESTEP, TIMESTEP_AREA
from .pairs import MeshPair


def run(pairs: Sequence[MeshPair]) -> Findings:
    """Compare the two schemes with either density measure."""
    return Findings(
        [
            difference_table(pairs, TIMESTEP, TENSOR),
            difference_table(pairs, TIMESTEP_AREA, TENSOR_AREA),
        ]
    )
