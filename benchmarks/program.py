"""Run the command line as its users do, in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import psutil

ROOT = Path(__file__).resolve().parents[1]
PREFIX = "adaptive-fairing: "

PAUSE = 0.02
"""Seconds between two looks at a running process."""

Look = Callable[[psutil.Process], None]


class Run(NamedTuple):
    """One run of the command line.

    Attributes
    ----------
    status
        Exit status, below 0 if it was killed.
    messages
        Lines of standard output and standard error.
    seconds
        By the wall clock.
    processor_seconds
        Of all its processes.
    megabytes
        Peak memory of the largest of them.
    """

    status: int
    messages: list[str]
    seconds: float
    processor_seconds: float
    megabytes: float


def run_program(*arguments: object, look: Look | None = None) -> Run:
    """Run the command line to its end; on request look at the process again and again."""
    command = [sys.executable, "-m", "adaptive_fairing", *map(str, arguments)]
    started, ended = time.perf_counter(), threading.Event()
    with tempfile.TemporaryFile("w+") as stream:
        process = subprocess.Popen(command, cwd=ROOT, stdout=stream, stderr=subprocess.STDOUT)
        watcher = threading.Thread(target=_watch, args=(process.pid, look, ended))
        watcher.start()
        _, status, usage = os.wait4(process.pid, 0)
        ended.set()
        watcher.join()
        stream.seek(0)
        messages = stream.read().splitlines()
    seconds = time.perf_counter() - started
    process.returncode = os.waitstatus_to_exitcode(status)
    unit = 1 if sys.platform == "darwin" else 1024
    processor = usage.ru_utime + usage.ru_stime
    return Run(process.returncode, messages, seconds, processor, usage.ru_maxrss * unit / 1e6)


def problems_of_run(run: Run) -> list[str]:
    """Tell whether exit status and messages are as promised."""
    problems = []
    if run.status not in (0, 1):
        problems.append(f"exit status {run.status}")
    if any(not line.startswith(PREFIX) for line in run.messages):
        problems.append("output that is no message")
    n_errors = sum(line.startswith(f"{PREFIX}error: ") for line in run.messages)
    if n_errors != run.status:
        problems.append(f"{n_errors} errors with status {run.status}")
    return problems


def _watch(process_id: int, look: Look | None, ended: threading.Event) -> None:
    while look is not None and not ended.wait(PAUSE):
        try:
            look(psutil.Process(process_id))
        except psutil.Error:  # it, or a child of it, has just ended
            continue
