"""Measure the paper's claims: `python -m research.claims CLAIM ...`."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from tqdm import tqdm

from adaptive_fairing.core import FairingError
from adaptive_fairing.files.report import strict

from . import (
    bandwidth,
    convergence,
    density_passes,
    differences,
    homogenisation,
    stopping,
    under_over_fairing,
)
from .pairs import PUBLISHED, MeshPair, file_pair, sample_pair
from .tables import Findings, replace_tables

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "research" / "paper.md"
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
    """Measure the claims named on the command line."""
    options = _parser().parse_args(arguments)
    names = list(CLAIMS) if "all" in options.claims else options.claims
    records = []
    try:
        pairs = _pairs(options)
        for name in tqdm(names, disable=len(names) == 1, file=sys.stderr):
            findings = CLAIMS[name](pairs)
            _hand_out(name, findings, options)
            records.append({"claim": name, "tables": [t.record() for t in findings.tables]})
    except (FairingError, OSError) as error:
        print(f"claims: {error}", file=sys.stderr)
        return 1
    if options.json:
        print(json.dumps(strict(records), indent=2, ensure_ascii=False, allow_nan=False))
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m research.claims", description=__doc__.split(":")[0]
    )
    parser.add_argument(
        "claims",
        nargs="+",
        choices=[*CLAIMS, "all"],
        metavar="CLAIM",
        help=f"{', '.join(CLAIMS)}, or all",
    )
    parser.add_argument(
        "--pair",
        nargs=2,
        type=Path,
        metavar=("NOISY", "CLEAN"),
        help="two mesh files instead of the samples",
    )
    parser.add_argument("--json", action="store_true", help="print JSON instead of Markdown")
    parser.add_argument(
        "--page", action="store_true", help="write tables into research/paper.md and plots for it"
    )
    return parser


def _pairs(options: argparse.Namespace) -> list[MeshPair]:
    if options.pair:
        return [file_pair(*options.pair)]
    return [sample_pair(name) for name in PUBLISHED]


def _hand_out(name: str, findings: Findings, options: argparse.Namespace) -> None:
    if options.page:
        replace_tables(PAGE, name, findings.tables)
        if findings.draw:
            findings.draw(PLOTS / f"claim_{name}.png")
    elif not options.json:
        print("\n".join(table.markdown() for table in findings.tables))


if __name__ == "__main__":
    sys.exit(main())
