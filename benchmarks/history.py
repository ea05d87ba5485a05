"""The history of measured ratios, one JSON line per run, and the warning when one got worse.

Ratios, not seconds: they say the same on a busy machine and on an idle one. All are such that less
is better. Only runs on machines of the same description are compared.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
from datetime import UTC, datetime
from pathlib import Path

from adaptive_fairing.version import program_version

HISTORY = Path(__file__).resolve().parent / "history.jsonl"

COMPARED_RUNS = 5
"""How many of the last runs make the median that a new run is compared with."""

WORSE = 1.2
"""By which factor a ratio may exceed that median without a warning."""

Machine = dict[str, str | int]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the option that records a run."""
    parser.add_argument(
        "--record", action="store_true", help=f"append the ratios to {HISTORY.name}, with a commit"
    )


def finish(
    arguments: argparse.Namespace, benchmark: str, machine: Machine, ratios: dict[str, float]
) -> None:
    """Print which ratios got worse since the last runs; append the run if that was asked for."""
    for warning in regressions(read(HISTORY), benchmark, machine, ratios):
        print(f"WARNING: {warning}")
    if arguments.record:
        append(HISTORY, benchmark, machine, ratios)
        print(f"recorded in {HISTORY.name}")


def read(path: Path) -> list[dict]:
    """All recorded runs, oldest first."""
    if not path.is_file():
        return []
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]


def regressions(
    runs: list[dict], benchmark: str, machine: Machine, ratios: dict[str, float]
) -> list[str]:
    """Say which ratios exceed the median of the last comparable runs by more than `WORSE`."""
    comparable = [r for r in runs if r["benchmark"] == benchmark and r["machine"] == machine]
    warnings = []
    for name, ratio in ratios.items():
        earlier = [run["ratios"][name] for run in comparable if name in run["ratios"]]
        if not earlier:
            continue
        usual = statistics.median(earlier[-COMPARED_RUNS:])
        if ratio > WORSE * usual:
            warnings.append(f"{name}: {ratio:.3g}, was {usual:.3g} (median of the last runs)")
    return warnings


def append(path: Path, benchmark: str, machine: Machine, ratios: dict[str, float]) -> None:
    """Add a run to the file."""
    run = {
        "date": datetime.now(UTC).strftime("%Y-%m-%d %H:%M"),
        "benchmark": benchmark,
        "version": program_version(),
        "commit": _commit(),
        "machine": machine,
        "ratios": {name: float(f"{ratio:.4g}") for name, ratio in ratios.items()},
    }
    with path.open("a", encoding="utf-8") as file:
        file.write(json.dumps(run, ensure_ascii=False) + "\n")


def _commit() -> str:
    """Short name of the commit, with a "+" if the package differs from it."""

    def git(*arguments: str) -> str:
        command = ["git", "-C", str(HISTORY.parent), *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()

    try:
        changed = git("status", "--porcelain", "--", "../adaptive_fairing")
        return git("rev-parse", "--short", "HEAD") + ("+" if changed else "")
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
