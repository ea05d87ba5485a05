"""Memory that a process can still get, as far as the system tells."""

from __future__ import annotations

import importlib
import os
import sys
from pathlib import Path


def available_bytes() -> int | None:
    """Memory that this process can still get, or None if the system does not tell.

    Free or reclaimable memory with swap space, within the limit of the control group.  Linux tells
    in a file; elsewhere psutil is asked where it is installed.  Blender does not bring it along, so
    the last to be asked is the system: macOS tells only how much memory the machine has.
    """
    free = _free_on_linux()
    if free is None:
        free = _free_by_psutil()
    if free is None:
        free = _free_on_windows() if sys.platform == "win32" else _memory_of_machine()
    group = _free_in_group()
    return free if free is None or group is None else min(free, group)


def _free_on_linux(meminfo: Path = Path("/proc/meminfo")) -> int | None:
    try:
        values = _numbers(meminfo)  # in units of 1024 bytes
        return 1024 * (values["MemAvailable:"] + values.get("SwapFree:", 0))
    except (KeyError, OSError):
        return None


def _free_by_psutil() -> int | None:
    try:
        psutil = importlib.import_module("psutil")
    except ImportError:
        return None
    return int(psutil.virtual_memory().available + psutil.swap_memory().free)


def _memory_of_machine() -> int | None:
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (ValueError, OSError):
        return None


def _free_in_group(root: Path = Path("/sys/fs/cgroup")) -> int | None:
    """Read what the memory limit of a container leaves (control groups, version 2)."""
    try:
        limit = (root / "memory.max").read_text().strip()
        if limit == "max":
            return None
        used = int((root / "memory.current").read_text())
        # Cached files count as used but give way.
        cached = _numbers(root / "memory.stat").get("inactive_file", 0)
        return max(int(limit) - used + cached, 0)
    except (OSError, ValueError):
        return None


def _numbers(path: Path) -> dict[str, int]:
    """Read lines of a name and a number."""
    words = [line.split() for line in path.read_text().splitlines()]
    return {line[0]: int(line[1]) for line in words if len(line) > 1 and line[1].isdigit()}


def _free_on_windows() -> int | None:
    import ctypes

    class MemoryStatus(ctypes.Structure):
        _fields_ = [
            ("length", ctypes.c_ulong),
            ("load", ctypes.c_ulong),
            *(
                (name, ctypes.c_ulonglong)
                for name in (
                    "physical", "free_physical", "pages", "free_pages",
                    "virtual", "free_virtual", "free_extended",
                )
            ),
        ]  # fmt: skip

    status = MemoryStatus(length=ctypes.sizeof(MemoryStatus))
    kernel = getattr(ctypes, "windll").kernel32  # noqa: B009  absent from the types elsewhere
    if not kernel.GlobalMemoryStatusEx(ctypes.byref(status)):
        return None
    return int(status.free_pages)
