"""Measuring for all benchmarks: times, peak memory, the machine, tables of text."""

from __future__ import annotations

import os
import platform
import re
import timeit
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import psutil
import scipy

from adaptive_fairing.batch.memory_use import peak_bytes
from adaptive_fairing.core.runtime.threads import n_threads

MEGABYTE = 1e6


class Result(NamedTuple):
    """The best of a program's runs on one mesh: seconds, bytes, and the displacement."""

    one: float
    four: float | None
    step: float | None
    processor: float
    moved: float
    peak: float
    growth: float


def best_time(action: Callable[[], object], repeats: int) -> float:
    """Shortest wall-clock time of several runs, in seconds: the one least disturbed by others."""
    return min(timeit.repeat(action, number=1, repeat=repeats))


def peak_memory() -> int:
    """Largest resident memory of this process so far, in bytes; that of now if none is told."""
    held = psutil.Process().memory_info()
    return peak_bytes() or int(getattr(held, "peak_wset", held.rss))


def resident_memory() -> int:
    """Resident memory of this process now, in bytes."""
    return int(psutil.Process().memory_info().rss)


def machine() -> str:
    """One line about what the figures depend on, for above a table; no names of hosts."""
    memory = psutil.virtual_memory().total / 1e9
    return (
        f"{_processor()}, {n_threads()} cores, {memory:.0f} GB, {platform.system()}; "
        f"Python {platform.python_version()}, numpy {np.__version__} ({_blas()}), "
        f"scipy {scipy.__version__}"
    )


def load() -> str:
    """Text with the load average of the last minute: other work on the machine."""
    return f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "unknown"


def _processor() -> str:
    information = Path("/proc/cpuinfo")
    if information.is_file():
        found = re.search(r"model name\s*:\s*(.+)", information.read_text())
        if found:
            return found[1].strip()
    return platform.processor() or platform.machine()


def _blas() -> str:
    details = np.show_config(mode="dicts")["Build Dependencies"]["blas"]
    return f"{details.get('name', 'unknown')} {details.get('version', '')}".strip()


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Lay out a table in Markdown with the first column to the left, the others to the right."""
    widths = [max(len(row[k]) for row in [header, *rows]) for k in range(len(header))]

    def line(cells: Sequence[str]) -> str:
        first, *others = cells
        padded = [first.ljust(widths[0])]
        padded += [cell.rjust(width) for cell, width in zip(others, widths[1:], strict=True)]
        return "| " + " | ".join(padded) + " |"

    rule = ["-" * widths[0], *("-" * (width - 1) + ":" for width in widths[1:])]
    return "\n".join([line(header), line(rule), *map(line, rows)])


def seconds_text(seconds: float | None) -> str:
    """Show a time with three digits, or a dash where there is none."""
    return "–" if seconds is None else f"{seconds:.3g}" if seconds < 100 else f"{seconds:.0f}"


def log_slope(sizes: Sequence[float], costs: Sequence[float]) -> float:
    """Exponent p of cost ~ size^p, by a straight line through the logarithms."""
    return float(np.polyfit(np.log(sizes), np.log(costs), 1)[0])
