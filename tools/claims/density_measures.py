"""Whether mean edge length and ring area give the same results (section 3.2)."""

from __future__ import annotations

from collections.abc import Sequence

from .differences import difference_table
from .findings import Findings
from .measures import TIMESTEP, TIMESTEP_AREA
from .pairs import MeshPair


def run(pairs: Sequence[MeshPair]) -> Findings:
    """Compare the two measures of density in the timestep scheme."""
    return Findings([difference_table(pairs, TIMESTEP, TIMESTEP_AREA)])
