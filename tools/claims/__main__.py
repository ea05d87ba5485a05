"""Measure the paper's claims: `python -m claims CLAIM ...` in tools/."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from tqdm import tqdm

from . import (
    bandwidth,
    convergence,
    density_passes,
    differences,
    homogenisation,
    stopping,
    under_over_fairing,
)
from .pairs import PUBLISHED, sample_pair
from .tables import replace_tables

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "paper.md"
PLOTS = ROOT / "assets" / "figures"
CLAIMS = {
    "under_over_fairing": under_over_fairing.run,
    "two_schemes": differences.two_schemes,
    "density_measures": differences.density_measures,
    "density_passes": density_passes.run,
    "homogenisation": homogenisation.run,
    "bandwidth": bandwidth.run,
    "stopping": stopping.run,
    "convergence": convergence.run,
}
"""Every claim by name, in the order of the page."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure the claims named on the command line on all samples."""
    parser = argparse.ArgumentParser(prog="python -m claims", description=__doc__.split(":")[0])
    parser.add_argument(
        "claims",
        nargs="+",
        choices=[*CLAIMS, "all"],
        metavar="CLAIM",
        help=f"{', '.join(CLAIMS)}, or all",
    )
    parser.add_argument(
        "--page", action="store_true", help="write tables into docs/paper.md and plots for it"
    )
    options = parser.parse_args(arguments)
    names = list(CLAIMS) if "all" in options.claims else options.claims
    pairs = [sample_pair(name) for name in PUBLISHED]
    for name in tqdm(names, disable=len(names) == 1, file=sys.stderr):
        findings = CLAIMS[name](pairs)
        if not options.page:
            print("\n".join(table.markdown() for table in findings.tables))
            continue
        replace_tables(PAGE, name, findings.tables)
        if findings.draw:
            findings.draw(PLOTS / f"claim_{name}.png")
    return 0


if __name__ == "__main__":
    sys.exit(main())
