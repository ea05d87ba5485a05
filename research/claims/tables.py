"""Results of claims: tables as Markdown, in a page too, and as plain values for programs."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

Cell = str | int | float | tuple[float, ...] | None
"""A tuple is shown as its numbers with slashes between them, None as a dash."""


@dataclass(frozen=True)
class Table:
    """Rows of results under a title.

    Attributes
    ----------
    title
        What was measured, on which mesh.
    columns
        Head of every column; the first names the rows.
    rows
        One cell for every column.
    """

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[Cell]]

    def markdown(self) -> str:
        """Lay the table out with the first column to the left and the others to the right."""
        lines = [
            list(self.columns),
            ["---", *["---:"] * (len(self.columns) - 1)],
            *([shown(cell) for cell in row] for row in self.rows),
        ]
        rows = "\n".join("| " + " | ".join(line) + " |" for line in lines)
        return f"**{self.title}**\n\n{rows}\n"

    def record(self) -> dict[str, Any]:
        """Return the table for JSON, with all digits."""
        return {
            "title": self.title,
            "rows": [dict(zip(self.columns, row, strict=True)) for row in self.rows],
        }


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


def replace_tables(page: Path, claim: str, tables: Sequence[Table]) -> None:
    """Replace what stands between `<!-- tables: CLAIM -->` and `<!-- end -->`.

    Raises
    ------
    ValueError
        The page has no such place, or two.
    """
    text = page.read_text(encoding="utf-8")
    place = re.compile(rf"(<!-- tables: {re.escape(claim)} -->\n).*?(<!-- end -->)", re.DOTALL)
    body = "\n" + "\n".join(table.markdown() for table in tables) + "\n"
    text, count = place.subn(lambda found: found[1] + body + found[2], text)
    if count != 1:
        raise ValueError(f"{page.name} has {count} places for the tables of {claim}, not one")
    page.write_text(text, encoding="utf-8")


def shown(cell: Cell) -> str:
    """Show a cell; numbers with three significant digits, small ones with two."""
    if cell is None:
        return "–"
    if isinstance(cell, tuple):
        return " / ".join(shown(part) for part in cell)
    if not isinstance(cell, float):
        return str(cell)
    size = abs(cell)
    if size == 0:
        return "0"
    if 0.1 <= size < 1e4:
        return f"{cell:.{max(0, 2 - math.floor(math.log10(size)))}f}"
    return f"{cell:#.2g}" if 1e-4 <= size < 0.1 else f"{cell:.1e}"
