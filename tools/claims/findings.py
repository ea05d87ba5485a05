"""What the measurement of a claim hands back: tables, and for some a plot."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from .tables import Table


@dataclass(frozen=True)
class Findings:
    """Results of one claim.

    Attributes
    ----------
    tables
        In the order in which they are to be read.
    draw
        Writes the plot to a picture file; None if the tables say it all.
    """

    tables: Sequence[Table]
    draw: Callable[[Path], None] | None = None
