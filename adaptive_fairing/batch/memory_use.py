"""Memory use of a process, and memory sizes as users write them."""

from __future__ import annotations

import re
import sys
from pathlib import Path

from .inputs import ArgumentsError

UNITS = {"": 1, "K": 10**3, "M": 10**6, "G": 10**9, "T": 10**12}


def resident_bytes(process: int | str = "self") -> int | None:
    """Memory that a process holds now; None if it has ended or the system does not say."""
    try:
        words = Path(f"/proc/{process}/statm").read_text().split()
    except OSError:
        return None
    import resource

    return int(words[1]) * resource.getpagesize()


def peak_bytes() -> int | None:
    """Largest memory that this process has held so far; None if the system does not say."""
    status = Path("/proc/self/status")
    if status.exists():
        # Not getrusage: on Linux its figure starts at the size of the process that started this.
        found = re.search(r"VmHWM:\s+(\d+) kB", status.read_text())
        return 1024 * int(found[1]) if found else None
    if sys.platform == "win32":
        return None
    import resource

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return int(peak) * (1 if sys.platform == "darwin" else 1024)


def address_space_bytes() -> int | None:
    """Limit of this process's address space (``ulimit -v``); None for no limit."""
    if sys.platform == "win32":
        return None
    import resource

    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    return None if limit == resource.RLIM_INFINITY else limit


def parse_bytes(text: str) -> int:
    """Read a size such as ``8G`` or ``1500M``: powers of 1000.

    Raises
    ------
    ArgumentsError
        The text is not a size.
    """
    match = re.fullmatch(r"(\d+(?:\.\d+)?)\s*([KMGT]?)B?", text.strip().upper())
    if match is None or float(match[1]) == 0:
        raise ArgumentsError(f"--memory {text}: give a size such as 8G or 1500M")
    return int(float(match[1]) * UNITS[match[2]])


def in_gigabytes(n_bytes: float) -> str:
    """Write a size for a message."""
    return f"{n_bytes / 1e9:.2f} GB"
