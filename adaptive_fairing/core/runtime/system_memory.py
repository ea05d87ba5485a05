"""Memory that a process can still get, as far as the system reports it."""

from __future__ import annotations

import importlib
import os
import sys
from pathlib import Path


def available_bytes() -> int | None:
    """Bytes of memory that this process can still get, or None if the system does not say.

    That is free or reclaimable memory with swap space, within the limits of the control groups and
    of the address space.  Linux reports it in a file.  Elsewhere psutil is asked if it is
    installed; Blender does not bring it along.  The last resort is a system call, which on macOS
    reports only the whole memory of the machine.
    """
    free = _free_on_linux()
    if free is None:
        free = _free_by_psutil()
    if free is None:
        free = _free_on_windows() if sys.platform == "win32" else _memory_of_machine()
    limits = (free, _free_in_groups(), _free_in_address_space())
    return None if free is None else min(limit for limit in limits if limit is not None)


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


def _free_in_address_space(process: Path = Path("/proc/self")) -> int | None:
    """Bytes that the limit of the address space leaves (``ulimit -v``)."""
    try:
        resource = importlib.import_module("resource")
        limit, _ = resource.getrlimit(resource.RLIMIT_AS)
        used = 1024 * _numbers(process / "status")["VmSize:"]
    except (ImportError, AttributeError, KeyError, OSError):
        return None
    return None if limit == resource.RLIM_INFINITY else max(limit - used, 0)


def _free_in_groups(
    root: Path = Path("/sys/fs/cgroup"), own: Path = Path("/proc/self/cgroup")
) -> int | None:
    """Bytes that the limits of this process's control groups leave, of a container or a user.

    Version 2 has one tree of groups, version 1 a tree for memory.  Limits of the groups above count
    as well.  Inside a container the root is often the container's own group.
    """
    found = [_free_in_group(root)]
    try:
        lines = [line.split(":", 2) for line in own.read_text().splitlines()]
    except OSError:
        lines = []
    for number, controllers, path in (line for line in lines if len(line) == 3):
        if number != "0" and "memory" not in controllers.split(","):
            continue
        tree = root if number == "0" else root / "memory"
        group = tree / path.strip("/")
        found += [
            _free_in_group(each)
            for each in (group, *group.parents)
            if tree in (each, *each.parents)
        ]
    return min((free for free in found if free is not None), default=None)


# Names of limit, use and what of that gives way, in versions 2 and 1.
_GROUP_FILES = (
    ("memory.max", "memory.current", "inactive_file"),
    ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"),
)


def _free_in_group(group: Path) -> int | None:
    for limit_name, used_name, cached_name in _GROUP_FILES:
        try:
            limit = int((group / limit_name).read_text())  # "max" is no number
            used = int((group / used_name).read_text())
            # Cached files count as used but give way.
            cached = _numbers(group / "memory.stat").get(cached_name, 0)
        except (OSError, ValueError):
            continue
        return max(limit - used + cached, 0)
    return None


def _numbers(path: Path) -> dict[str, int]:
    """Read lines that consist of a name and a number."""
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
