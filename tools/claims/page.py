"""Put measured tables into a Markdown page, each between its own pair of comment lines."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from .tables import Table


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
